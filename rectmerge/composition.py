"""Aligned grids into one, on the first grid's own cells, with the layer where they contradict each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, get_args

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import UNKNOWN, OccupancyGrid, map_frame_to_pixels
from rectmerge.overlap import CONFLICT_REACH_CELLS
from rectmerge.resampling import resample
from rectmerge.similarity import Similarity

Rule = Literal["occupied", "free", "log-odds"]
RULES: tuple[Rule, ...] = get_args(Rule)
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


def _check(grids: Sequence[OccupancyGrid], b_to_as: Sequence[Similarity | None], rule: str) -> None:
    if rule not in RULES:
        raise InputError(f"rule must be one of {', '.join(RULES)}, got {rule!r}")
    if not grids or len(grids) != len(b_to_as):
        raise InputError(f"compose needs one b_to_a per grid (None for the first), got {len(grids)} and {len(b_to_as)}")
    if b_to_as[0] is not None or any(t is None for t in b_to_as[1:]):
        raise InputError(
            "b_to_as must be None for the first grid, whose frame is kept, and a Similarity for the others"
        )


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
