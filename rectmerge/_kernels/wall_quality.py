"""Thickness and straightness of the walls of a map at single wall cells."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel

DIRECTIONS = np.array([[0, 1], [1, 0], [1, 1], [1, -1]])  # down and right: along the axes, then along the diagonals
SMOOTHING = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16  # nearly a Gaussian of one cell


@kernel
def run_through(mask: NDArray[np.bool_], row: int, col: int, down: int, right: int) -> int:
    """Count the cells of the run through a cell in the direction (down, right)."""
    height, width = mask.shape
    count = 1
    for sign in (-1, 1):
        r, c = row + sign * down, col + sign * right
        while 0 <= r < height and 0 <= c < width and mask[r, c]:
            count += 1
            r, c = r + sign * down, c + sign * right
    return count


@kernel
def thickness_at(mask: NDArray[np.bool_], cells: NDArray[np.intp]) -> NDArray[np.float64]:
    """Measure the shortest of the four runs through each cell (row, col) of a mask, in cells."""
    shortest = np.empty(len(cells))
    for k in range(len(cells)):
        r, c = cells[k]
        shortest[k] = np.inf
        for d in range(4):
            step = 1.0 if d < 2 else math.sqrt(2.0)
            shortest[k] = min(shortest[k], step * run_through(mask, r, c, DIRECTIONS[d, 0], DIRECTIONS[d, 1]))
    return shortest


@kernel
def coherence_at(mask: NDArray[np.bool_], cells: NDArray[np.intp], reach: int) -> NDArray[np.float64]:
    """Return the coherence of the structure tensor around each cell: 1 along a line, about 0 in a cloud of points.

    The tensor sums over the cells within `reach` to all sides.
    """
    height, width = mask.shape
    side = 2 * reach + 1 + 6  # two cells for smoothing, one for the slope, on each side
    patch, half, soft = np.empty((side, side)), np.zeros((side, side)), np.zeros((side, side))
    coherences = np.empty(len(cells))
    for k in range(len(cells)):
        for i in range(side):
            for j in range(side):
                r, c = cells[k, 0] + i - reach - 3, cells[k, 1] + j - reach - 3
                patch[i, j] = 1.0 if 0 <= r < height and 0 <= c < width and mask[r, c] else 0.0
        for i in range(side):
            for j in range(2, side - 2):
                total = 0.0
                for t in range(5):
                    total += SMOOTHING[t] * patch[i, j + t - 2]
                half[i, j] = total
        for i in range(2, side - 2):
            for j in range(2, side - 2):
                total = 0.0
                for t in range(5):
                    total += SMOOTHING[t] * half[i + t - 2, j]
                soft[i, j] = total
        xx, yy, xy = 0.0, 0.0, 0.0
        for i in range(3, side - 3):
            for j in range(3, side - 3):
                dx, dy = soft[i, j + 1] - soft[i, j - 1], soft[i + 1, j] - soft[i - 1, j]
                xx += dx * dx
                yy += dy * dy
                xy += dx * dy
        coherences[k] = math.hypot(xx - yy, 2 * xy) / max(xx + yy, 1e-9)
    return coherences
