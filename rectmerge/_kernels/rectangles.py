"""Maximal empty rectangles, the largest or all, on column-major run lengths."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import ZERO, kernel
from rectmerge._kernels.runs import best_in_interval, interval_end


@kernel
def largest(runs: NDArray[np.uint16]) -> tuple[int, int, int, int]:
    """Return (x, y, w, h) of the largest rectangle; ties: smallest x, bottom row, top row. All 0 if none is free."""
    width, height = runs.shape
    stack = np.empty((height + 1, 2), np.int32)
    best_area, best_x, best_top, best_bottom = 0, 0, 0, 1  # Alg. 1, lines 4-6
    for x in range(width):  # Alg. 1, line 7
        y = ZERO
        while y < height:
            stop, longest, may_begin_here = interval_end(runs, x, y, height)
            if may_begin_here and longest * (stop - y) > best_area:
                area, top, bottom = best_in_interval(runs, x, y, stop, best_area + 1, stack)
                if area > 0:
                    best_area, best_x, best_top, best_bottom = area, x, top, bottom
            y = max(stop, y + 1)
    rows = best_bottom - best_top
    return best_x, best_top, best_area // rows, rows if best_area > 0 else 0


@kernel
def every_maximal(runs: NDArray[np.uint16], least_width: int, least_height: int, boxes: NDArray[np.int32]) -> int:
    """Write all maximal rectangles into `boxes` (N, 4) as far as it reaches; return their number."""
    width, height = runs.shape
    tops, widths = np.empty(height + 1, np.int32), np.empty(height + 1, np.int32)
    count = 0
    for x in range(width):
        blocked_left = -1
        depth = 0
        for y in range(height + 1):
            here = np.int32(runs[x, y]) if y < height else np.int32(0)
            top = y
            while depth > 0 and widths[depth - 1] > here:
                depth -= 1
                top = tops[depth]
                # the stack bounds it above and below, the run on the right
                is_maximal = x == 0 or blocked_left >= top
                if is_maximal and widths[depth] >= least_width and y - top >= least_height:
                    if count < len(boxes):
                        boxes[count, 0], boxes[count, 1] = x, top
                        boxes[count, 2], boxes[count, 3] = widths[depth], y - top
                    count += 1
            if here > 0 and (depth == 0 or widths[depth - 1] < here):
                tops[depth], widths[depth] = top, here
                depth += 1
            if x > 0 and y < height and runs[x - 1, y] == 0:
                blocked_left = y
    return count
