"""Specks: patches of a few cells that differ from all cells around them, left in a map by noise."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import FREE, OccupancyGrid


def remove_specks(grid: OccupancyGrid, *, max_speck_cells: int = 2) -> OccupancyGrid:
    """Remove small patches that stand alone: occupied or unknown ones in free space, free ones elsewhere.

    Parameters
    ----------
    grid
        The map; it is not changed.
    max_speck_cells
        Largest number of cells of a speck, cells that touch at a corner counted together; 0 changes nothing.

    Returns
    -------
    OccupancyGrid
        The map with specks in free space made free, and free specks given the value of their most occupied neighbour.

    Raises
    ------
    InputError
        If `max_speck_cells` is negative.

    Notes
    -----
    This cleans whole maps, for the paper's method and for floor plans. `rectmerge._kernels.wall_cells.is_speck` tests
    one occupied cell at a time, for `robust`, which frees specks on its working grid only.

    Examples
    --------
    >>> cells = np.zeros((5, 5), np.int8)
    >>> cells[2, 2] = 100
    >>> int(remove_specks(OccupancyGrid(cells)).occupancy.max())
    0
    """
    if max_speck_cells < 0:
        raise InputError(f"max_speck_cells must be >= 0, got {max_speck_cells}")
    cells = grid.occupancy.copy()
    cells[small_patches(~grid.free, max_speck_cells)] = FREE
    free = grid.free | (cells == FREE)
    stray = small_patches(free, max_speck_cells)
    # a free patch takes the greatest value around it, read with the free cells hidden
    around = cv2.dilate(
        np.where(free, -1, cells).astype(np.int16), np.ones((3, 3), np.uint8), iterations=max_speck_cells
    )
    cells[stray] = around[stray].astype(np.int8)
    return OccupancyGrid(cells, grid.resolution, grid.origin)


def small_patches(mask: NDArray[np.bool_], max_cells: int) -> NDArray[np.bool_]:
    """Mark the connected patches of a mask, shape (H, W), of at most `max_cells` cells that do not touch the border."""
    _, patches, stats, _ = cv2.connectedComponentsWithStats(mask.view(np.uint8), connectivity=8)
    height, width = mask.shape
    left, top, w, h, area = stats.T
    inside = (left > 0) & (top > 0) & (left + w < width) & (top + h < height)
    small = (area <= max_cells) & inside
    small[0] = False  # the background
    marked: NDArray[np.bool_] = small[patches]
    return marked
