"""Compiled loops of the simulation: shortest paths on a grid, and log-odds mapping by ray tracing."""

from __future__ import annotations

import heapq
import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def cost_to_goal(price: NDArray[np.float64], goal_row: int, goal_col: int) -> NDArray[np.float64]:
    """Dijkstra over eight neighbours: the cost in cells from every cell to the goal; inf where price is inf."""
    height, width = price.shape
    cost = np.full((height, width), np.inf)
    cost[goal_row, goal_col] = 0.0
    heap = [(0.0, goal_row * width + goal_col)]
    while len(heap) > 0:
        so_far, at = heapq.heappop(heap)
        row, col = at // width, at % width
        if so_far > cost[row, col]:
            continue
        for dr in range(-1, 2):
            for dc in range(-1, 2):
                r, c = row + dr, col + dc
                if (dr == 0 and dc == 0) or r < 0 or c < 0 or r >= height or c >= width:
                    continue
                if dr != 0 and dc != 0 and not (np.isfinite(price[row, c]) and np.isfinite(price[r, col])):
                    continue  # no cutting of corners
                new = so_far + 0.5 * (price[row, col] + price[r, c]) * math.sqrt(dr * dr + dc * dc)
                if new < cost[r, c]:
                    cost[r, c] = new
                    heapq.heappush(heap, (new, r * width + c))
    return cost


@kernel
def descend(cost: NDArray[np.float64], row: int, col: int) -> NDArray[np.int64]:
    """Follow the steepest descent of a cost field to its goal; rows (row, col)."""
    height, width = cost.shape
    path = np.empty((height * width, 2), dtype=np.int64)
    count = 0
    while True:
        path[count, 0], path[count, 1] = row, col
        count += 1
        best_row, best_col, best = row, col, 0.0
        for r in range(max(0, row - 1), min(height, row + 2)):
            for c in range(max(0, col - 1), min(width, col + 2)):
                if (r == row and c == col) or not (np.isfinite(cost[row, c]) and np.isfinite(cost[r, col])):
                    continue
                slope = (cost[row, col] - cost[r, c]) / math.sqrt((r - row) ** 2 + (c - col) ** 2)
                if slope > best:
                    best_row, best_col, best = r, c, slope
        if best == 0.0:
            return path[:count].copy()
        row, col = best_row, best_col


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
    """Lower every cell a ray crosses before the cell it ends in (Amanatides and Woo 1987)."""
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
