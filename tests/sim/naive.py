"""Slow and obvious oracles of the fast parts of the simulation."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim.sensors.lidar import RayHits
from sim.world import SCAN_HEIGHT_M, Prism, World


def cast(world: World, pose: NDArray[np.float64], angles: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
    """Intersect every ray with every edge of every obstacle in the plane of the laser."""
    nearest = meet_edges([p for p in world.obstacles if p.bottom <= SCAN_HEIGHT_M < p.top], pose, angles)
    return np.where(nearest < reach, nearest, np.inf)


def ray_hits(
    world: World,
    pose: NDArray[np.float64],
    angles: NDArray[np.float64],
    reach: float,
    height: float,
    circles: Iterable[tuple[float, float, float]] = (),
) -> RayHits:
    """Intersect every ray with every edge at a height and with circles (x, y, radius); panes count up to the hit."""
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
    return RayHits(ranges, np.where(panes < np.minimum(ranges, reach), panes, np.inf))


def meet_edges(prisms: Iterable[Prism], pose: NDArray[np.float64], angles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance of every ray to any edge of any prism; a billionth of an edge is added at both ends."""
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
    """Return the first scan with a ray across each cell before its end, -1 for none, and the mask of ends."""
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
    """Return the cells a segment crosses but its last: cut it wherever it crosses a grid line."""
    cuts = [0.0, 1.0]
    for k in (0, 1):
        lines = range(math.ceil(min(start[k], end[k])), math.floor(max(start[k], end[k])) + 1)
        cuts += [(line - start[k]) / (end[k] - start[k]) for line in lines if end[k] != start[k]]
    cuts = sorted(cut for cut in cuts if 0 <= cut <= 1)
    middles = [(p + q) / 2 for p, q in itertools.pairwise(cuts) if q > p]
    return {cell_of(start + (end - start) * share) for share in middles} - {cell_of(end)}


def cell_of(point: NDArray[np.float64]) -> tuple[int, int]:
    """Return (row, col) of the cell of a point (col, row)."""
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


def walled_off(occupancy: NDArray[np.int8], narrowest_cells: int) -> NDArray[np.int8]:
    """Return the raster of a world made from a grid: floor of the least width, and walls around it."""
    cells = np.pad(occupancy, 1, constant_values=-1)
    every = list(np.ndindex(cells.shape))
    free, occupied = ({cell for cell in every if cells[cell] == value} for value in (0, 100))
    floor = {cell for cell in free if is_wide(cell, free | occupied, narrowest_cells)}
    ends = {(r + i, c + j) for r, c in floor for i in (-1, 0, 1) for j in (-1, 0, 1)} - floor
    shown = np.full(cells.shape, -1, np.int8)
    for cell in every:
        shown[cell] = 0 if cell in floor else 100 if cell in occupied | ends else -1
    rows, cols = (np.flatnonzero((shown == 100).any(axis=axis)) for axis in (1, 0))
    return shown[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]


def is_wide(cell: tuple[int, int], known: set[tuple[int, int]], side: int) -> bool:
    """Return whether a square of known cells, `side` cells wide, holds the cell."""
    squares = itertools.product(*(range(at - side + 1, at + 1) for at in cell))
    return any(all((r + i, c + j) in known for i in range(side) for j in range(side)) for r, c in squares)


def best_shift(
    field: NDArray[np.float32],
    points: NDArray[np.float64],
    guess: NDArray[np.float64],
    turns: NDArray[np.float64],
    half: int,
    shift_price: float,
    turn_price: float,
) -> float:
    """Return the largest score of any turn and whole-cell shift about a guess: the mean of the field under the points,
    less the price of shift and turn."""
    best = -math.inf
    for turn, across, up in itertools.product(turns, range(-half, half + 1), range(-half, half + 1)):
        cos, sin = math.cos(guess[2] + turn), math.sin(guess[2] + turn)
        total = 0.0
        for x, y in points:
            row, col = cell_of(np.array([guess[0] + cos * x - sin * y, guess[1] + sin * x + cos * y]))
            if 0 <= row + up < field.shape[0] and 0 <= col + across < field.shape[1]:
                total += float(field[row + up, col + across])
        best = max(best, total / len(points) - shift_price * (across**2 + up**2) - turn_price * turn**2)
    return best


def read_tum(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Read a TUM trajectory of a robot on a floor as times (S,) and poses (x, y, yaw), shape (S, 3)."""
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    table = np.array([[float(word) for word in line.split()] for line in lines]).reshape(-1, 8)
    assert (table[:, 3:6] == 0).all()  # neither up nor tilted
    return table[:, 0], np.column_stack([table[:, 1:3], 2 * np.arctan2(table[:, 6], table[:, 7])])
