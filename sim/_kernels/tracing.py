"""Compiled loops of mapping: log-odds by ray tracing."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


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
    """Lower every cell that a ray crosses before its last cell (Amanatides and Woo 1987)."""
    col, row = math.floor(x0), math.floor(y0)
    steps = abs(math.floor(x1) - col) + abs(math.floor(y1) - row)
    dx, dy = x1 - x0, y1 - y0
    step_x, step_y = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    per_x = abs(1.0 / dx) if dx != 0.0 else np.inf
    per_y = abs(1.0 / dy) if dy != 0.0 else np.inf
    next_x = ((col + 1 - x0) if dx > 0 else (x0 - col)) * per_x if dx != 0.0 else np.inf
    next_y = ((row + 1 - y0) if dy > 0 else (y0 - row)) * per_y if dy != 0.0 else np.inf
    for _ in range(steps):
        if 0 <= col < log_odds.shape[1] and 0 <= row < log_odds.shape[0] and marked[row, col] != scan:
            marked[row, col] = scan
            log_odds[row, col] = max(lowest, log_odds[row, col] + miss)
        if next_x < next_y:
            col += step_x
            next_x += per_x
        else:
            row += step_y
            next_y += per_y
