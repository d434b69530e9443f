"""How two maps agree under a given placement: overlap and conflict, from their cells alone."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

CONFLICT_REACH_CELLS = 2  # a wall this close to the other map's wall agrees with it
MOST_WALL_CELLS = 20_000  # an evenly spaced choice of more says the same


@dataclass(frozen=True, slots=True)
class Agreement:
    """How two maps agree under a placement; every figure lies in 0..1.

    Parameters
    ----------
    overlap
        ``|free A and T free B| / min(|free A|, |T free B|)``, areas in A's frame.
    iou
        The same intersection over the union.
    conflict
        Of the wall cells of either map that fall on known cells of the other, the share that falls on free space
        away from any wall. 0 where no wall falls on known cells.
    """

    overlap: float
    iou: float
    conflict: float


def measure_agreement(a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity) -> Agreement:
    """Measure overlap and conflict of B placed on A by the pixel similarity `pixels`."""
    return Comparison(a, b).measure(pixels)


class Comparison:
    """Two maps made ready to be compared under several placements.

    Parameters
    ----------
    a, b
        The maps; placements take pixels of B to pixels of A.
    """

    def __init__(self, a: OccupancyGrid, b: OccupancyGrid) -> None:
        self._a, self._b = _Side.of(a), _Side.of(b)

    def measure(self, pixels: Similarity) -> Agreement:
        """Measure overlap and conflict of B placed on A by the pixel similarity `pixels`."""
        a, b = self._a, self._b
        area_a, area_b = float(a.free_cells), float(b.free_cells) * pixels.scale**2
        size = a.free.shape[::-1]
        b_free = cv2.warpAffine(b.free, pixels.matrix, size, flags=cv2.INTER_NEAREST)
        common = float(cv2.countNonZero(cv2.bitwise_and(b_free, a.free)))
        bad_b, seen_b = b.walls_on(a, pixels)
        bad_a, seen_a = a.walls_on(b, pixels.inverse())
        return Agreement(
            overlap=min(1.0, common / max(1.0, min(area_a, area_b))),
            iou=min(1.0, common / max(1.0, area_a + area_b - common)),
            conflict=(bad_a + bad_b) / max(1, seen_a + seen_b),
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """One of the maps: its free mask, where it is known, where it is free away from walls, and its walls as (u, v)."""

    free: NDArray[np.uint8]
    free_cells: int
    is_known: NDArray[np.bool_]
    is_open: NDArray[np.bool_]
    walls: NDArray[np.intp]

    @classmethod
    def of(cls, grid: OccupancyGrid) -> _Side:
        free, occupied = grid.free, grid.occupied
        size = 2 * CONFLICT_REACH_CELLS + 1
        near = cv2.dilate(occupied.view(np.uint8), np.ones((size, size), np.uint8)).astype(np.bool_)
        walls = np.argwhere(occupied)[:, ::-1]  # (N, 2)
        walls = walls[:: -(-len(walls) // MOST_WALL_CELLS) or 1]
        return cls(free.view(np.uint8), int(np.count_nonzero(free)), free | occupied | near, free & ~near, walls)

    def walls_on(self, other: _Side, pixels: Similarity) -> tuple[int, int]:
        """Count this map's walls that fall on open space of another, and those on known cells."""
        u, v = np.rint(pixels.apply(self.walls)).astype(np.intp).T
        height, width = other.is_known.shape
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        cells = v[inside], u[inside]
        return int(other.is_open[cells].sum()), int(other.is_known[cells].sum())
