"""Buildings of convex rooms drawn by rule, and what a robot sees of them at any placement: exact at every scale."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.robust.params import Params
from rectmerge.robust.prepared_map import PreparedMap
from rectmerge.similarity import Similarity
from scenarios import corruption

Box = tuple[float, float, float, float]  # x, y, w, h
Polygon = NDArray[np.float64]  # (K, 2), convex, either way round
WALL, DOOR = 6.0, 10.0
WALL_CELLS = ((1, 1), (3, 1), (1, 3))  # of a pair of views of an office: in A and in B


@dataclass(frozen=True)
class PlanView:
    """A map, and where its pixels are in the building."""

    grid: OccupancyGrid
    pixels: Similarity


def box(x: float, y: float, w: float, h: float) -> Polygon:
    return np.array([[x, y], [x + w, y], [x + w, y + h], [x, y + h]])


def disc(x: float, y: float, radius: float) -> Polygon:
    turn = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    return np.column_stack([x + radius * np.cos(turn), y + radius * np.sin(turn)])


def turned(polygon: Polygon, degrees: float, about: tuple[float, float]) -> Polygon:
    return Similarity(1.0, math.radians(degrees)).apply(polygon - about) + about


def office(seed: int, size: tuple[float, float] = (300.0, 220.0), smallest: float = 34.0) -> list[Polygon]:
    """Split a rectangle again and again into rooms; doors between most neighbours."""
    rng = np.random.default_rng(seed)
    rooms = _split((0.0, 0.0, *size), smallest, rng)
    doors = [door for first, second in itertools.combinations(rooms, 2) if (door := _door(first, second, rng))]
    inset = [(x + WALL / 2, y + WALL / 2, w - WALL, h - WALL) for x, y, w, h in rooms]
    return [box(*each) for each in (*inset, *doors)]


def _split(room: Box, smallest: float, rng: np.random.Generator) -> list[Box]:
    x, y, w, h = room
    longest = max(w, h)
    if longest < 2.2 * smallest or (longest < 4 * smallest and rng.random() < 0.25):
        return [room]
    at = rng.uniform(0.35, 0.65) * longest
    first, second = ((x, y, at, h), (x + at, y, w - at, h)) if w >= h else ((x, y, w, at), (x, y + at, w, h - at))
    return [*_split(first, smallest, rng), *_split(second, smallest, rng)]


def _door(first: Box, second: Box, rng: np.random.Generator) -> Box | None:
    (x, y, w, h), (u, v, p, q) = first, second
    if min(abs(x + w - u), abs(u + p - x)) < 1e-6:
        low, high = max(y, v) + WALL, min(y + h, v + q) - WALL - DOOR
        line = u if abs(x + w - u) < 1e-6 else x
        return (line - WALL, rng.uniform(low, high), 2 * WALL, DOOR) if high > low and rng.random() < 0.8 else None
    if min(abs(y + h - v), abs(v + q - y)) < 1e-6:
        low, high = max(x, u) + WALL, min(x + w, u + p) - WALL - DOOR
        line = v if abs(y + h - v) < 1e-6 else y
        return (rng.uniform(low, high), line - WALL, DOOR, 2 * WALL) if high > low and rng.random() < 0.8 else None
    return None


def free_at(rooms: Sequence[Polygon], pixels: Similarity, shape: tuple[int, int]) -> NDArray[np.bool_]:
    """Whether the building is free at each pixel centre of a map of a shape."""
    free = np.zeros(shape, np.bool_)
    back = pixels.inverse()
    for room in rooms:
        corners = back.apply(room)
        low = np.clip(np.floor(corners.min(axis=0)), 0, None).astype(int)
        high = np.clip(np.ceil(corners.max(axis=0)) + 1, 0, shape[::-1]).astype(int)
        if (low >= high).any():
            continue
        v, u = np.mgrid[low[1] : high[1], low[0] : high[0]]
        edges = np.roll(corners, -1, axis=0) - corners
        sides = [ex * (v - y) - ey * (u - x) for (x, y), (ex, ey) in zip(corners, edges, strict=True)]
        inside = np.all([s >= 0 for s in sides], axis=0) | np.all([s <= 0 for s in sides], axis=0)
        free[low[1] : high[1], low[0] : high[0]] |= inside
    return free


def see(
    rooms: Sequence[Polygon],
    *,
    degrees: float = 0.0,
    scale: float = 1.0,
    window: Box | None = None,
    wall_cells: int = 1,
    noise: int = 0,
    seed: int = 0,
    resolution: float | None = None,
) -> PlanView:
    """Map what lies in a window of a building: `scale` building units per cell, the picture turned, walls so thick."""
    corners = np.concatenate([box(*window)] if window else list(rooms))
    straight = Similarity(scale, math.radians(degrees))
    placed = straight.inverse().apply(corners)
    low, high = placed.min(axis=0) - 8, placed.max(axis=0) + 8
    shift = straight.apply(low)
    pixels = Similarity(scale, straight.angle, float(shift[0]), float(shift[1]))
    shape = (int(high[1] - low[1]), int(high[0] - low[0]))
    free = free_at(rooms, pixels, shape)
    seen = free & free_at([box(*window)], pixels, shape) if window else free
    reach = np.ones((2 * wall_cells + 1, 2 * wall_cells + 1), np.uint8)
    walls = (cv2.dilate(seen.view(np.uint8), reach) > 0) & ~free
    grid = OccupancyGrid(np.where(seen, FREE, np.where(walls, OCCUPIED, UNKNOWN)).astype(np.int8), resolution)
    return PlanView(
        corruption.add_noise(grid, f"cells-{noise}", np.random.default_rng(seed)) if noise else grid, pixels
    )


def truth(a: PlanView, b: PlanView) -> Similarity:
    """B's pixels on A's."""
    return a.pixels.inverse() @ b.pixels


def error(placement: Similarity, a: PlanView, b: PlanView) -> float:
    """RMSE in cells of A of a placement, over the cells that both maps see free."""
    true = truth(a, b)
    at_b = np.argwhere(b.grid.free)[:, ::-1]
    at_a = np.rint(true.apply(at_b)).astype(int)
    inside = ((at_a >= 0) & (at_a < a.grid.shape[::-1])).all(axis=1)
    common = inside.copy()
    common[inside] = a.grid.free[at_a[inside, 1], at_a[inside, 0]]
    off = placement.apply(at_b[common]) - true.apply(at_b[common])
    return float(np.sqrt((off**2).sum(axis=1).mean()))


def is_right(placement: Similarity, a: PlanView, b: PlanView) -> bool:
    """The benchmark's rule: within 1 % of the diagonal of A's known cells, 5 degrees and 5 %."""
    true = truth(a, b)
    rows, cols = np.nonzero(~a.grid.unknown)
    extent = math.hypot(np.ptp(rows) + 1, np.ptp(cols) + 1)
    turn = abs(math.remainder(placement.angle - true.angle, math.tau))
    return (
        error(placement, a, b) < 0.01 * extent
        and turn < math.radians(5)
        and abs(math.log(placement.scale / true.scale)) < math.log(1.05)
    )


def flipped(view: PlanView) -> OccupancyGrid:
    """The map as in a mirror."""
    return OccupancyGrid(np.ascontiguousarray(view.grid.occupancy[:, ::-1]), view.grid.resolution)


def two_wings(seed: int) -> list[Polygon]:
    """Draw two offices that meet at 30 degrees."""
    straight = office(seed, (200.0, 150.0))
    turned_by_30 = [
        turned(room + np.array([203.0, 20.0]), 30, (203.0, 80.0)) for room in office(seed + 50, (180.0, 120.0))
    ]
    return [*straight, *turned_by_30, box(185.0, 70.0, 50.0, 12.0)]


def linked(rooms: Sequence[Polygon], links: Sequence[tuple[int, int]]) -> list[Polygon]:
    """Join the middles of rooms by passages."""
    passages = []
    for start, end in links:
        p, q = rooms[start].mean(axis=0), rooms[end].mean(axis=0)
        middle, (dx, dy) = (p + q) / 2, q - p
        straight = box(middle[0] - math.hypot(dx, dy) / 2, middle[1] - 6.0, math.hypot(dx, dy), 12.0)
        passages.append(turned(straight, math.degrees(math.atan2(dy, dx)), tuple(middle.tolist())))
    return [*rooms, *passages]


def round_rooms() -> list[Polygon]:
    """Draw eight round rooms, passages in every direction between them."""
    discs = ((60, 60, 45), (150, 80, 38), (230, 50, 30), (250, 140, 50), (140, 190, 55), (50, 170, 34), (330, 80, 25))
    links = ((0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (5, 0), (2, 6), (6, 7), (7, 3))
    return linked([disc(*each) for each in (*discs, (345, 190, 36))], links)


def polygons(seed: int) -> list[Polygon]:
    """Draw rooms of four to six sides without a common direction."""
    rng = np.random.default_rng(seed)
    rooms = []
    for x, y in ((60, 60), (160, 50), (260, 70), (70, 160), (170, 150), (270, 170), (120, 240), (220, 245)):
        sides, radius = int(rng.integers(4, 7)), rng.uniform(30, 48)
        turn = np.linspace(0, 2 * np.pi, sides, endpoint=False) + rng.uniform(-0.35, 0.35, sides)
        rooms.append(np.column_stack([x + radius * np.cos(turn), y + radius * np.sin(turn)]))
    return linked(rooms, ((0, 1), (1, 2), (0, 3), (3, 4), (4, 5), (2, 5), (3, 6), (6, 7), (7, 5)))


def corridor(length: float = 4000.0, seed: int = 0) -> list[Polygon]:
    """Draw a corridor with niches and rooms behind doors on both sides, 300 units across in all."""
    rng = np.random.default_rng(seed)
    rooms = [box(0.0, 120.0, length, 60.0)]
    for low in (True, False):
        x = 0.0
        while x < length - 160:
            width, depth = rng.uniform(50, 150), rng.uniform(40, 110)
            edge = 120.0 if low else 180.0
            near = edge - WALL if low else edge + WALL
            if rng.random() < 0.25:
                rooms.append(box(x, edge - 15 if low else edge - 1, width / 3, 16.0))
            else:
                rooms.append(box(x, near - depth if low else near, width, depth))
                rooms.append(box(x + rng.uniform(0.1, 0.6) * width, edge - WALL if low else edge, 12.0, WALL))
            x += width + rng.uniform(6, 30)
    return rooms


def office_pair(seed: int, *, least_share: float = 0.72) -> tuple[PlanView, PlanView, float]:
    """See an office twice: any turns, scale 0.6 to 1.6, A its left part and B its right, noise level 0 to 2."""
    rng = np.random.default_rng(seed)
    rooms = office(seed)
    (turn_a, turn_b), scale, share = rng.uniform(0, 360, 2), rng.uniform(0.6, 1.6), rng.uniform(least_share, 1.0)
    left, right = (-8, -8, 300 * share + 8, 236), (300 * (1 - share), -8, 300 * share + 8, 236)
    wall_a, wall_b = WALL_CELLS[seed % 3]
    noise = int(rng.integers(0, 3))
    a = see(rooms, degrees=turn_a, window=left, wall_cells=wall_a, noise=noise, seed=seed)
    b = see(rooms, degrees=turn_b, scale=scale, window=right, wall_cells=wall_b, noise=noise, seed=seed + 1000)
    return a, b, scale


def as_placement(similarity: Similarity) -> NDArray[np.float64]:
    """Write a similarity as the row (a, b, tx, ty) that the kernels use."""
    (a, _, tx), (b, _, ty) = similarity.matrix
    return np.array([a, b, tx, ty])


def as_similarity(placement: NDArray[np.float64]) -> Similarity:
    """Read a row (a, b, tx, ty)."""
    a, b, tx, ty = placement
    return Similarity.from_matrix([[a, -b, tx], [b, a, ty]])


def prepared(grid: OccupancyGrid) -> PreparedMap:
    """Prepare a map that has walls with the default parameters."""
    map_ = PreparedMap.from_grid(grid, Params())
    assert map_.features is not None
    return map_
