"""Aligned grids into one, on the first grid's own cells, with the layer where they contradict each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import LONGEST_SIDE_CELLS, MOST_CELLS, UNKNOWN, OccupancyGrid, map_frame_to_pixels
from rectmerge.overlap import CONFLICT_REACH_CELLS
from rectmerge.similarity import Similarity

Rule = Literal["occupied", "free", "log-odds"]
RULES: tuple[Rule, ...] = get_args(Rule)
CELLS_AT_ONCE = 1 << 20
SURE_FREE, SURE_OCCUPIED = 0.1192, 0.971  # OctoMap's clamping bounds: what one map can say at most


@dataclass(frozen=True, slots=True, eq=False)
class Composition:
    """Several maps as one.

    Parameters
    ----------
    grid
        The merged map: A's frame, A's cells, extended by whole cells.
    conflict
        Shape of `grid`: cells where one map has a wall and another has free space with no wall within 2 cells.
    corner
        (row, col) of A's top-left cell in `grid`.
    """

    grid: OccupancyGrid
    conflict: NDArray[np.bool_]
    corner: tuple[int, int]


def compose(
    grids: Sequence[OccupancyGrid], b_to_as: Sequence[Similarity | None], *, rule: Rule = "occupied"
) -> Composition:
    """Merge aligned grids into one on the first grid's cells.

    Parameters
    ----------
    grids
        The maps, A first, at least one.
    b_to_as
        For each map, the similarity from its map frame to A's; None for A itself, and only for A.
    rule
        Where maps contradict each other: "occupied" lets a wall win, "free" lets free space win, "log-odds" sums what
        the maps say. A cell that a single map knows keeps that map's value under every rule.

    Raises
    ------
    InputError
        If the lists do not match, the rule is unknown, or the merged map would be absurdly large.

    Notes
    -----
    Every merged cell takes the nearest cell of B, so a coarser B leaves no holes; each wall cell of B also marks the
    merged cell that its centre falls in, so the thin walls of a finer B stay whole. "log-odds" takes occupancy as a
    probability between 0.1192 and 0.971 (A. Hornung et al., Autonomous Robots 2013, DOI 10.1007/s10514-012-9321-0), so
    a wall outweighs one map's free space, but not two maps'.
    """
    _check(grids, b_to_as, rule)
    a = grids[0]
    placements = [
        Similarity() if t is None else map_frame_to_pixels(t, a, g) for g, t in zip(grids, b_to_as, strict=True)
    ]
    layers, (row, col) = resample(grids, placements)
    merged = _sum_evidence(layers) if rule == "log-odds" else _overlay(layers, wall_wins=rule == "occupied")
    x, y = a.pixel_to_map([-col - 0.5, merged.shape[0] - row - 0.5])
    grid = OccupancyGrid(merged, a.resolution, (float(x), float(y), a.origin[2]))
    return Composition(grid, find_conflict(layers), (row, col))


def resample(
    grids: Sequence[OccupancyGrid], placements: Sequence[Similarity]
) -> tuple[list[NDArray[np.int8]], tuple[int, int]]:
    """Read grids on one lattice of unit pixels that holds the whole first grid and what is known of the others.

    Parameters
    ----------
    grids
        The maps, at least one.
    placements
        For each map the similarity from its pixels to the lattice's.

    Returns
    -------
    tuple
        One occupancy array of shape (H, W) per grid, and the (row, col) of the lattice's pixel (0, 0) in them.

    Raises
    ------
    InputError
        If the lattice would be absurdly large.
    """
    top, left, height, width = _canvas(grids, placements)
    shift = Similarity(tx=float(-left), ty=float(-top))
    layers = [_lay(grid, shift @ pixels, (height, width)) for grid, pixels in zip(grids, placements, strict=True)]
    return layers, (-top, -left)


def _check(grids: Sequence[OccupancyGrid], b_to_as: Sequence[Similarity | None], rule: str) -> None:
    if rule not in RULES:
        raise InputError(f"rule must be one of {', '.join(RULES)}, got {rule!r}")
    if not grids or len(grids) != len(b_to_as):
        raise InputError(f"compose needs one b_to_a per grid (None for the first), got {len(grids)} and {len(b_to_as)}")
    if b_to_as[0] is not None or any(t is None for t in b_to_as[1:]):
        raise InputError(
            "b_to_as must be None for the first grid, whose frame is kept, and a Similarity for the others"
        )


def _canvas(grids: Sequence[OccupancyGrid], placements: Sequence[Similarity]) -> tuple[int, int, int, int]:
    """Return top, left, height and width of what holds the first grid and every known cell of the others."""
    rows, cols = grids[0].shape
    whole = np.array([[x, y] for x in (-0.5, cols - 0.5) for y in (-0.5, rows - 0.5)])  # (4, 2)
    corners = [placements[0].apply(whole)]
    corners += [pixels.apply(_known_ends(g)) for g, pixels in zip(grids[1:], placements[1:], strict=True)]
    points = np.concatenate(corners)
    left, top = np.floor(points.min(axis=0) + 0.5 + 1e-6).tolist()
    right, bottom = np.ceil(points.max(axis=0) + 0.5 - 1e-6).tolist()
    width, height = right - left, bottom - top
    if not (width * height <= MOST_CELLS and max(width, height) <= LONGEST_SIDE_CELLS):
        raise InputError(f"the merged map would have {width:g} x {height:g} cells: is the scale right?")
    return int(top), int(left), int(height), int(width)


def _known_ends(grid: OccupancyGrid) -> NDArray[np.float64]:
    """Outer corners of the first and the last known cell of each row, in pixels, (N, 2): they bound every known one."""
    known = grid.occupancy != UNKNOWN
    rows = np.flatnonzero(known.any(axis=1))
    first, last = known[rows].argmax(axis=1), known.shape[1] - 1 - known[rows, ::-1].argmax(axis=1)
    ends = [np.stack([u, rows + half], axis=1) for u in (first - 0.5, last + 0.5) for half in (-0.5, 0.5)]
    return np.concatenate(ends)


def _lay(grid: OccupancyGrid, pixels: Similarity, shape: tuple[int, int]) -> NDArray[np.int8]:
    """Resample a grid onto the canvas: unknown where the grid has nothing."""
    layer = np.full(shape, UNKNOWN, np.int8)
    ends = pixels.apply(_known_ends(grid))
    if not len(ends):
        return layer
    low, high = ends.min(axis=0), ends.max(axis=0)
    (left, top), (right, bottom) = np.floor(low).astype(int).clip(0), np.ceil(high).astype(int) + 1
    back = pixels.inverse()
    for rows in _bands(top, min(bottom, shape[0]), max(1, right - left)):
        v, u = np.mgrid[rows, left : min(right, shape[1])]
        layer[v, u] = _nearest(grid, back.apply(np.stack([u, v], axis=-1)))
    walls = np.argwhere(grid.occupied)  # (N, 2)
    u, v = np.floor(pixels.apply(walls[:, ::-1]) + (0.5 + 1e-9)).astype(int).T
    inside = (u >= 0) & (v >= 0) & (u < shape[1]) & (v < shape[0])
    layer[v[inside], u[inside]] = grid.occupancy[grid.occupied][inside]
    return layer


def _bands(first: int, last: int, width: int) -> Iterator[slice]:
    step = max(1, CELLS_AT_ONCE // width)
    return (slice(row, min(row + step, last)) for row in range(first, last, step))


def _nearest(grid: OccupancyGrid, points: NDArray[np.float64]) -> NDArray[np.int8]:
    """Read a grid at pixel points, shape (..., 2); unknown outside."""
    cells = np.floor(points + (0.5 + 1e-9)).astype(np.int64)
    u, v = cells[..., 0], cells[..., 1]
    height, width = grid.shape
    inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
    read = grid.occupancy[v.clip(0, height - 1), u.clip(0, width - 1)]
    return np.where(inside, read, np.int8(UNKNOWN)).astype(np.int8)


def _overlay(layers: Sequence[NDArray[np.int8]], *, wall_wins: bool) -> NDArray[np.int8]:
    """Let a later layer fill what is unknown, and win where the rule says so."""
    merged = layers[0].copy()
    for layer in layers[1:]:
        old, new = OccupancyGrid(merged), OccupancyGrid(layer)
        wins = new.occupied & ~old.occupied if wall_wins else new.free & ~old.free
        fills = (old.unknown & ~new.unknown) | ((merged == UNKNOWN) & (layer != UNKNOWN))
        merged = np.where(wins | fills, layer, merged)
    return merged


def _sum_evidence(layers: Sequence[NDArray[np.int8]]) -> NDArray[np.int8]:
    probability = np.clip(np.arange(101) / 100.0, SURE_FREE, SURE_OCCUPIED)
    log_odds = np.append(np.log(probability / (1 - probability)), 0.0).astype(np.float32)  # [-1] is unknown
    total = np.zeros(layers[0].shape, np.float32)
    known, single = np.zeros(total.shape, np.uint16), np.full(total.shape, UNKNOWN, np.int8)
    for layer in layers:
        total += log_odds[layer]
        known += layer != UNKNOWN
        single = np.maximum(single, layer)
    summed = np.rint(100.0 / (1.0 + np.exp(-total))).astype(np.int8)
    return np.where(known > 1, summed, single)


def find_conflict(layers: Sequence[NDArray[np.int8]], *, reach: int = CONFLICT_REACH_CELLS) -> NDArray[np.bool_]:
    """Mark walls of one layer, shape (H, W), on free space of another that has no wall within `reach` cells."""
    size = 2 * reach + 1
    views = [OccupancyGrid(layer) for layer in layers]
    near = [cv2.dilate(g.occupied.view(np.uint8), np.ones((size, size), np.uint8)).astype(np.bool_) for g in views]
    conflict = np.zeros(layers[0].shape, np.bool_)
    for i, j in combinations(range(len(views)), 2):
        conflict |= views[i].occupied & views[j].free & ~near[j]
        conflict |= views[j].occupied & views[i].free & ~near[i]
    return conflict
