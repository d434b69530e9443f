"""Offices: rooms of unequal width on both sides of a corridor."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from sim.floorplans.drafting import JAMB_M, Gap, Pen
from sim.floorplans.rows import cut_widths, draw_partition
from sim.floorplans.shapes import Points
from sim.floorplans.spec import WorldSpec, require_count, require_share

Corner = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Office(WorldSpec):
    """Office rooms on both sides of a corridor, doors between some, a back room, some oblique walls.

    Parameters
    ----------
    rooms
        Number of rooms along the corridor, 6 to 12.
    oblique
        Probability that the building has walls that are not at right angles.
    """

    has_storeys: ClassVar[bool] = True
    family: str = field(default="office", init=False)
    rooms: int = 8
    oblique: float = 0.3

    def check(self) -> None:
        """Refuse rooms that would be too narrow."""
        require_count("rooms", self.rooms, 6, 12)
        require_share("oblique", self.oblique)
        self.require_room(self.band_m(self.rooms), 2 * self.narrowest_m + 2.8, f"{self.rooms} rooms beside a corridor")

    def band_m(self, rooms: int) -> float:
        """Return the length in metres that the longer of two bands needs for its rooms."""
        return round(0.58 * rooms) * (self.narrowest_m + 0.1)

    def draw(self, pen: Pen) -> None:
        """Draw shell, corridor, an end hall perhaps, and a band of rooms on either side."""
        rng, (left, low, right, high) = pen.rng, pen.box()
        pen.shell([(left, low), (right, low), (right, high), (left, high)])
        wide = max(rng.uniform(1.7, 2.3), pen.door_m[0] + 2 * JAMB_M + pen.inner_m)
        south = low + (high - low - wide) * rng.uniform(0.4, 0.6)
        north, count, end = south + wide, self.rooms, right
        if rng.random() < 0.6 and right - left > 4.6 + self.band_m(count - 1):
            end, count = right - rng.uniform(3.2, 4.6), count - 1
        pen.room("corridor", [(left, south), (end, south), (end, north), (left, north)], is_bare=True)
        if end < right:
            pen.room("hall", [(end, low), (right, low), (right, high), (end, high)])
            pen.wall([(end, low), (end, high)], pen.door(south - low, north - low, "corridor", "hall"))
        rng = pen.begin_rooms()
        above = round(count * rng.uniform(0.42, 0.58))
        bands = _Bands(pen, self.narrowest_m, is_oblique=bool(rng.random() < self.oblique))
        bands.draw("north", (left, end), (north, high), above)
        bands.draw("south", (left, end), (south, low), count - above)


class _Bands:
    """Bands of rooms on both sides of the corridor of one office."""

    def __init__(self, pen: Pen, narrowest_m: float, *, is_oblique: bool) -> None:
        self.pen, self.rng, self.narrowest_m, self.is_oblique = pen, pen.rng, narrowest_m, is_oblique

    def draw(self, side: str, span: Corner, depth: Corner, count: int) -> None:
        """Draw `count` rooms between the corridor's wall (y = depth[0]) and the outer wall (y = depth[1])."""
        rng, (near, far) = self.rng, depth
        has_back = count >= 3 and abs(far - near) > 2 * self.narrowest_m and rng.random() < 0.6
        slots = count - 1 if has_back else count
        at_near = cut_widths(rng, *span, slots, self.narrowest_m)
        at_far = at_near + self._slants(at_near)
        names = [f"{side} {k + 1}" for k in range(slots)]
        back = int(rng.integers(slots)) if has_back else -1
        lobby = int(rng.integers(slots)) if slots >= 3 and rng.random() < 0.35 else -1
        for k, name in enumerate(names):
            corners = [(at_near[k], near), (at_near[k + 1], near), (at_far[k + 1], far), (at_far[k], far)]
            if k == back:
                self._split(name, corners)
            else:
                self.pen.room(name, corners)
            gaps = self._entrance(name, at_near[k + 1] - at_near[k], is_lobby=k == lobby != back)
            self.pen.wall(corners[:2], gaps)
        for k in range(1, slots):
            ends = np.array([at_near[k], near]), np.array([at_far[k], far])
            draw_partition(self.pen, *ends, names[k - 1], names[k], may_have_door=back not in (k - 1, k))
        if self.is_oblique and rng.random() < 0.7 and slots - 1 != back:
            self._chamfer(span[0] if rng.random() < 0.5 and back != 0 else span[1], far, near)

    def _slants(self, cuts: Points) -> Points:
        """Return the lean of each partition along the corridor; the ends stand upright."""
        lean = np.zeros(len(cuts))
        if self.is_oblique and len(cuts) > 2:
            k = int(self.rng.integers(1, len(cuts) - 1))
            room = 0.45 * min(cuts[k] - cuts[k - 1], cuts[k + 1] - cuts[k])
            lean[k] = self.rng.choice([-1, 1]) * self.rng.uniform(0.5, 1.0) * room
        return lean

    def _entrance(self, name: str, wide: float, *, is_lobby: bool) -> list[Gap]:
        """Choose the opening of a room to the corridor: a door, or the whole width for a lobby."""
        if is_lobby:
            return [Gap(0.3, wide - 0.3, name, "corridor", is_door=False)]
        return self.pen.door(0.0, wide, name, "corridor")

    def _split(self, name: str, corners: list[Corner]) -> None:
        """Make a front room and a back room that is reached through it."""
        a, b, c, d = (np.array(p) for p in corners)
        share = self.rng.uniform(0.45, 0.6)
        left, right = a + (d - a) * share, b + (c - b) * share
        self.pen.room(name, [a, b, right, left])
        self.pen.room(f"{name} back", [left, right, c, d])
        self.pen.wall([left, right], self.pen.door(0.0, float(np.hypot(*(right - left))), name, f"{name} back"))

    def _chamfer(self, x: float, y: float, near: float) -> None:
        """Cut an outer corner of the building off by a diagonal wall."""
        reach = self.rng.uniform(0.9, 1.7)
        towards_x = reach * (1 if x < self.pen.size_m[0] / 2 else -1)
        towards_y = reach * self.rng.uniform(0.6, 1.4) * np.sign(near - y)
        self.pen.block([(x, y), (x + towards_x, y), (x, y + towards_y)])
