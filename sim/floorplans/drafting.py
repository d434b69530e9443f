"""Pen for plans: rooms side by side, and walls with doors along their common borders.

The outline of a room runs along the middles of its walls, also of the outer ones, which are thicker to the outside.
So rooms tile the building, and every wall reaches half the inner thickness into the outlines on both sides.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from rectmerge.errors import SimulationError
from sim.floorplans.pieces import Piece
from sim.floorplans.shapes import Points, counter_clockwise, offset
from sim.world import Door, Prism, Room, bar

HEIGHT_M = 2.5
JAMB_M = 0.15  # least length of wall next to a door
PANE_M = 0.06  # a glass partition is no thicker


@dataclass(frozen=True, slots=True)
class Gap:
    """Opening in a wall, from `start` to `end` metres along it, and the names of the rooms that it joins.

    An opening that is no door has no leaf.
    """

    start: float
    end: float
    first: str
    second: str
    is_door: bool = True


class Pen:
    """Pen that draws one building, and the plan drawn so far.

    Parameters
    ----------
    rng
        Source of all choices: thicknesses, widths of doors, glass partitions.
    size_m
        Outer size of the building.
    wall_m, door_m, glass
        As in `WorldSpec`.
    rooms_rng
        Source of the choices after outer walls and corridors, for another storey; None is `rng` for all.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        *,
        size_m: tuple[float, float],
        wall_m: tuple[float, float],
        door_m: tuple[float, float],
        glass: float,
        rooms_rng: np.random.Generator | None = None,
    ) -> None:
        self.rng, self.size_m, self.door_m, self._glass_share = rng, size_m, door_m, glass
        self._rooms_rng = rooms_rng
        self.inner_m = float(rng.uniform(*wall_m))
        self.outer_m = float(rng.uniform(self.inner_m, 2 * self.inner_m))
        self.walls: list[Prism] = []
        self.glass: list[Prism] = []
        self.fixtures: list[Prism] = []  # furniture that is never moved
        self.rooms: list[Room] = []
        self.bare: set[str] = set()  # rooms without furniture
        self.doors: list[Door] = []
        self.openings: list[Door] = []
        self.joints: list[tuple[str, str]] = []  # rooms side by side without a wall between
        self.floor: list[Points] = []
        self.blocks: list[Points] = []  # obstacles, besides walls, that furniture keeps clear of
        self.pieces: list[Piece] = []
        self.spares: list[Piece] = []  # alternatives for the same place or zone
        self.way_m, self.turned = 0.85, 0.0  # gap between pieces of furniture; share of them at any angle

    def box(self) -> tuple[float, float, float, float]:
        """Return (left, low, right, high) of the middles of the outer walls."""
        edge = self.outer_m - self.inner_m / 2
        return edge, edge, self.size_m[0] - edge, self.size_m[1] - edge

    def begin_rooms(self) -> np.random.Generator:
        """Take the source of choices for rooms, once outer walls and corridors are chosen, and return it."""
        if self._rooms_rng is not None:
            self.rng = self._rooms_rng
        return self.rng

    def shell(self, outline: ArrayLike) -> None:
        """Draw the outer walls along the outline (N, 2) of all rooms, which may have inward corners."""
        corners = counter_clockwise(outline)
        within = offset(corners, self.inner_m / 2)
        beyond = offset(corners, self.inner_m / 2 - self.outer_m)
        for k in range(len(corners)):
            after = (k + 1) % len(corners)
            self.walls.append(Prism(np.stack([beyond[k], beyond[after], within[after], within[k]]), HEIGHT_M))

    def room(self, name: str, corners: ArrayLike, *, is_bare: bool = False) -> None:
        """Add a room with a convex outline (N, 2)."""
        outline = counter_clockwise(corners)
        self.rooms.append(Room(name, outline, outline.mean(axis=0)))
        if is_bare:
            self.bare.add(name)

    def pave(self, corners: ArrayLike) -> None:
        """Add floor that belongs to no room, with a convex outline (N, 2)."""
        self.floor.append(counter_clockwise(corners))

    def join(self, first: str, second: str) -> None:
        """Join two rooms that lie side by side without a wall between."""
        self.joints.append((first, second))

    def block(self, corners: ArrayLike, top: float = HEIGHT_M, *, is_wall: bool = True) -> None:
        """Add a fixed obstacle within a room: a pillar, or an upright of a rack."""
        outline = counter_clockwise(corners)
        (self.walls if is_wall else self.fixtures).append(Prism(outline, top))
        self.blocks.append(outline)

    def door(self, low: float, high: float, first: str, second: str, *, is_needed: bool = True) -> list[Gap]:
        """Choose a door between two points of a wall; no gap where it does not fit and is not needed.

        Raises
        ------
        SimulationError
            If a door that is needed does not fit.
        """
        room = high - low - 2 * JAMB_M - self.inner_m
        if room < self.door_m[0] - 1e-9:
            if is_needed:
                raise SimulationError(f"a door of {self.door_m[0]} m does not fit into {high - low:.2f} m of wall")
            return []
        width = min(float(self.rng.uniform(*self.door_m)), room)
        start = low + JAMB_M + self.inner_m / 2 + float(self.rng.uniform(0.0, room - width))
        return [Gap(start, start + width, first, second)]

    def wall(self, points: ArrayLike, gaps: Iterable[Gap] = ()) -> None:
        """Draw an inner wall along a line of points (N, 2), with its gaps counted along it.

        It must end at the middle of another wall, which hides its end.
        """
        line = np.array(points, dtype=np.float64)
        is_glass = bool(self.rng.random() < self._glass_share)
        thickness = min(self.inner_m, PANE_M) if is_glass else self.inner_m
        ways = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        cuts = sorted(gaps, key=lambda gap: gap.start)
        for gap in cuts:
            ends = np.stack([_at(line, ways, gap.start), _at(line, ways, gap.end)])
            (self.doors if gap.is_door else self.openings).append(Door(ends, (gap.first, gap.second)))
        stretches = _solid(float(ways[-1]), cuts)
        chosen = self.glass if is_glass else self.walls
        chosen.extend(Prism(outline, HEIGHT_M) for outline in _bars(line, ways, stretches, thickness))


def _solid(length: float, gaps: Sequence[Gap]) -> list[tuple[float, float]]:
    """Return the solid stretches of a wall between its gaps."""
    ends = [0.0, *(end for gap in gaps for end in (gap.start, gap.end)), length]
    return list(zip(ends[::2], ends[1::2], strict=True))


def _bars(line: Points, ways: Points, stretches: Sequence[tuple[float, float]], thickness: float) -> Iterator[Points]:
    """Yield the outlines of the stretches of a line, whose points lie at `ways` along it."""
    bends = [_bend(line, k) * thickness / 2 for k in range(len(line))]
    for k, (from_way, to_way) in enumerate(pairwise(ways)):
        along = (line[k + 1] - line[k]) / (to_way - from_way)
        for start, end in stretches:
            if min(end, to_way) - max(start, from_way) > 1e-6:
                low = start if start > from_way else from_way - bends[k]
                high = end if end < to_way else to_way + bends[k + 1]
                yield bar(line[k] + along * (low - from_way), line[k] + along * (high - from_way), thickness)


def _at(line: Points, ways: Points, way: float) -> Points:
    return np.array([np.interp(way, ways, line[:, 0]), np.interp(way, ways, line[:, 1])])


def _bend(line: Points, k: int) -> float:
    """Return the length, in half thicknesses, by which a wall must be extended to close the bend at a point."""
    if not 0 < k < len(line) - 1:
        return 0.0
    before, after = ((b - a) / np.hypot(*(b - a)) for a, b in pairwise(line[k - 1 : k + 2]))
    return float(np.tan(np.arccos(np.clip(before @ after, -1.0, 1.0)) / 2))
