"""Rectangles of free cells: the largest, and all maximal empty ones."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError

LONGEST_SIDE_CELLS = np.iinfo(np.uint16).max


@dataclass(frozen=True, slots=True, order=True)
class Rectangle:
    """Rectangle of columns x .. x + w - 1 and rows y .. y + h - 1 of a grid, in cells.

    Examples
    --------
    >>> Rectangle(2, 0, 3, 4).area
    12
    >>> Rectangle(2, 0, 3, 4).centre
    (3.0, 1.5)
    """

    x: int
    y: int
    w: int
    h: int

    @property
    def area(self) -> int:
        """Number of cells."""
        return self.w * self.h

    @property
    def centre(self) -> tuple[float, float]:
        """Centre (u, v) in pixels, where the centre of cell (0, 0) is the origin."""
        return self.x + (self.w - 1) / 2, self.y + (self.h - 1) / 2


def largest_rectangle(free: NDArray[np.bool_]) -> Rectangle | None:
    """Find the largest rectangle of free cells.

    Parameters
    ----------
    free
        Mask of shape (H, W).

    Returns
    -------
    Rectangle or None
        None where no cell is free. Of equal areas the one with the smallest x, then the smallest bottom row, then the
        smallest top row.

    Raises
    ------
    InputError
        If `free` is not a 2-D mask with at least one cell and sides of at most 65535.
    """
    from rectmerge._kernels import rectangles as kernels

    x, y, w, h = kernels.largest(run_lengths(free))
    return Rectangle(x, y, w, h) if h else None


def maximal_rectangles(free: NDArray[np.bool_], *, min_side_cells: int = 1) -> NDArray[np.int32]:
    """List all maximal empty rectangles: the rectangles of free cells that can grow on no side.

    Parameters
    ----------
    free
        Mask of shape (H, W).
    min_side_cells
        Rectangles with a shorter side are left out.

    Returns
    -------
    NDArray
        Shape (N, 4), rows (x, y, w, h), ordered by x, then by bottom row, then by top row from low to high.

    Raises
    ------
    InputError
        As `largest_rectangle`; also if `min_side_cells` is below 1.

    Notes
    -----
    A rectangle under a histogram of run lengths is maximal upwards, downwards and to the right; it is maximal to the
    left where the column before it is blocked in one of its rows. Time O(H W), whatever N.

    Examples
    --------
    >>> maximal_rectangles(np.array([[1, 1], [1, 0]], dtype=bool)).tolist()
    [[0, 0, 2, 1], [0, 0, 1, 2]]
    """
    from rectmerge._kernels import rectangles as kernels

    if min_side_cells < 1:
        raise InputError(f"min_side_cells must be >= 1, got {min_side_cells}")
    runs = run_lengths(free)
    boxes = np.empty((1024, 4), np.int32)
    if (count := kernels.every_maximal(runs, min_side_cells, min_side_cells, boxes)) > len(boxes):
        boxes = np.empty((count, 4), np.int32)
        kernels.every_maximal(runs, min_side_cells, min_side_cells, boxes)
    return boxes[:count].copy()


def run_lengths(free: NDArray[np.bool_]) -> NDArray[np.uint16]:
    """Count the contiguous free cells from each cell to the right, column-major: shape (W, H).

    Raises
    ------
    InputError
        As `largest_rectangle`.
    """
    from rectmerge._kernels.runs import free_runs

    mask = np.asarray(free)  # eq. (1)
    if mask.ndim != 2 or mask.dtype != np.bool_ or mask.size == 0:
        raise InputError(f"free must be a mask of shape (H, W) with at least one cell, got {mask.dtype} {mask.shape}")
    if max(mask.shape) > LONGEST_SIDE_CELLS:
        raise InputError(f"a grid may have at most {LONGEST_SIDE_CELLS} cells a side, got {mask.shape}")
    turned = cv2.transpose(np.ascontiguousarray(mask).view(np.uint8))
    columns: NDArray[np.uint8] = np.asarray(turned, np.uint8).reshape(mask.shape[::-1])
    runs = np.empty(columns.shape, np.uint16)
    free_runs(columns, runs)  # Alg. 1, line 3
    return runs
