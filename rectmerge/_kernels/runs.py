"""Run lengths of free cells and the survey of one column, on column-major grids: ``runs[x, y]``, y contiguous."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def free_runs(free_columns: NDArray[np.uint8], runs: NDArray[np.uint16]) -> None:
    """Fill runs[x, y] = contiguous free cells from (x, y) to the right; `free_columns` is (W, H) of 0 and 1."""
    width, height = free_columns.shape
    last = runs[width - 1]
    for y in range(height):
        last[y] = free_columns[width - 1, y]
    for x in range(width - 2, -1, -1):
        ahead, here, free = runs[x + 1], runs[x], free_columns[x]
        for y in range(height):
            here[y] = (ahead[y] + 1) * free[y]  # eq. (2)


@kernel
def interval_end(runs: NDArray[np.uint16], x: int, begin: int, end: int) -> tuple[int, int, bool]:
    """Find the end of the free cells from (x, begin) downwards; also their longest run, and if any is blocked left."""
    column = runs[x]
    left = runs[x - 1] if x > 0 else column
    longest, is_blocked_left = 0, x == 0
    for y in range(begin, end):
        if column[y] == 0:
            return y, longest, is_blocked_left
        longest = max(longest, int(column[y]))
        is_blocked_left |= bool(left[y] == 0)
    return end, longest, is_blocked_left


@kernel
def best_in_interval(
    runs: NDArray[np.uint16], x: int, begin: int, end: int, least_area: int, stack: NDArray[np.int32]
) -> tuple[int, int, int]:
    """Survey the free cells [begin, end) of column x for their best rectangle; return (area, top, bottom).

    Only rectangles that no free column extends to the left count, `bottom` is one past the last row, and area 0 means
    that nothing reaches `least_area`. Ties: smallest bottom, then smallest top. `stack` (H + 1, 2) is scratch.
    """
    column = runs[x]
    left = runs[x - 1] if x > 0 else column
    blocked_left = end if x == 0 else begin - 1  # last row up to here whose left neighbour is not free
    best_area, best_top, best_bottom = least_area - 1, -1, -1
    depth = np.uint64(0)
    open_top, open_width = np.int32(begin), np.int32(0)  # the widest open rectangle; those below it are on the stack
    for y in range(begin, end + 1):  # Alg. 1, line 8
        width = np.int32(column[y]) if y < end else np.int32(0)
        if width > open_width:  # Alg. 1, lines 9-13
            stack[depth, 0], stack[depth, 1] = open_top, open_width
            depth += np.uint64(1)
            open_top, open_width = np.int32(y), width
        elif width < open_width:  # Alg. 1, line 14
            top = open_top
            while open_width > width:
                top = open_top
                area = int(open_width) * (y - int(top))  # Alg. 1, lines 15-17
                # of one bottom row, a later one is narrower and begins higher up: it wins a tie
                if area >= best_area and blocked_left >= top and (area > best_area or y == best_bottom):
                    best_area, best_top, best_bottom = area, int(top), y  # Alg. 1, lines 18-21
                depth -= np.uint64(1)
                open_top, open_width = stack[depth, 0], stack[depth, 1]
            if open_width < width:
                stack[depth, 0], stack[depth, 1] = open_top, open_width
                depth += np.uint64(1)
                open_top, open_width = top, width
        if y < end and x > 0 and left[y] == 0:
            blocked_left = y
    if best_top < 0:
        return 0, 0, 0
    return best_area, best_top, best_bottom
