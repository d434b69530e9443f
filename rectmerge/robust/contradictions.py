"""Contradictions of two maps under placements: walls of one on solid floor of the other, and corners it does not show.

Where a map knows the floor all around, a wall that another map has there cannot be missing by chance of where the robot
looked. Beside unknown space it can: rays end, doors stand open, and cells are seen free that are not.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels import contradictions as kernels
from rectmerge._kernels.placements import invert
from rectmerge.robust.detail_params import ContradictParams
from rectmerge.robust.detailed_map import DetailedMap
from rectmerge.robust.features import Features

Column = NDArray[np.float64]  # (N,)


class Contradictions(NamedTuple):
    """Contradictions of two maps under N placements, as shares, shape (N,); see `rectmerge.robust.wall_agreement`."""

    on_floor: Column
    beside: Column
    corners_missed: Column
    corners_denied: Column


def measure(
    placements: NDArray[np.float64],
    working: tuple[Features, Features],
    maps: tuple[DetailedMap, DetailedMap],
    params: ContradictParams,
) -> Contradictions:
    """Measure how far two maps contradict each other.

    Parameters
    ----------
    placements
        Shape (N, 4): rows (a, b, tx, ty) of B on A between the working grids.
    working, maps
        Of A and of B.
    params
        Parameters of the contradictions.
    """
    a, b = maps
    forward = _between_detailed(placements, working, maps)
    back = invert(forward)
    faces, corners = np.zeros((len(placements), 4)), np.zeros((len(placements), 3))
    for moved, own, other in ((forward, b, a), (back, a, b)):
        # a finer map has more faces of the same wall: they count by the coarser map's cells
        faces += np.minimum(1.0, np.hypot(moved[:, 0], moved[:, 1]))[:, None] * _count_faces(moved, own, other, params)
        corners += _count_corners(moved, own, other, params) / 2
    shown = corners[:, kernels.CORNERS] + params.added_corners
    return Contradictions(
        on_floor=faces[:, kernels.ON_FLOOR] / np.maximum(1.0, faces[:, kernels.JUDGED]),
        beside=faces[:, kernels.BESIDE] / np.maximum(1.0, faces[:, kernels.JUDGED_LONG]),
        corners_missed=corners[:, kernels.MISSED] / shown,
        corners_denied=corners[:, kernels.DENIED] / shown,
    )


def _count_faces(
    placements: NDArray[np.float64], own: DetailedMap, other: DetailedMap, params: ContradictParams
) -> NDArray[np.float64]:
    """Count the faces of one map as the other meets them, shape (N, 4), from a sample of them."""
    sample = own.faces.spaced(params.max_faces)
    counts = np.zeros((len(placements), 4), np.int64)
    kernels.count_faces(
        placements, sample.points, sample.is_long,
        other.state, other.to_wall, other.to_unknown, params.face_reaches_cells, counts,
    )  # fmt: skip
    return counts * np.float64(len(own.faces.points) / max(1, len(sample.points)))


def _count_corners(
    placements: NDArray[np.float64], own: DetailedMap, other: DetailedMap, params: ContradictParams
) -> NDArray[np.int64]:
    """Count the corners of one map as the other meets them, shape (N, 3)."""
    counts = np.zeros((len(placements), 3), np.int64)
    kernels.count_corners(
        placements,
        own.corners,
        own.corner_kinds,
        other.to_corner,
        other.to_unknown,
        params.corner_reaches_cells,
        counts,
    )
    return counts


def _between_detailed(
    placements: NDArray[np.float64], working: tuple[Features, Features], maps: tuple[DetailedMap, DetailedMap]
) -> NDArray[np.float64]:
    """Turn placements between working grids into placements between detailed grids, shape (N, 4)."""
    (on_a, on_b), (a, b) = working, maps
    finer_a, finer_b = on_a.factor / a.factor, on_b.factor / b.factor
    middle = on_b.offset - b.offset / finer_b  # of B's detailed origin, in its working grid
    cos, sin, tx, ty = placements.T
    x = (cos * middle[0] - sin * middle[1] + tx - on_a.offset[0]) * finer_a + a.offset[0]
    y = (sin * middle[0] + cos * middle[1] + ty - on_a.offset[1]) * finer_a + a.offset[1]
    return np.column_stack([placements[:, :2] * (finer_a / finer_b), x, y])
