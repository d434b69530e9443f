"""Occupied cells of a map: kinds (inside, surface, speck), surface normals, and their counts on a working grid."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel

INSIDE, SURFACE, SPECK = 0, 1, 2  # kinds of occupied cells: no free neighbour, some, and small with free all around


@kernel
def is_speck(cells: NDArray[np.int8], row: int, col: int, max_cells: int) -> bool:
    """Return if the occupied component at a cell has at most `max_cells` cells and is surrounded by free cells.

    It follows one component from one cell; `rectmerge.analysis.specks` labels the components of a whole mask.
    """
    if max_cells < 1:
        return False
    height, width = cells.shape
    rows = np.empty(max_cells, np.int64)
    cols = np.empty(max_cells, np.int64)
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
                        if count == max_cells:
                            return False
                        rows[count], cols[count] = r, c
                        count += 1
    return True


@kernel
def known_bounds(cells: NDArray[np.int8]) -> tuple[int, int, int, int]:
    """Return the first and last row and column that hold a known cell; (H, -1, W, -1) where none does."""
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
def describe_walls(
    cells: NDArray[np.int8], occupied: NDArray[np.int64], max_speck: int
) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """Return the kind of each occupied cell, given by its flat index, and the normal into the free space next to it.

    `cells` is -1 unknown, 0 free, 100 occupied; specks have at most `max_speck` cells. A normal is (0, 0) where the
    free cells within two cells are balanced, and inside walls.
    """
    height, width = cells.shape
    kinds = np.full(len(occupied), INSIDE, np.int8)
    normals = np.zeros((len(occupied), 2), np.float32)
    for k in range(len(occupied)):
        r, c = occupied[k] // width, occupied[k] % width
        near_free, near_occupied = 0, 0
        for i in range(max(0, r - 1), min(height, r + 2)):
            for j in range(max(0, c - 1), min(width, c + 2)):
                near_free += cells[i, j] == 0
                near_occupied += cells[i, j] > 0
        if near_free == 0:
            continue
        kinds[k] = SURFACE
        if near_free + near_occupied == 9 and near_occupied <= max_speck and is_speck(cells, r, c, max_speck):
            kinds[k] = SPECK
        nx, ny = 0.0, 0.0
        for i in range(max(0, r - 2), min(height, r + 3)):
            for j in range(max(0, c - 2), min(width, c + 3)):
                if cells[i, j] == 0:
                    nx += j - c
                    ny += i - r
        length = math.hypot(nx, ny)
        if length > 0:
            normals[k, 0], normals[k, 1] = nx / length, ny / length
    return kinds, normals


@kernel
def count_walls(
    rows: NDArray[np.int64],
    cols: NDArray[np.int64],
    kinds: NDArray[np.int8],
    bounds: tuple[int, int, int, int],
    factor: float,
    starts: tuple[float, float],
    shape: tuple[int, int],
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32], NDArray[np.float64], NDArray[np.float64]]:
    """Count specks, other occupied cells and surface cells per working cell, and sum the surface cells' (u, v).

    The grid begins by `starts` (rows, columns) before the bounds.
    """
    specks, occupied, surface = np.zeros(shape, np.int32), np.zeros(shape, np.int32), np.zeros(shape, np.int32)
    sum_u, sum_v = np.zeros(shape), np.zeros(shape)
    for k in range(len(rows)):
        y = min(shape[0] - 1, int((rows[k] - bounds[0] + 0.5 + starts[0]) / factor))
        x = min(shape[1] - 1, int((cols[k] - bounds[2] + 0.5 + starts[1]) / factor))
        if kinds[k] == SPECK:
            specks[y, x] += 1
            continue
        occupied[y, x] += 1
        if kinds[k] == SURFACE:
            surface[y, x] += 1
            sum_u[y, x] += cols[k]
            sum_v[y, x] += rows[k]
    return specks, occupied, surface, sum_u, sum_v


@kernel
def light_specks(
    cells: NDArray[np.int8], weights: NDArray[np.int32], max_weight: int, max_speck: int
) -> NDArray[np.bool_]:
    """Mark the cells of specks of a working grid that stand for at most `max_weight` cells of the map."""
    marked = np.zeros(cells.shape, np.bool_)
    for r in range(1, cells.shape[0] - 1):
        for c in range(1, cells.shape[1] - 1):
            marked[r, c] = cells[r, c] > 0 and weights[r, c] <= max_weight and is_speck(cells, r, c, max_speck)
    return marked
