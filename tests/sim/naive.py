"""Slow and obvious twins of the simulation's fast parts."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from sim.world import SCAN_HEIGHT_M, World


def cast(world: World, pose: NDArray[np.float64], angles: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
    """Meet every ray with every edge of every obstacle that reaches through the laser's plane."""
    heading = pose[2] + angles
    along = np.stack([np.cos(heading), np.sin(heading)], axis=-1)  # (N, 2)
    nearest = np.full(len(angles), np.inf)
    for prism in (p for p in world.obstacles if p.bottom <= SCAN_HEIGHT_M < p.top):
        for start, end in zip(prism.outline, np.roll(prism.outline, -1, axis=0), strict=True):
            edge, away = end - start, start - pose[:2]
            cross = along[:, 0] * edge[1] - along[:, 1] * edge[0]
            with np.errstate(divide="ignore", invalid="ignore"):
                distance = (away[0] * edge[1] - away[1] * edge[0]) / cross
                share = (away[0] * along[:, 1] - away[1] * along[:, 0]) / cross
            hit = (distance > 0) & (share >= 0) & (share <= 1)
            nearest = np.where(hit, np.minimum(nearest, distance), nearest)
    return np.where(nearest < reach, nearest, np.inf)


def trace_scan(
    start: NDArray[np.float64],
    ends: NDArray[np.float64],
    kinds: NDArray[np.int8],
    log_odds: NDArray[np.float64],
    hit: float,
    miss: float,
    limit: float,
) -> None:
    """Add one scan to a log-odds grid: first the cells that were hit, then every other cell that a ray crosses."""
    hits = {cell_of(end) for end, kind in zip(ends, kinds, strict=True) if kind == 1}
    crossed = {c for end, kind in zip(ends, kinds, strict=True) if kind >= 0 for c in cells_before_end(start, end)}
    for cells, change in ((hits, hit), (crossed - hits, miss)):
        for row, col in cells:
            if 0 <= row < log_odds.shape[0] and 0 <= col < log_odds.shape[1]:
                log_odds[row, col] = min(limit, max(-limit, log_odds[row, col] + change))


def cells_before_end(start: NDArray[np.float64], end: NDArray[np.float64]) -> set[tuple[int, int]]:
    """The cells a segment crosses but the one it ends in: cut it wherever it crosses a grid line."""
    cuts = [0.0, 1.0]
    for k in (0, 1):
        lines = range(math.ceil(min(start[k], end[k])), math.floor(max(start[k], end[k])) + 1)
        cuts += [(line - start[k]) / (end[k] - start[k]) for line in lines if end[k] != start[k]]
    cuts = sorted(cut for cut in cuts if 0 <= cut <= 1)
    middles = [(p + q) / 2 for p, q in itertools.pairwise(cuts) if q > p]
    return {cell_of(start + (end - start) * share) for share in middles} - {cell_of(end)}


def cell_of(point: NDArray[np.float64]) -> tuple[int, int]:
    """(row, col) of the cell that a point (col, row) lies in."""
    return math.floor(point[1]), math.floor(point[0])


def cost_to_goal(price: NDArray[np.float64], row: int, col: int) -> NDArray[np.float64]:
    """Relax every step between neighbours until nothing gets cheaper (Bellman and Ford)."""
    cost = np.full(price.shape, np.inf)
    cost[row, col] = 0.0
    cells = [(r, c) for r in range(price.shape[0]) for c in range(price.shape[1])]
    steps = [(p, q) for p in cells for q in cells if max(abs(p[0] - q[0]), abs(p[1] - q[1])) == 1]
    while True:
        before = cost.copy()
        for (r, c), (s, d) in steps:
            if np.isfinite(price[r, d]) and np.isfinite(price[s, c]):
                cost[s, d] = min(cost[s, d], cost[r, c] + 0.5 * (price[r, c] + price[s, d]) * math.hypot(r - s, c - d))
        if np.array_equal(cost, before):
            return cost
