"""Shrinking a map to its working grid, without its specks, keeping where in each cell the walls' surface lies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel

LARGEST_SPECK = 4  # cells


@kernel
def is_speck(cells: NDArray[np.int8], row: int, col: int) -> bool:
    """Whether the occupied component at a cell is small and free all around."""
    height, width = cells.shape
    rows = np.empty(LARGEST_SPECK, np.int64)
    cols = np.empty(LARGEST_SPECK, np.int64)
    rows[0], cols[0] = row, col
    count, done = 1, 0
    while done < count:
        r0, c0 = rows[done], cols[done]
        done += 1
        for r in range(r0 - 1, r0 + 2):
            for c in range(c0 - 1, c0 + 2):
                if r < 0 or c < 0 or r >= height or c >= width or cells[r, c] < 0:
                    return False
                if cells[r, c] > 0:
                    seen = False
                    for k in range(count):
                        seen = seen or (rows[k] == r and cols[k] == c)
                    if not seen:
                        if count == LARGEST_SPECK:
                            return False
                        rows[count], cols[count] = r, c
                        count += 1
    return True


@kernel
def known_bounds(cells: NDArray[np.int8]) -> tuple[int, int, int, int]:
    """First and last row and column that hold a known cell; (H, -1, W, -1) where none does."""
    height, width = cells.shape
    top, bottom, left, right = height, -1, width, -1
    for r in range(height):
        first = 0
        while first < width and cells[r, first] < 0:
            first += 1
        if first == width:
            continue
        last = width - 1
        while cells[r, last] < 0:
            last -= 1
        top, bottom = min(top, r), r
        left, right = min(left, first), max(right, last)
    return top, bottom, left, right


@kernel
def shrink(
    cells: NDArray[np.int8], bounds: tuple[int, int, int, int], factor: float
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32], NDArray[np.float64], NDArray[np.float64], int]:
    """Count free, occupied and surface cells per working cell, sum the surface cells' (u, v), count specks.

    `cells` is -1 unknown, 0 free, 100 occupied; a surface cell is occupied with a free neighbour.
    """
    top, bottom, left, right = bounds
    height, width = cells.shape
    shape = (int(np.ceil((bottom - top + 1) / factor)), int(np.ceil((right - left + 1) / factor)))
    free, occupied, surface = np.zeros(shape, np.int32), np.zeros(shape, np.int32), np.zeros(shape, np.int32)
    sum_u, sum_v = np.zeros(shape), np.zeros(shape)
    column = np.empty(right - left + 1, np.int64)
    for c in range(len(column)):
        column[c] = min(shape[1] - 1, int((c + 0.5) / factor))
    specks = 0
    for r in range(top, bottom + 1):
        y = min(shape[0] - 1, int((r - top + 0.5) / factor))
        for c in range(left, right + 1):
            if cells[r, c] < 0:
                continue
            x = column[c - left]
            if cells[r, c] == 0:
                free[y, x] += 1
                continue
            beside_free, alike = 0, 0
            for i in range(max(0, r - 1), min(height, r + 2)):
                for j in range(max(0, c - 1), min(width, c + 2)):
                    beside_free += cells[i, j] == 0
                    alike += cells[i, j] > 0
            if beside_free + alike == 9 and alike < LARGEST_SPECK and is_speck(cells, r, c):
                specks += 1
                free[y, x] += 1
                continue
            occupied[y, x] += 1
            if beside_free:
                surface[y, x] += 1
                sum_u[y, x] += c
                sum_v[y, x] += r
    return free, occupied, surface, sum_u, sum_v, specks


@kernel
def specks_of_few(cells: NDArray[np.int8], weights: NDArray[np.int32], most: int) -> NDArray[np.bool_]:
    """Mark the specks of a working grid that stand for at most `most` cells each of the map."""
    marked = np.zeros(cells.shape, np.bool_)
    for r in range(1, cells.shape[0] - 1):
        for c in range(1, cells.shape[1] - 1):
            marked[r, c] = cells[r, c] > 0 and weights[r, c] <= most and is_speck(cells, r, c)
    return marked
