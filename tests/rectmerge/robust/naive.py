"""Slow oracles: what the compiled loops of the default method have to agree with, written to be read."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray


def score(placement: NDArray[np.float64], points: NDArray[np.float64], field: NDArray[np.int32]) -> int:
    """Add up the field at the cells nearest to where a placement (a, b, tx, ty) puts points, shape (N, 2)."""
    total = 0
    for x, y in move(placement, points).tolist():
        u, v = math.floor(x + 0.5), math.floor(y + 0.5)
        if 0 <= v < field.shape[0] and 0 <= u < field.shape[1]:
            total += int(field[v, u])
    return total


def move(placement: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Move points, shape (N, 2), by a placement (a, b, tx, ty), one by one."""
    a, b, tx, ty = placement.tolist()
    return np.array([[a * x - b * y + tx, b * x + a * y + ty] for x, y in points.tolist()]).reshape(-1, 2)


def count_codes(placements, quarters, points, kinds, codes):
    """Count the codes that each placement's faces meet, face by face and kind by kind, shape (N, 2, 256)."""
    ways, height, width = codes.shape
    counts = np.zeros((len(placements), 2, 256), int)
    for i, placement in enumerate(placements):
        for (x, y), mine in zip(move(placement, points), kinds, strict=True):
            u, v = int(np.floor(x + 0.5)), int(np.floor(y + 0.5))
            for k in np.flatnonzero(mine):
                if 0 <= u < width and 0 <= v < height:
                    counts[i, mine[k] - 1, codes[(k + quarters[i]) % ways, v, u]] += 1
    return counts


def distinct(placements: NDArray[np.float64], landmarks: NDArray[np.float64], apart: float, keep: int) -> list[int]:
    """Keep the first placements that put some landmark far from where every kept one puts it."""
    kept: list[int] = []
    for i, placement in enumerate(placements):
        mine = move(placement, landmarks)
        if all(np.abs(mine - move(placements[k], landmarks)).max() >= apart for k in kept) and len(kept) < keep:
            kept.append(i)
    return kept


def suppress(rectangles: NDArray[np.int32], order: list[int], iou: float, keep: int) -> list[int]:
    """Keep the first rectangles that share too little with every kept one, counted cell by cell."""
    masks = [{(u, v) for u in range(x, x + w) for v in range(y, y + h)} for x, y, w, h in rectangles.tolist()]
    kept: list[int] = []
    for i in order:
        if len(kept) < keep and all(len(masks[i] & masks[k]) <= iou * len(masks[i] | masks[k]) for k in kept):
            kept.append(i)
    return kept


def shrunk_side(side: int, factor: float) -> int:
    """Return the working cells along a side: an odd number along an odd side, so that its middle cell is whole."""
    count = math.ceil(side / factor)
    return count + 1 if side % 2 == 1 and count % 2 == 0 else count


def shrunk_counts(
    cells: NDArray[np.int8], bounds: tuple[int, int, int, int], factor: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Count the free, occupied and surface cells of each working cell; specks count as free."""
    top, bottom, left, right = bounds
    shape = shrunk_side(bottom - top + 1, factor), shrunk_side(right - left + 1, factor)
    before = (shape[0] * factor - (bottom - top + 1)) / 2, (shape[1] * factor - (right - left + 1)) / 2
    free, occupied, surface = (np.zeros(shape, int) for _ in range(3))
    for r, c in np.argwhere(cells >= 0).tolist():
        row, col = int((r - top + 0.5 + before[0]) / factor), int((c - left + 0.5 + before[1]) / factor)
        at = min(shape[0] - 1, row), min(shape[1] - 1, col)
        if cells[r, c] == 0 or is_speck(cells, r, c):
            free[at] += 1
            continue
        occupied[at] += 1
        surface[at] += bool((cells[max(0, r - 1) : r + 2, max(0, c - 1) : c + 2] == 0).any())
    return free, occupied, surface


def is_speck(cells: NDArray[np.int8], row: int, col: int, largest: int = 4) -> bool:
    """Grow the occupied patch at a cell; a speck has at most four cells and free ones all around, inside the map."""
    patch, waiting = {(row, col)}, [(row, col)]
    while waiting:
        r, c = waiting.pop()
        for i, j in itertools.product((r - 1, r, r + 1), (c - 1, c, c + 1)):
            if not (0 <= i < cells.shape[0] and 0 <= j < cells.shape[1]) or cells[i, j] < 0:
                return False
            if cells[i, j] > 0 and (i, j) not in patch:
                patch.add((i, j))
                waiting.append((i, j))
    return len(patch) <= largest


def nearest_facing(
    surface: NDArray[np.float64], point: tuple[float, float], normal: tuple[float, float], reach: float
) -> float:
    """Distance to the nearest surface cell (u, v, nx, ny) within reach that faces as the normal does; inf if none."""
    distances = [math.dist(point, (u, v)) for u, v, nx, ny in surface if nx * normal[0] + ny * normal[1] >= 0.7]
    nearest = min(distances, default=math.inf)
    return nearest if nearest < reach else math.inf


def profile_energy(points: NDArray[np.float64], angle: float, width: float, middle: float) -> float:
    """Share each point between the two bins beside it along a direction, and sum the squared bins."""
    bins: dict[int, float] = {}
    for x, y in points.tolist():
        at = (x * math.cos(angle) + y * math.sin(angle)) / width + middle
        low = math.floor(at)
        bins[low] = bins.get(low, 0.0) + 1 - (at - low)
        bins[low + 1] = bins.get(low + 1, 0.0) + at - low
    return sum(count**2 for count in bins.values())


def bent_score(
    placement: NDArray[np.float64],
    points: NDArray[np.float64],
    blocks: list[NDArray[np.int64]],
    field: NDArray[np.int32],
    *,
    reach: int,
    step: int,
    cost: int,
    fixed_cost: int,
) -> int:
    """Sum a field under points, (N, 2), each block of which takes the shift that pays best; outside the field is 0."""
    total = 0
    for block in blocks:
        payoffs = []
        for dy in range(-reach, reach + 1, step):
            for dx in range(-reach, reach + 1, step):
                cells = np.floor(move(placement, points[block]) + 0.5).astype(int) + np.array([dx, dy])
                inside = ((cells >= 0) & (cells < field.shape[::-1])).all(axis=1)
                gained = int(field[cells[inside, 1], cells[inside, 0]].sum())
                payoffs.append(gained - cost * (dx * dx + dy * dy) * len(block) - fixed_cost * bool(dx or dy))
        total += max(payoffs)
    return total


def face_score(placement, quarter, groups, faces, centre, gains_a, gains_b) -> int:
    """Look up every face of B in A, and of A in B, one by one; a placement is (angle, ln s, mu, mv)."""
    angle, log_scale, mu, mv = placement
    linear, at, middle = np.exp(log_scale + 1j * angle), mu + 1j * mv, complex(*centre)
    total = 0
    for first, end, way, is_b in groups:
        field = (gains_a if is_b else gains_b)[(way + quarter if is_b else way - quarter) % 4]
        for n in range(first, end):
            p = complex(*faces[:, n])
            p = linear * (p - middle) + at if is_b else (p - at) / linear + middle
            u, v = math.floor(p.real + 0.5), math.floor(p.imag + 0.5)
            total += int(field[v, u]) if 0 <= v < field.shape[0] and 0 <= u < field.shape[1] else 0
    return total


def count_faces(placements, points, is_long, state, to_wall, to_unknown, reaches):
    """Count the faces that a map judges and contradicts, by sets of cells, shape (N, 4)."""
    counts = []
    for placement in placements:
        hidden, floor, beside = (reach * max(1.0, math.hypot(*placement[:2])) for reach in reaches)
        at, kept = _cells_within(placement, points, state.shape)
        wall, unknown = to_wall[at], to_unknown[at]
        judged = (state[at] != 0) | (wall <= hidden)
        free = judged & (state[at] == 1)
        solid = free & (wall > floor) & (unknown > floor)
        apart = free & is_long[kept] & (wall > beside) & (unknown > beside)
        counts.append([judged.sum(), solid.sum(), (judged & is_long[kept]).sum(), apart.sum()])
    return np.array(counts)


def count_corners(placements, points, kinds, to_corner, to_unknown, reaches):
    """Count the corners that a map must show and does not, by sets of cells, shape (N, 3)."""
    counts = []
    for placement in placements:
        hidden, near, denied = (reach * max(1.0, math.hypot(*placement[:2])) for reach in reaches)
        at, kept = _cells_within(placement, points, to_unknown.shape)
        own, other = to_corner[(kinds[kept], *at)], to_corner[(1 - kinds[kept], *at)]
        shown = (to_unknown[at] > hidden) | (own <= near) | (other <= near)
        missed = shown & (own > near) & (other > denied)
        counts.append([shown.sum(), missed.sum(), (missed & (to_unknown[at] > denied)).sum()])
    return np.array(counts)


def _cells_within(placement, points, shape):
    """Return the (rows, columns) of the cells on which points fall, and which of the points fall on any."""
    u, v = np.floor(move(placement, points) + 0.5).astype(int).T
    kept = np.flatnonzero((u >= 0) & (v >= 0) & (u < shape[1]) & (v < shape[0]))
    return (v[kept], u[kept]), kept
