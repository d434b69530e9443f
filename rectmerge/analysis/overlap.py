"""Agreement of two maps under a given placement: overlap and conflict, from their cells alone."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

CONFLICT_REACH_CELLS = 2  # a wall this close to the other map's wall agrees with it
MAX_WALL_CELLS = 5_000  # of larger maps an evenly spaced sample
SAMPLED_CELLS = 80_000  # likewise, for areas


@dataclass(frozen=True, slots=True)
class Agreement:
    """Overlap and conflict of two maps under a placement; every figure lies in 0..1.

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
    return AgreementMeter(a, b).measure(pixels)


def cells_of(mask: NDArray[np.bool_], max_cells: int) -> NDArray[np.intp]:
    """List the cells (row, col) of a mask, shape (N, 2): all of them, or about `max_cells`, evenly spaced."""
    flat = np.flatnonzero(mask)
    flat = flat[:: -(-len(flat) // max_cells) or 1]
    return np.stack(np.divmod(flat, mask.shape[1]), axis=1)


def area_overlap(a: NDArray[np.uint8], b: NDArray[np.uint8], pixels: NDArray[np.float64]) -> tuple[float, float]:
    """Return the common area of two masks as a share of the smaller one, and of their union.

    Parameters
    ----------
    a, b
        Masks, 0 or 1. Of a large `a` every second or later row and column stands for all.
    pixels
        Matrix, shape (2, 3), from pixels of `b` to pixels of `a`.
    """
    step = max(1, round((a.size / SAMPLED_CELLS) ** 0.5))
    sampled = np.ascontiguousarray(a[::step, ::step])
    on_a = cv2.warpAffine(b, pixels / step, sampled.shape[::-1], flags=cv2.INTER_NEAREST)
    common = float(cv2.countNonZero(cv2.bitwise_and(on_a, sampled))) * step**2
    area_a = float(cv2.countNonZero(sampled)) * step**2
    area_b = float(cv2.countNonZero(b)) * float(np.linalg.det(pixels[:, :2]))
    return min(1.0, common / max(1.0, min(area_a, area_b))), min(1.0, common / max(1.0, area_a + area_b - common))


class AgreementMeter:
    """Two maps prepared to measure their agreement under several placements.

    Parameters
    ----------
    a, b
        The maps; placements take pixels of B to pixels of A.
    """

    def __init__(self, a: OccupancyGrid, b: OccupancyGrid) -> None:
        self._a, self._b = _MapLayers.from_grid(a), _MapLayers.from_grid(b)

    def measure(self, pixels: Similarity) -> Agreement:
        """Measure overlap and conflict of B placed on A by the pixel similarity `pixels`."""
        a, b = self._a, self._b
        overlap, iou = area_overlap(a.free, b.free, pixels.matrix)
        conflicting_b, known_b = b.walls_on(a, pixels)
        conflicting_a, known_a = a.walls_on(b, pixels.inverse())
        conflict = (conflicting_a + conflicting_b) / max(1, known_a + known_b)
        return Agreement(overlap=overlap, iou=iou, conflict=conflict)


@dataclass(frozen=True, slots=True, eq=False)
class _MapLayers:
    """Masks of a map (free, known, free away from walls) and its walls as (u, v)."""

    free: NDArray[np.uint8]
    is_known: NDArray[np.bool_]
    is_open: NDArray[np.bool_]
    walls: NDArray[np.intp]

    @classmethod
    def from_grid(cls, grid: OccupancyGrid) -> _MapLayers:
        free, occupied = grid.free, grid.occupied
        size = 2 * CONFLICT_REACH_CELLS + 1
        near = cv2.dilate(occupied.view(np.uint8), np.ones((size, size), np.uint8)).astype(np.bool_)
        walls = cells_of(occupied, MAX_WALL_CELLS)[:, ::-1]
        return cls(free.view(np.uint8), free | near, free & ~near, walls)

    def walls_on(self, other: _MapLayers, pixels: Similarity) -> tuple[int, int]:
        """Count this map's walls that fall on open space of another, and those on known cells."""
        u, v = np.rint(pixels.apply(self.walls)).astype(np.intp).T
        height, width = other.is_known.shape
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        cells = v[inside], u[inside]
        return int(other.is_open[cells].sum()), int(other.is_known[cells].sum())
