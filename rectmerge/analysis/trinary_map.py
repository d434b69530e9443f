"""Cells of a map in three values (unknown, free, occupied), with a description of each occupied cell."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.wall_cells import SPECK, describe_walls
from rectmerge.analysis.fringe import without_fringe
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid


@dataclass(frozen=True, slots=True, eq=False)
class MapCells:
    """Cells of a map, and kinds and normals of its W occupied cells.

    Parameters
    ----------
    values
        -1 unknown, 0 free, 100 occupied, shape (H, W).
    rows, cols
        Shape (W,): rows and columns of the occupied cells.
    kinds
        Shape (W,), int8: inside a wall, on its surface, or a speck, as `rectmerge._kernels.wall_cells` numbers them.
    normals
        Shape (W, 2), float32: (nx, ny) into the free space next to a surface cell; (0, 0) where there is none.
    """

    values: NDArray[np.int8]
    rows: NDArray[np.intp]
    cols: NDArray[np.intp]
    kinds: NDArray[np.int8]
    normals: NDArray[np.float32]

    @classmethod
    def from_values(cls, values: NDArray[np.int8], *, max_speck_cells: int = 4) -> MapCells:
        """Find the walls of a map given as -1 unknown, 0 free, 100 occupied."""
        values = _read_only(values)
        occupied = np.flatnonzero(values > 0)
        kinds, normals = describe_walls(values, occupied, max_speck_cells)
        rows, cols = np.divmod(occupied, values.shape[1])
        return cls(values, rows, cols, kinds, normals)

    @classmethod
    def from_grid(cls, grid: OccupancyGrid, *, max_speck_cells: int = 4) -> MapCells:
        """Find the walls of a map; a fringe of unknown cells in front of them is taken as free."""
        cells = cls.from_values(trinary(grid), max_speck_cells=max_speck_cells)
        walls = np.zeros(grid.shape, np.bool_)
        walls[cells.rows, cells.cols] = cells.kinds != SPECK
        filled = without_fringe(cells.values, walls)
        return cells if filled is cells.values else cls.from_values(filled, max_speck_cells=max_speck_cells)

    def mirrored(self) -> MapCells:
        """Return the cells of the mirror image, left and right exchanged."""
        return replace(
            self,
            values=_read_only(self.values[:, ::-1]),
            cols=self.values.shape[1] - 1 - self.cols,
            normals=self.normals * np.array([-1, 1], np.float32),
        )

    def roughness(self) -> float:
        """Return the share of pairs of neighbouring known cells that are one free and one occupied, 0..1."""
        values, differ, pairs = self.values, 0, 0
        for later, earlier in ((values[1:], values[:-1]), (values[:, 1:], values[:, :-1])):
            is_known = (later >= 0) & (earlier >= 0)
            differ += int(np.count_nonzero(is_known & (later != earlier)))
            pairs += int(np.count_nonzero(is_known))
        return differ / max(1, pairs)

    def free_counts(self, row_ends: NDArray[np.intp], col_ends: NDArray[np.intp]) -> NDArray[np.int32]:
        """Count the free cells between successive ends (h + 1,) of rows and (w + 1,) of columns, shape (h, w)."""
        total = cv2.integral((self.values == FREE).view(np.uint8))
        at_ends = np.asarray(total, np.int32)[row_ends][:, col_ends]
        counts: NDArray[np.int32] = np.diff(np.diff(at_ends, axis=0), axis=1)
        return counts


def _read_only(values: NDArray[np.int8]) -> NDArray[np.int8]:
    """Return cells in one block that cannot be written, as kernels are compiled for."""
    cells = np.ascontiguousarray(values).view()
    cells.flags.writeable = False
    return cells


def trinary(grid: OccupancyGrid) -> NDArray[np.int8]:
    """Read a grid as -1 unknown, 0 free, 100 occupied, shape (H, W)."""
    if ((grid.occupancy == FREE) | (grid.occupancy == OCCUPIED) | (grid.occupancy == UNKNOWN)).all():
        return grid.occupancy
    cells = np.full(grid.shape, UNKNOWN, np.int8)
    cells[grid.free] = FREE
    cells[grid.occupied] = OCCUPIED
    return _read_only(cells)
