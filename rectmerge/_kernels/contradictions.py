"""Counts of the faces and corners of one map that another map contradicts under placements."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel

UNKNOWN, FREE, WALL = 0, 1, 2  # states of a cell
JUDGED, ON_FLOOR, JUDGED_LONG, BESIDE = 0, 1, 2, 3  # columns of the counts of faces
CORNERS, MISSED, DENIED = 0, 1, 2  # columns of the counts of corners


@kernel
def count_faces(
    placements: NDArray[np.float64],
    points: NDArray[np.float64],
    is_long: NDArray[np.bool_],
    state: NDArray[np.uint8],
    to_wall: NDArray[np.float32],
    to_unknown: NDArray[np.float32],
    reaches: tuple[float, ...],
    counts: NDArray[np.int64],
) -> None:
    """Count the faces of one map that the other judges, and those that it contradicts.

    Parameters
    ----------
    placements
        Shape (N, 4): rows (a, b, tx, ty) from the faces' grid to the other map's.
    points, is_long
        Shape (F, 2) and (F,): the faces.
    state, to_wall, to_unknown
        The other map: its cells (h, w), and their distances to any wall and to unknown space (h, w), in its cells.
    reaches
        In cells of the coarser map: distance to a wall within which a face in unknown space is judged; distances to any
        wall and to unknown space beyond which floor is solid, and beyond which a long face stands beside its partner.
    counts
        Shape (N, 4): the columns named above.
    """
    height, width = state.shape
    for n in range(len(placements)):
        a, b, tx, ty = placements[n]
        cell = max(1.0, math.hypot(a, b))
        hidden, floor, beside = reaches[0] * cell, reaches[1] * cell, reaches[2] * cell
        for i in range(len(points)):
            u = math.floor(a * points[i, 0] - b * points[i, 1] + tx + 0.5)
            v = math.floor(b * points[i, 0] + a * points[i, 1] + ty + 0.5)
            if u < 0 or v < 0 or u >= width or v >= height:
                continue
            wall = to_wall[v, u]
            if state[v, u] == UNKNOWN and wall > hidden:
                continue
            counts[n, JUDGED] += 1
            counts[n, JUDGED_LONG] += is_long[i]
            if state[v, u] != FREE:
                continue
            unknown = to_unknown[v, u]
            counts[n, ON_FLOOR] += wall > floor and unknown > floor
            counts[n, BESIDE] += is_long[i] and wall > beside and unknown > beside


@kernel
def count_corners(
    placements: NDArray[np.float64],
    points: NDArray[np.float64],
    kinds: NDArray[np.int64],
    to_corner: NDArray[np.float32],
    to_unknown: NDArray[np.float32],
    reaches: tuple[float, ...],
    counts: NDArray[np.int64],
) -> None:
    """Count the corners of one map that the other must show, and those that it does not.

    Parameters
    ----------
    placements
        Shape (N, 4): rows (a, b, tx, ty) from the corners' grid to the other map's.
    points, kinds
        Shape (C, 2) and (C,): the corners, 0 of a room or 1 of a jamb.
    to_corner, to_unknown
        The other map: distances to a corner of each kind (2, h, w), and to unknown space (h, w), in its cells.
    reaches
        In cells of the coarser map: distance to unknown space within which a corner may be hidden; distance within
        which a corner has a partner; distance to a corner of the other kind beyond which it is missed, and to unknown
        space beyond which it is denied as well.
    counts
        Shape (N, 3): the columns named above.
    """
    _, height, width = to_corner.shape
    for n in range(len(placements)):
        a, b, tx, ty = placements[n]
        cell = max(1.0, math.hypot(a, b))
        hidden, near, denied = reaches[0] * cell, reaches[1] * cell, reaches[2] * cell
        for i in range(len(points)):
            u = math.floor(a * points[i, 0] - b * points[i, 1] + tx + 0.5)
            v = math.floor(b * points[i, 0] + a * points[i, 1] + ty + 0.5)
            if u < 0 or v < 0 or u >= width or v >= height:
                continue
            own, other, unknown = to_corner[kinds[i], v, u], to_corner[1 - kinds[i], v, u], to_unknown[v, u]
            if unknown <= hidden and own > near and other > near:
                continue
            counts[n, CORNERS] += 1
            if own > near and other > denied:
                counts[n, MISSED] += 1
                counts[n, DENIED] += unknown > denied
