"""Compiled loops of exploration: the first scan that shows each cell."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def see_scans(
    poses: NDArray[np.float64],
    angles: NDArray[np.float64],
    ranges: NDArray[np.float64],
    shortest: float,
    longest: float,
    cell: float,
    first_scan: int,
    seen_free: NDArray[np.int32],
    is_hit: NDArray[np.bool_],
) -> None:
    """Record in `seen_free` the first scan with a ray across a cell (-1: none), and in `is_hit` the cells of the ends.

    Ranges below the shortest are no readings; rays of more than the longest, inf included, have no end.
    """
    height, width = seen_free.shape
    for s in range(poses.shape[0]):
        x, y = poses[s, 0] / cell, poses[s, 1] / cell
        for b in range(angles.shape[0]):
            length = ranges[s, b]
            if not length >= shortest:
                continue
            is_end = length <= longest
            length = min(length, longest) / cell
            heading = poses[s, 2] + angles[b]
            end_x, end_y = x + length * math.cos(heading), y + length * math.sin(heading)
            _cross(x, y, end_x, end_y, first_scan + s, seen_free)
            row, col = math.floor(end_y), math.floor(end_x)
            if is_end and 0 <= row < height and 0 <= col < width:
                is_hit[row, col] = True


@kernel
def _cross(x0: float, y0: float, x1: float, y1: float, scan: int, seen_free: NDArray[np.int32]) -> None:
    """Mark every cell that a segment crosses before the one it ends in (Amanatides and Woo 1987)."""
    height, width = seen_free.shape
    col, row = math.floor(x0), math.floor(y0)
    steps = abs(math.floor(x1) - col) + abs(math.floor(y1) - row)
    dx, dy = x1 - x0, y1 - y0
    step_x, step_y = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    per_x = abs(1.0 / dx) if dx != 0.0 else np.inf
    per_y = abs(1.0 / dy) if dy != 0.0 else np.inf
    next_x = ((col + 1 - x0) if dx > 0 else (x0 - col)) * per_x if dx != 0.0 else np.inf
    next_y = ((row + 1 - y0) if dy > 0 else (y0 - row)) * per_y if dy != 0.0 else np.inf
    for _ in range(steps):
        if 0 <= col < width and 0 <= row < height and seen_free[row, col] < 0:
            seen_free[row, col] = scan
        if next_x < next_y:
            col += step_x
            next_x += per_x
        else:
            row += step_y
            next_y += per_y
