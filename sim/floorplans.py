"""Procedural buildings by family, from a seed: for now `office`, rooms along both sides of a corridor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError, SimulationError
from sim.driving import drivable, standing_spot
from sim.world import Door, Prism, Room, World, bar

OUTER_M, INNER_M, HEIGHT_M = 0.25, 0.12, 2.5  # wall thicknesses and height
NARROWEST_ROOM_M = 2.4
Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldSpec:
    """What building to make.

    Parameters
    ----------
    family
        Only "office" for now.
    size_m
        Outer size (x, y) in metres.
    rooms
        Number of rooms beside the corridor, 6 to 12.
    oblique
        Probability that the building has walls that are not at right angles.
    furniture
        Mean pieces of furniture per 10 square metres of room.

    Raises
    ------
    InputError
        If a value is out of range, or the rooms would be too narrow.
    """

    family: Literal["office"] = "office"
    size_m: tuple[float, float] = (20.0, 13.0)
    rooms: int = 8
    oblique: float = 0.3
    furniture: float = 1.2

    def __post_init__(self) -> None:
        if not 6 <= self.rooms <= 12:
            raise InputError(f"rooms must be 6 to 12, got {self.rooms}")
        if not (min(self.size_m) >= 9.0 and max(self.size_m) <= 60.0):
            raise InputError(f"size_m must be 9 to 60 metres each way, got {list(self.size_m)}")
        if not 0 <= self.oblique <= 1:
            raise InputError(f"oblique must be a probability, got {self.oblique}")
        if not 0 <= self.furniture <= 5:
            raise InputError(f"furniture must be 0 to 5 pieces per 10 square metres, got {self.furniture}")
        if self.size_m[0] - 2 * OUTER_M < _band_length(self.rooms):
            raise InputError(f"{self.rooms} rooms do not fit along {self.size_m[0]} m")


def make_world(spec: WorldSpec, seed: int) -> World:
    """Make a building of a family from a seed; a robot can drive between all its rooms.

    Raises
    ------
    SimulationError
        If no drivable building was found, which a changed spec cures.
    """
    try:
        from sim.furnishing import furnish
    except ImportError as error:
        raise SimulationError("making buildings needs shapely: `pip install rectmerge[sim]`") from error
    rng = np.random.default_rng(seed)
    plan = _Office(spec, rng).build()
    rooms, pieces = _settle(plan, furnish(plan, spec.furniture, rng))
    chosen = tuple(piece for room in pieces for piece in room)
    return replace(plan, rooms=rooms, furniture=chosen, family=spec.family, seed=seed)


def families() -> dict[str, str]:
    """Return the families of buildings by name, each with one line about it."""
    return {"office": "6 to 12 rooms on both sides of a corridor; furniture, doors between rooms, some oblique walls"}


def _band_length(rooms: int) -> float:
    """Metres that the longer of two bands needs for its rooms."""
    return round(0.58 * rooms) * (NARROWEST_ROOM_M + 0.2)


def _settle(plan: World, pieces: list[list[Prism]]) -> tuple[tuple[Room, ...], list[list[Prism]]]:
    """Clear rooms that furniture has cut off, until a robot can stand in every room and drive to all others."""
    while True:
        world = replace(plan, furniture=tuple(piece for room in pieces for piece in room))
        field = drivable(world)
        spots = [standing_spot(field, room) for room in plan.rooms]
        if all(spot is not None for spot in spots):
            placed = zip(plan.rooms, spots, strict=True)
            return tuple(replace(room, spot=spot) for room, spot in placed if spot is not None), pieces
        cut_off = [k for k, spot in enumerate(spots) if spot is None and pieces[k]]
        if not cut_off and not any(pieces):
            raise SimulationError("a room of this building cannot be reached; choose another seed or size_m")
        pieces = [[] if k in cut_off or not cut_off else room for k, room in enumerate(pieces)]


class _Office:
    """Draws one office; keeps what has been drawn so far."""

    def __init__(self, spec: WorldSpec, rng: np.random.Generator) -> None:
        self.rng, self.spec = rng, spec
        self.walls: list[Prism] = []
        self.rooms: list[Room] = []
        self.doors: list[Door] = []
        self.is_oblique = bool(rng.random() < spec.oblique)

    def build(self) -> World:
        """Draw shell, corridor, an end hall perhaps, and a band of rooms on either side."""
        (sx, sy), rng = self.spec.size_m, self.rng
        left, right, low, high = OUTER_M, sx - OUTER_M, OUTER_M, sy - OUTER_M
        self._shell(sx, sy)
        width = rng.uniform(1.7, 2.3)
        south = low + (high - low - width) * rng.uniform(0.4, 0.6)
        north, count = south + width, self.spec.rooms
        end = right
        if rng.random() < 0.6 and right - left > 4.6 + _band_length(count - 1):
            end, count = right - rng.uniform(3.2, 4.6), count - 1
        self._room("corridor", [(left, south), (end, south), (end, north), (left, north)])
        if end < right:
            self._room("hall", [(end, low), (right, low), (right, high), (end, high)])
            middle, half = (south + north) / 2, min(0.7, width / 2 - 0.25)
            self._wall((end, low), (end, high), [(middle - half, middle + half, "corridor", "hall")])
        above = round(count * rng.uniform(0.42, 0.58))
        self._band("north", (left, end), (north, high), above)
        self._band("south", (left, end), (south, low), count - above)
        return World(size=(sx, sy), walls=tuple(self.walls), rooms=tuple(self.rooms), doors=tuple(self.doors))

    def _band(self, side: str, span: tuple[float, float], depth: tuple[float, float], count: int) -> None:
        """Draw `count` rooms between the corridor's wall (y = depth[0]) and the outer wall (y = depth[1])."""
        rng, (near, far) = self.rng, depth
        has_back = count >= 3 and abs(far - near) > 4.6 and rng.random() < 0.6
        slots = count - 1 if has_back else count
        at_near = self._cuts(span, slots)
        at_far = at_near + self._slants(at_near)
        names = [f"{side} {k + 1}" for k in range(slots)]
        back = int(rng.integers(slots)) if has_back else -1
        lobby = int(rng.integers(slots)) if slots >= 3 and rng.random() < 0.35 else -1
        gaps = []
        for k, name in enumerate(names):
            corners = [(at_near[k], near), (at_near[k + 1], near), (at_far[k + 1], far), (at_far[k], far)]
            if k == back:
                self._split(name, corners)
            else:
                self._room(name, corners)
            gaps.append(self._corridor_gap(name, at_near[k], at_near[k + 1], is_wide=k == lobby != back))
        self._wall((span[0], near), (span[1], near), gaps)
        for k in range(1, slots):
            self._partition((at_near[k], near), (at_far[k], far), names[k - 1], names[k])
        if self.is_oblique and rng.random() < 0.7 and slots - 1 != back:
            self._chamfer(span[0] if rng.random() < 0.5 and back != 0 else span[1], far, near)

    def _cuts(self, span: tuple[float, float], slots: int) -> Points:
        """Cut a span into rooms of unequal width; returns the slots + 1 ends."""
        spare = span[1] - span[0] - slots * NARROWEST_ROOM_M
        widths = NARROWEST_ROOM_M + spare * self.rng.dirichlet(np.full(slots, 3.0))
        return span[0] + np.concatenate([[0.0], np.cumsum(widths)])

    def _slants(self, cuts: Points) -> Points:
        """How far each partition leans along the corridor; the ends stand upright."""
        lean = np.zeros(len(cuts))
        if self.is_oblique and len(cuts) > 2:
            k = int(self.rng.integers(1, len(cuts) - 1))
            room = 0.45 * min(cuts[k] - cuts[k - 1], cuts[k + 1] - cuts[k])
            lean[k] = self.rng.choice([-1, 1]) * self.rng.uniform(0.5, 1.0) * room
        return lean

    def _corridor_gap(self, name: str, left: float, right: float, *, is_wide: bool) -> tuple[float, float, str, str]:
        """Choose where a room opens to the corridor: a door, sometimes a double one; a lobby opens all the way."""
        if is_wide:
            return left + 0.3, right - 0.3, name, "corridor"
        width = 1.5 if self.rng.random() < 0.15 else self.rng.uniform(0.9, 1.1)
        start = self.rng.uniform(left + 0.3, right - 0.3 - width)
        return start, start + width, name, "corridor"

    def _split(self, name: str, corners: list[tuple[float, float]]) -> None:
        """Make a front room and a back room that is reached through it."""
        a, b, c, d = (np.array(p) for p in corners)
        share = self.rng.uniform(0.45, 0.6)
        left, right = a + (d - a) * share, b + (c - b) * share
        self._room(name, [tuple(a), tuple(b), tuple(right), tuple(left)])
        self._room(f"{name} back", [tuple(left), tuple(right), tuple(c), tuple(d)])
        start = self.rng.uniform(0.3, np.hypot(*(right - left)) - 1.3)
        self._wall(tuple(left), tuple(right), [(start, start + 1.0, name, f"{name} back")], from_start=True)

    def _partition(self, near: tuple[float, float], far: tuple[float, float], one: str, other: str) -> None:
        """Draw the wall between two neighbours, with a door in one of four."""
        length = float(np.hypot(far[0] - near[0], far[1] - near[1]))
        taken = {end for door in self.doors for end in door.joins if end.endswith("back")}
        gaps: list[tuple[float, float, str, str]] = []
        if self.rng.random() < 0.25 and not {f"{one} back", f"{other} back"} & taken:
            start = self.rng.uniform(0.8, length - 1.8)
            gaps = [(start, start + 0.95, one, other)]
        self._wall(near, far, gaps, from_start=True)

    def _chamfer(self, x: float, y: float, near: float) -> None:
        """Cut an outer corner of the building off by a diagonal wall."""
        reach = self.rng.uniform(0.9, 1.7)
        towards_x = reach * (1 if x < self.spec.size_m[0] / 2 else -1)
        towards_y = reach * self.rng.uniform(0.6, 1.4) * np.sign(near - y)
        self._prism([(x, y), (x + towards_x, y), (x, y + towards_y)])

    def _shell(self, sx: float, sy: float) -> None:
        t = OUTER_M
        for x0, y0, x1, y1 in ((0, 0, sx, t), (0, sy - t, sx, sy), (0, 0, t, sy), (sx - t, 0, sx, sy)):
            self._prism([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])

    def _wall(
        self,
        start: tuple[float, ...],
        end: tuple[float, ...],
        gaps: list[tuple[float, float, str, str]],
        *,
        from_start: bool = False,
    ) -> None:
        """Draw a wall with its doors; gaps count along the wall, or along the axis it follows."""
        first, last = np.array(start), np.array(end)
        length = float(np.hypot(*(last - first)))
        along = (last - first) / length
        offset = 0.0 if from_start else float(first[0] if abs(along[0]) > abs(along[1]) else first[1])
        at = -INNER_M / 2
        for lo, hi, one, other in sorted(gaps):
            self._prism(bar(first + along * at, first + along * (lo - offset), INNER_M))
            ends = np.stack([first + along * (lo - offset), first + along * (hi - offset)])
            self.doors.append(Door(ends, (one, other)))
            at = hi - offset
        self._prism(bar(first + along * at, first + along * (length + INNER_M / 2), INNER_M))

    def _prism(self, corners: list[tuple[float, float]] | Points) -> None:
        self.walls.append(Prism(_counter_clockwise(np.array(corners, dtype=np.float64)), HEIGHT_M))

    def _room(self, name: str, corners: Sequence[tuple[float, ...]]) -> None:
        outline = _counter_clockwise(np.array(corners, dtype=np.float64))
        self.rooms.append(Room(name, outline, outline.mean(axis=0)))


def _counter_clockwise(corners: Points) -> Points:
    x, y = corners.T
    return corners if np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0 else corners[::-1].copy()
