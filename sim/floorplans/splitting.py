"""Floors split into convex rooms, recursively, and doors that make all of them reachable."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import SimulationError
from sim.floorplans.drafting import Gap, Pen
from sim.floorplans.shapes import Points

TRIES = 30
LEAN_RAD = (0.2, 0.6)  # off the right angle, of oblique lines
MORE_DOORS = 0.25  # share of the neighbours joined by a further door


@dataclass(slots=True, eq=False)
class Split:
    """Split of a floor: convex pieces, each (N, 2) counter-clockwise, and the lines (2, 2) between them."""

    pieces: list[Points]
    lines: list[Points]


def split(floor: Split, count: int, narrowest: float, rng: np.random.Generator, *, oblique: float = 0.0) -> None:
    """Split the largest pieces until there are `count`.

    Parameters
    ----------
    floor
        Floor to split, in place.
    count
        Number of pieces.
    narrowest
        The least width of a piece in any direction, metres.
    rng
        Source of the lines.
    oblique
        Share of the lines that are not at right angles to the longest side of the piece they split.

    Raises
    ------
    SimulationError
        If no piece can be split.
    """
    while len(floor.pieces) < count:
        order = sorted(range(len(floor.pieces)), key=lambda k: -area(floor.pieces[k]))
        for k in order:
            halves = _halves(floor.pieces[k], narrowest, rng, is_oblique=bool(rng.random() < oblique))
            if halves:
                first, second, line = halves
                floor.pieces[k : k + 1] = [first, second]
                floor.lines.append(line)
                break
        else:
            raise SimulationError(f"the floor cannot be split into {count} rooms of at least {narrowest:.1f} m")


def _halves(
    piece: Points, narrowest: float, rng: np.random.Generator, *, is_oblique: bool
) -> tuple[Points, Points, Points] | None:
    """Split one piece across its length, where both parts are wide enough."""
    edges = np.roll(piece, -1, axis=0) - piece
    along = edges[int(np.argmax(np.hypot(*edges.T)))]
    for _ in range(TRIES):
        across = np.arctan2(along[1], along[0]) + np.pi / 2
        if is_oblique:
            across += rng.choice([-1, 1]) * rng.uniform(*LEAN_RAD)
        direction = np.array([np.cos(across), np.sin(across)])
        reach = piece @ [direction[1], -direction[0]]
        at = reach.min() + (reach.max() - reach.min()) * rng.uniform(0.32, 0.68)
        halves = cut_convex(piece, direction, at)
        if halves and min(width(half) for half in halves[:2]) >= narrowest:
            return halves
    return None


def cut_convex(piece: Points, direction: Points, at: float) -> tuple[Points, Points, Points] | None:
    """Cut a convex outline (N, 2) by the line of a direction that lies `at` metres to the right of the origin.

    Returns
    -------
    right, left, line
        Both parts, counter-clockwise, and the ends (2, 2) of the cut; None if the line misses the piece.
    """
    away = piece @ np.array([direction[1], -direction[0]]) - at  # > 0 on the right
    right: list[Points] = []
    left: list[Points] = []
    line: list[Points] = []
    for k in range(len(piece)):
        after = (k + 1) % len(piece)
        if away[k] >= 0:
            right.append(piece[k])
        if away[k] <= 0:
            left.append(piece[k])
        if away[k] * away[after] < 0:
            point = piece[k] + (piece[after] - piece[k]) * (away[k] / (away[k] - away[after]))
            for part in (right, left, line):
                part.append(point)
        elif away[k] == 0:
            line.append(piece[k])
    if len(line) != 2 or min(len(right), len(left)) < 3:
        return None
    return np.array(right), np.array(left), np.array(line)


def area(piece: Points) -> float:
    """Return the area of a counter-clockwise outline (N, 2)."""
    x, y = piece.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def width(piece: Points) -> float:
    """Return the least distance between two parallels around a convex outline (N, 2)."""
    edges = np.roll(piece, -1, axis=0) - piece
    inward = np.stack([-edges[:, 1], edges[:, 0]], axis=-1) / np.hypot(*edges.T)[:, None]
    heights = inward @ piece.T - np.sum(inward * piece, axis=1)[:, None]  # (N, N)
    return float(heights.max(axis=1).min())


@dataclass(frozen=True, slots=True)
class _Border:
    """Border of two pieces on both sides of a line, from `low` to `high` metres along it."""

    line: int
    low: float
    high: float
    first: int
    second: int


def draw_split(pen: Pen, floor: Split, names: Sequence[str], hub: int = 0) -> None:
    """Draw the pieces as rooms, and the lines as walls with doors.

    The doors make a tree that joins as many rooms as possible to the hub directly, and some more.

    Raises
    ------
    SimulationError
        If a room cannot be joined to the others.
    """
    for name, piece in zip(names, floor.pieces, strict=True):
        pen.room(name, piece)
    needed = pen.door_m[0] + pen.inner_m + 0.3
    borders = [
        border for k in range(len(floor.lines)) for border in _borders(floor, k) if border.high - border.low >= needed
    ]
    order = sorted(pen.rng.permutation(len(borders)), key=lambda k: hub not in (borders[k].first, borders[k].second))
    group = np.arange(len(names))
    gaps: list[list[Gap]] = [[] for _ in floor.lines]
    for k in order:
        border = borders[k]
        is_needed = group[border.first] != group[border.second]
        if is_needed or pen.rng.random() < MORE_DOORS:
            gaps[border.line] += pen.door(border.low, border.high, names[border.first], names[border.second])
            group[group == group[border.second]] = group[border.first]
    if (group != group[0]).any():
        raise SimulationError("a room of this draft has no wall for a door")
    for line, chosen in zip(floor.lines, gaps, strict=True):
        pen.wall(line, chosen)


def _borders(floor: Split, k: int) -> list[_Border]:
    """Return the borders of pieces that face each other across a line."""
    start, end = floor.lines[k]
    along = (end - start) / np.hypot(*(end - start))
    sides: tuple[list[tuple[int, float, float]], list[tuple[int, float, float]]] = ([], [])
    for j, piece in enumerate(floor.pieces):
        away = (piece - start) @ np.array([-along[1], along[0]])
        on_line: NDArray[np.bool_] = np.abs(away) < 1e-6
        if on_line.sum() >= 2:
            ways = (piece[on_line] - start) @ along
            sides[int(away.sum() > 0)].append((j, float(ways.min()), float(ways.max())))
    length = float(np.hypot(*(end - start)))
    return [
        _Border(k, max(lo, low, 0.0), min(hi, high, length), first, second)
        for first, lo, hi in sides[0]
        for second, low, high in sides[1]
        if min(hi, high, length) > max(lo, low, 0.0)
    ]
