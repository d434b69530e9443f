"""Outside of a building, where a picture of a map is white though no robot has been there.

Drawn plans are white around the building, and so are maps that were saved without unknown cells. There the walls of
another map contradict nothing.
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.derived import derive
from rectmerge.grid import UNKNOWN, OccupancyGrid
from rectmerge.robust.params import OutsideParams


def without_outside(grid: OccupancyGrid, params: OutsideParams) -> OccupancyGrid:
    """Return a map with its white outside unknown; the same object where it has none."""
    return derive(grid, (without_outside, params), lambda: _without_outside(grid, params))


def _without_outside(grid: OccupancyGrid, params: OutsideParams) -> OccupancyGrid:
    free, known = grid.free, grid.occupancy != UNKNOWN
    hull = _hull(known)
    if hull is None:
        return grid
    area = int(np.count_nonzero(hull))
    depth = cv2.distanceTransform(np.pad(hull, 1), cv2.DIST_L2, cv2.DIST_MASK_5)[1:-1, 1:-1]
    low, high = params.edge_cells
    edge = (depth > low) & (depth <= high)
    if not (edge.any() and free.any()):
        return grid
    is_picture = np.count_nonzero(known) >= params.min_known_share * area
    is_picture &= np.count_nonzero(free & edge) >= params.min_free_edge * np.count_nonzero(edge)
    if not is_picture:
        return grid
    inside = free & ~_rolled_over(free | (depth <= high), params.gap_share * math.sqrt(area))
    if np.count_nonzero(inside) < params.min_inside_share * np.count_nonzero(free):
        return grid
    return replace(grid, occupancy=np.where(free & ~inside, np.int8(UNKNOWN), grid.occupancy))


def _hull(known: NDArray[np.bool_]) -> NDArray[np.uint8] | None:
    """Fill the convex hull of the known cells; None where they are too few to fill it."""
    rows = np.flatnonzero(known.any(axis=1))
    if len(rows) == 0:
        return None
    first = known[rows].argmax(axis=1)
    last = known.shape[1] - 1 - known[rows, ::-1].argmax(axis=1)
    box = len(rows) * int(last.max() - first.min() + 1)
    if 3 * np.count_nonzero(known) < box:  # the hull of what fills the rows of a box is at least half of it
        return None
    ends = np.concatenate([np.column_stack([first, rows]), np.column_stack([last, rows])]).astype(np.int32)
    hull = np.zeros(known.shape, np.uint8)
    return np.asarray(cv2.fillConvexPoly(hull, cv2.convexHull(ends), 1), np.uint8)


def _rolled_over(is_open: NDArray[np.bool_], radius: float) -> NDArray[np.bool_]:
    """Return the cells that a disc covers while it rolls in from beyond the map over open cells."""
    width = math.ceil(radius) + 2
    padded = np.pad(is_open, width, constant_values=True).view(np.uint8)
    room = cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_5) > radius
    _, labels = cv2.connectedComponents(room.view(np.uint8), connectivity=4)
    away = cv2.distanceTransform((labels != labels[0, 0]).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
    covered: NDArray[np.bool_] = away[width:-width, width:-width] <= radius + 0.5
    return covered
