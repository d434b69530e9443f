"""Compiled loops of mapping: log-odds by ray tracing."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel
from sim._kernels.cell_walk import begin_walk, walk_on


@kernel
def trace_scans(
    starts: NDArray[np.float64],
    ends: NDArray[np.float64],
    kinds: NDArray[np.int8],
    log_odds: NDArray[np.float32],
    hit: float,
    miss: float,
    limit: float,
) -> None:
    """Add scans to a log-odds grid in place; each scan changes a cell once, and its hits win over its misses.

    `starts` (S, 2) and `ends` (S, B, 2) are in cells, (col, row) with cell k spanning k..k+1; `kinds` (S, B) is 1
    for a hit, 0 for free all the way, -1 for nothing known.
    """
    height, width = log_odds.shape
    marked = np.full((height, width), -1, dtype=np.int32)
    for s in range(starts.shape[0]):
        for b in range(ends.shape[1]):
            col, row = math.floor(ends[s, b, 0]), math.floor(ends[s, b, 1])
            inside = 0 <= col < width and 0 <= row < height
            if kinds[s, b] == 1 and inside and marked[row, col] != s:
                marked[row, col] = s
                log_odds[row, col] = min(limit, log_odds[row, col] + hit)
        for b in range(ends.shape[1]):
            if kinds[s, b] >= 0:
                _trace(starts[s, 0], starts[s, 1], ends[s, b, 0], ends[s, b, 1], s, marked, log_odds, miss, -limit)


@kernel
def _trace(
    x0: float,
    y0: float,
    x1: float,
    y1: float,
    scan: int,
    marked: NDArray[np.int32],
    log_odds: NDArray[np.float32],
    miss: float,
    lowest: float,
) -> None:
    """Lower every cell that a ray crosses before its last cell."""
    height, width = log_odds.shape
    row, col, steps, next_y, next_x, per_y, per_x = begin_walk(x0, y0, x1, y1)
    for _ in range(steps):
        if 0 <= col < width and 0 <= row < height and marked[row, col] != scan:
            marked[row, col] = scan
            log_odds[row, col] = max(lowest, log_odds[row, col] + miss)
        row, col, next_y, next_x = walk_on(row, col, next_y, next_x, per_y, per_x)
