"""Slow and obvious twins of the simulation's fast parts."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from sim.lidar import Reading
from sim.world import Prism, World


def cast(world: World, pose: NDArray[np.float64], angles: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
    """Meet every ray with every edge of every obstacle."""
    nearest = meet_edges(world.obstacles, pose, angles)
    return np.where(nearest < reach, nearest, np.inf)


def read(
    world: World,
    pose: NDArray[np.float64],
    angles: NDArray[np.float64],
    reach: float,
    height: float,
    circles: Iterable[tuple[float, float, float]] = (),
) -> Reading:
    """Meet every ray with every edge at a height, and with circles (x, y, radius); panes count up to the first hit."""
    solid, glass = (
        [p for p in prisms if p.bottom <= height < p.top] for prisms in (world.walls + world.furniture, world.glass)
    )
    ranges = meet_edges(solid, pose, angles)
    for k, angle in enumerate(pose[2] + angles):
        for x, y, radius in circles:
            ahead = (x - pose[0]) * math.cos(angle) + (y - pose[1]) * math.sin(angle)
            aside = (y - pose[1]) * math.cos(angle) - (x - pose[0]) * math.sin(angle)
            if abs(aside) <= radius < math.hypot(x - pose[0], y - pose[1]) and ahead > 0:
                ranges[k] = min(ranges[k], ahead - math.sqrt(radius**2 - aside**2))
    ranges = np.where(ranges < reach, ranges, np.inf)
    panes = meet_edges(glass, pose, angles)
    return Reading(ranges, np.where(panes < np.minimum(ranges, reach), panes, np.inf))


def meet_edges(prisms: Iterable[Prism], pose: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far every ray gets before any edge of any prism; a billionth of an edge is added at both ends."""
    heading = pose[2] + angles
    along = np.stack([np.cos(heading), np.sin(heading)], axis=-1)  # (N, 2)
    nearest = np.full(len(angles), np.inf)
    for prism in prisms:
        for start, end in zip(prism.outline, np.roll(prism.outline, -1, axis=0), strict=True):
            edge, away = end - start, start - pose[:2]
            cross = along[:, 0] * edge[1] - along[:, 1] * edge[0]
            with np.errstate(divide="ignore", invalid="ignore"):
                distance = (away[0] * edge[1] - away[1] * edge[0]) / cross
                share = (away[0] * along[:, 1] - away[1] * along[:, 0]) / cross
            hit = (distance > 0) & (share >= -1e-9) & (share <= 1 + 1e-9)
            nearest = np.where(hit, np.minimum(nearest, distance), nearest)
    return nearest


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


def first_seen(
    poses: NDArray[np.float64],
    angles: NDArray[np.float64],
    ranges: NDArray[np.float64],
    limits: tuple[float, float],
    cell: float,
    shape: tuple[int, int],
) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
    """For each cell, the first scan of which a ray crosses it before its end, -1 for none; and which cells are ends."""
    since, is_hit = np.full(shape, -1, dtype=np.int32), np.zeros(shape, dtype=np.bool_)
    for s in reversed(range(len(poses))):
        for angle, reading in zip(angles, ranges[s], strict=True):
            if np.isnan(reading) or reading < limits[0]:
                continue
            along = np.array([math.cos(poses[s, 2] + angle), math.sin(poses[s, 2] + angle)])
            start, end = poses[s, :2] / cell, (poses[s, :2] + min(reading, limits[1]) * along) / cell
            for row, col in cells_before_end(start, end):
                if 0 <= row < shape[0] and 0 <= col < shape[1]:
                    since[row, col] = s
            row, col = cell_of(end)
            if reading <= limits[1] and 0 <= row < shape[0] and 0 <= col < shape[1]:
                is_hit[row, col] = True
    return since, is_hit


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
