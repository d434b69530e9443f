"""Compiled walk along a segment, from cell to cell (J. Amanatides and A. Woo, Eurographics 1987).

It is no generator: numba cannot call a generator that it has loaded from its cache.
"""

from __future__ import annotations

import math

import numpy as np

from rectmerge._kernels.compiling import kernel


@kernel
def begin_walk(x0: float, y0: float, x1: float, y1: float) -> tuple[int, int, int, float, float, float, float]:
    """Return the first cell (row, col), the steps to the last cell, and the walk's own numbers.

    These are the lengths to the next row and to the next column, in lengths of the segment, and what each grows by.
    """
    col, row = math.floor(x0), math.floor(y0)
    steps = abs(math.floor(x1) - col) + abs(math.floor(y1) - row)
    dx, dy = x1 - x0, y1 - y0
    per_x = 1.0 / dx if dx != 0.0 else np.inf
    per_y = 1.0 / dy if dy != 0.0 else np.inf
    next_x = ((col + 1 - x0) if dx > 0 else (x0 - col)) * abs(per_x) if dx != 0.0 else np.inf
    next_y = ((row + 1 - y0) if dy > 0 else (y0 - row)) * abs(per_y) if dy != 0.0 else np.inf
    return row, col, steps, next_y, next_x, per_y, per_x


@kernel
def walk_on(
    row: int, col: int, next_y: float, next_x: float, per_y: float, per_x: float
) -> tuple[int, int, float, float]:
    """Return the next cell, and the lengths from there; `per_y` and `per_x` have the signs of the segment."""
    if next_x < next_y:
        return row, col + (1 if per_x > 0 else -1), next_y, next_x + abs(per_x)
    return row + (1 if per_y > 0 else -1), col, next_y + abs(per_y), next_x
