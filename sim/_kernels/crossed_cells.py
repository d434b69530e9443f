"""Compiled walk along a segment, cell by cell."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from rectmerge._kernels.compiling import kernel


@kernel
def crossed_cells(x0: float, y0: float, x1: float, y1: float) -> Iterator[tuple[int, int]]:
    """List the cells (row, col) that a segment crosses before the one it ends in (Amanatides and Woo 1987)."""
    col, row = math.floor(x0), math.floor(y0)
    steps = abs(math.floor(x1) - col) + abs(math.floor(y1) - row)
    dx, dy = x1 - x0, y1 - y0
    step_x, step_y = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    per_x = abs(1.0 / dx) if dx != 0.0 else np.inf
    per_y = abs(1.0 / dy) if dy != 0.0 else np.inf
    next_x = ((col + 1 - x0) if dx > 0 else (x0 - col)) * per_x if dx != 0.0 else np.inf
    next_y = ((row + 1 - y0) if dy > 0 else (y0 - row)) * per_y if dy != 0.0 else np.inf
    for _ in range(steps):
        yield row, col
        if next_x < next_y:
            col += step_x
            next_x += per_x
        else:
            row += step_y
            next_y += per_y
