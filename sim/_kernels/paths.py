"""Compiled loops of driving: shortest paths on a grid."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel

DIAGONAL = math.sqrt(2.0)
APART = -2  # in place of the cell before: in no bucket


@kernel
def cost_to_goal(price: NDArray[np.float64], goal_row: int, goal_col: int) -> NDArray[np.float64]:
    """Return the cost in cells from every cell to the goal (Dijkstra, eight neighbours); inf where price is inf."""
    prices, cost = price.ravel(), np.full(price.size, np.inf)
    first, after, before = _make_queue(prices)
    level, waiting = 0, _enter(goal_row * price.shape[1] + goal_col, 0.0, cost, first, after, before)
    while waiting > 0:
        at = first[level & (len(first) - 1)]
        if at < 0:
            level += 1
            continue
        _leave(at, cost, first, after, before)
        waiting += _expand(at, price.shape[1], prices, cost, first, after, before) - 1
    return cost.reshape(price.shape)


@kernel
def find_best_goal(
    price: NDArray[np.float64], row: int, col: int, pay: NDArray[np.float32], most: float
) -> tuple[NDArray[np.float64], int]:
    """Search outwards from a cell (Dijkstra) for the least cost less pay, pay being > 0.

    `most` bounds the pay. Returns the costs, final up to that of the best cell, and that cell, row-major; -1 for none.
    Of equal cells it takes the one with the lower cost, then the earlier one.
    """
    prices, pays, cost = price.ravel(), pay.ravel(), np.full(price.size, np.inf)
    first, after, before = _make_queue(prices)
    level, waiting = 0, _enter(row * price.shape[1] + col, 0.0, cost, first, after, before)
    best, best_cost, best_at = np.inf, np.inf, -1
    while waiting > 0 and level - most <= best:
        at = first[level & (len(first) - 1)]
        if at < 0:
            level += 1
            continue
        _leave(at, cost, first, after, before)
        so_far, gain = cost[at], pays[at]
        if gain > 0 and (so_far - gain, so_far, at) < (best, best_cost, best_at):
            best, best_cost, best_at = so_far - gain, so_far, at
        waiting += _expand(at, price.shape[1], prices, cost, first, after, before) - 1
    return cost.reshape(price.shape), best_at


@kernel
def _make_queue(price: NDArray[np.float64]) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Return an empty queue of cells: the first cell of each bucket, and of each cell the next and the one before.

    Bucket k holds the costs from k to k + 1, modulo a power of two of buckets, which one step cannot span (R. B. Dial,
    Communications of the ACM 1969, doi:10.1145/363269.363610). -1 stands for no cell, `APART` for one in no bucket.
    """
    largest = 0.0
    for value in price:
        if np.isfinite(value):
            largest = max(largest, value)
    buckets = 4
    while buckets < largest * DIAGONAL + 2:
        buckets *= 2
    after, before = np.full(price.size, -1, dtype=np.int32), np.full(price.size, APART, dtype=np.int32)
    return np.full(buckets, -1, dtype=np.int32), after, before


@kernel
def _enter(
    at: int,
    new: float,
    cost: NDArray[np.float64],
    first: NDArray[np.int32],
    after: NDArray[np.int32],
    before: NDArray[np.int32],
) -> int:
    """Give a cell a lower cost and its place in the queue; return 1 where it was in no bucket, else 0."""
    was_apart = before[at] == APART
    if not was_apart:
        _leave(at, cost, first, after, before)
    cost[at] = new
    bucket = int(new) & (len(first) - 1)
    after[at], before[at] = first[bucket], -1
    if first[bucket] >= 0:
        before[first[bucket]] = at
    first[bucket] = at
    return 1 if was_apart else 0


@kernel
def _leave(
    at: int,
    cost: NDArray[np.float64],
    first: NDArray[np.int32],
    after: NDArray[np.int32],
    before: NDArray[np.int32],
) -> None:
    """Take a cell out of its bucket."""
    if before[at] >= 0:
        after[before[at]] = after[at]
    else:
        first[int(cost[at]) & (len(first) - 1)] = after[at]
    if after[at] >= 0:
        before[after[at]] = before[at]
    before[at] = APART


@kernel
def _expand(
    at: int,
    width: int,
    price: NDArray[np.float64],
    cost: NDArray[np.float64],
    first: NDArray[np.int32],
    after: NDArray[np.int32],
    before: NDArray[np.int32],
) -> int:
    """Lower the costs of the neighbours that a cell makes cheaper; return how many of them came into the queue."""
    col = at % width
    so_far, here = cost[at], price[at]
    entered = 0
    for up in (-width, 0, width):
        if at + up < 0 or at + up >= len(price):
            continue
        for across in range(-1 if col > 0 else 0, 2 if col < width - 1 else 1):
            there = at + up + across
            is_diagonal = up != 0 and across != 0
            if is_diagonal and not (np.isfinite(price[at + up]) and np.isfinite(price[at + across])):
                continue  # no cutting of corners
            new = so_far + 0.5 * (here + price[there]) * (DIAGONAL if is_diagonal else 1.0)
            if new < cost[there]:
                entered += _enter(there, new, cost, first, after, before)
    return entered


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
