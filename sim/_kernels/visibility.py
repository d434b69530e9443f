"""Compiled loops of exploration: the first scan that shows each cell."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel
from sim._kernels.cell_walk import begin_walk, walk_on


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
            row, col, steps, next_y, next_x, per_y, per_x = begin_walk(x, y, end_x, end_y)
            for _ in range(steps):
                if 0 <= col < width and 0 <= row < height and seen_free[row, col] < 0:
                    seen_free[row, col] = first_scan + s
                row, col, next_y, next_x = walk_on(row, col, next_y, next_x, per_y, per_x)
            row, col = math.floor(end_y), math.floor(end_x)
            if is_end and 0 <= row < height and 0 <= col < width:
                is_hit[row, col] = True
