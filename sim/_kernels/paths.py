"""Compiled loops of driving: shortest paths on a grid."""

from __future__ import annotations

import heapq
import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def cost_to_goal(price: NDArray[np.float64], goal_row: int, goal_col: int) -> NDArray[np.float64]:
    """Return the cost in cells from every cell to the goal (Dijkstra, eight neighbours); inf where price is inf."""
    cost = np.full(price.shape, np.inf)
    cost[goal_row, goal_col] = 0.0
    heap = [(0.0, goal_row * price.shape[1] + goal_col)]
    while len(heap) > 0:
        _expand(price, cost, heap)
    return cost


@kernel
def find_best_goal(
    price: NDArray[np.float64], row: int, col: int, pay: NDArray[np.float32], most: float
) -> tuple[NDArray[np.float64], int]:
    """Search outwards from a cell (Dijkstra) for the least cost less pay, pay being > 0.

    `most` bounds the pay. Returns the costs, final up to that of the best cell, and that cell, row-major; -1 for none.
    """
    cost = np.full(price.shape, np.inf)
    cost[row, col] = 0.0
    heap = [(0.0, row * price.shape[1] + col)]
    best, best_at = np.inf, -1
    while len(heap) > 0 and heap[0][0] - most < best:
        so_far, at = heap[0]
        gain = pay.flat[at]
        if gain > 0 and so_far - gain < best:
            best, best_at = so_far - gain, at
        _expand(price, cost, heap)
    return cost, best_at


@kernel
def _expand(price: NDArray[np.float64], cost: NDArray[np.float64], heap: list[tuple[float, int]]) -> None:
    """Pop the cheapest cell and push the neighbours that it makes cheaper."""
    height, width = price.shape
    so_far, at = heapq.heappop(heap)
    row, col = at // width, at % width
    if so_far > cost[row, col]:
        return
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


@kernel
def descend(cost: NDArray[np.float64], row: int, col: int) -> NDArray[np.int64]:
    """Follow the steepest descent of a cost field to its goal; return rows (row, col)."""
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
