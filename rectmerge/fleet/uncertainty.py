"""Uncertainty of placements: the information of all agreeing pairs, inverted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.fleet.complex_similarity import ComplexSimilarity

UNSURE_SPAN = 0.01  # of the span: standard deviation of a pair's placement whose method gives no covariance


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """Placement of map B on map A with its uncertainty.

    Parameters
    ----------
    a, b
        Names of the maps.
    at
        Point in A's map frame about which the covariance is.
    covariance
        Shape (4, 4) over (angle, ln scale, tx, ty), in A's map frame.
    """

    a: str
    b: str
    at: complex
    covariance: NDArray[np.float64]


def unsure(span: float, radius: float) -> NDArray[np.float64]:
    """Return a covariance where a method gives none: 1 % of the span each way, at the radius of the shared area."""
    length = UNSURE_SPAN * span
    return np.diag([(length / radius) ** 2, (length / radius) ** 2, length**2, length**2])


def covariances(
    poses: Mapping[str, ComplexSimilarity],
    centres: Mapping[str, complex],
    measurements: Sequence[Measurement],
    reference: str,
) -> dict[str, NDArray[np.float64]]:
    """Return the covariance of each placement relative to the reference.

    Parameters
    ----------
    poses
        From each map's frame to the reference's, by name.
    centres
        Point of each map, in its own map frame, about which its covariance shall be.
    measurements
        Placements of pairs; they connect all maps.
    reference
        Map whose placement is certain.

    Returns
    -------
    dict
        Shape (4, 4) each over (angle, ln scale, tx, ty) about the map's centre, in the reference's map frame. Empty
        where the measurements leave a map free.
    """
    names = [name for name in poses if name != reference]
    column = {name: 4 * index for index, name in enumerate(names)}
    information = np.zeros((4 * len(names), 4 * len(names)))
    for measured in measurements:
        at = poses[measured.a].apply(np.array(measured.at))
        jacobian = np.zeros((4, 4 * len(names)))
        for name, sign in ((measured.a, -1.0), (measured.b, 1.0)):
            if name != reference:
                arm = complex(at - poses[name].apply(np.array(centres[name])))
                jacobian[:, column[name] : column[name] + 4] = sign * _shift_at(arm, poses[measured.a].turn)
        information += jacobian.T @ np.linalg.pinv(measured.covariance, hermitian=True) @ jacobian
    unit = 1 / np.sqrt(np.maximum(np.diag(information), np.finfo(np.float64).tiny))
    try:
        joint = np.linalg.inv(information * np.outer(unit, unit)) * np.outer(unit, unit)
    except np.linalg.LinAlgError:
        return {}
    return {name: np.array(joint[at : at + 4, at : at + 4], np.float64) for name, at in column.items()}


def _shift_at(arm: complex, turn: complex) -> NDArray[np.float64]:
    """Return the derivative of (angle, ln scale, tx, ty) at the end of an arm by the same at its start, shape (4, 4).

    The translation is read in a frame in which the arm's frame is turned and scaled by `turn`.
    """
    along = np.array([[-arm.imag, arm.real, 1.0, 0.0], [arm.real, arm.imag, 0.0, 1.0]])
    back = 1 / turn
    rotated = np.array([[back.real, -back.imag], [back.imag, back.real]]) @ along
    return np.vstack([np.eye(4)[:2], rotated])
