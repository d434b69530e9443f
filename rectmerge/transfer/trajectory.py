"""Trajectories of map B in the form of the TUM RGB-D benchmark, carried to map A."""

from __future__ import annotations

import logging

import numpy as np
from numpy.typing import NDArray

from rectmerge.elastic.transform import BentTransform
from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from rectmerge.transfer.carrier import Carrier
from rectmerge.transfer.poses import abbreviate, parse_finite, turn_quaternion

COLUMNS = ("time", "x", "y", "z", "qx", "qy", "qz", "qw")
LOGGER = logging.getLogger("rectmerge")


def carry_trajectory(text: str, name: str, b_to_a: Similarity | BentTransform) -> str:
    """Carry the poses of a trajectory from B's map frame to A's.

    Parameters
    ----------
    text
        Rows "time x y z qx qy qz qw" between blanks; lines that begin with # are comments.
    name
        The file's name, for messages.
    b_to_a
        The placement; where it bends, each pose turns by the turn at its place.

    Returns
    -------
    str
        The same rows: x, y and the quaternion carried, time and z as they are.

    Raises
    ------
    InputError
        If a row is not eight finite numbers, a quaternion is zero, or there is no row.

    Notes
    -----
    J. Sturm et al., IROS 2012, DOI 10.1109/IROS.2012.6385773. Where the bend was not fitted at a place, the logger
    `rectmerge` warns.
    """
    lines = text.splitlines()
    numbered = [(k, line.split()) for k, line in enumerate(lines) if line.strip() and not line.startswith("#")]
    if not numbered:
        raise InputError(f"{name}: it holds no poses; each row must be {' '.join(COLUMNS)}")
    carrier = Carrier(b_to_a)
    try:
        poses = np.array([_pose(k + 1, cells) for k, cells in numbered])  # (N, 7): x, y, z and the quaternion
        places = carrier.carry(poses[:, :2])
        for (k, cells), pose, place in zip(numbered, poses, places, strict=True):
            lines[k] = _row(f"line {k + 1}", cells, pose, place, carrier)
    except InputError as error:
        raise InputError(f"{name}: not a trajectory of TUM's form: {error}") from None
    if carrier.outside:
        LOGGER.warning("%d poses lie outside the bend: they are carried as the nearest edge of it is", carrier.outside)
    return "\n".join(lines) + "\n"


def _pose(line: int, cells: list[str]) -> list[float]:
    if len(cells) != len(COLUMNS):
        raise InputError(f"line {line} must be {' '.join(COLUMNS)}, got {abbreviate(' '.join(cells))}")
    parse_finite(f"line {line}", cells[0])
    return [parse_finite(f"line {line}", cell) for cell in cells[1:]]


def _row(label: str, cells: list[str], pose: NDArray[np.float64], place: NDArray[np.float64], carrier: Carrier) -> str:
    """Write a row anew: time and z keep their text."""
    qx, qy, qz, qw = pose[3:].tolist()
    turned = turn_quaternion(label, (qx, qy, qz, qw), carrier.turn_at(pose[:2].tolist()))
    numbers = [f"{number:.9g}" for number in turned]
    return " ".join([cells[0], *(f"{number:.6f}" for number in place), cells[3], *numbers])
