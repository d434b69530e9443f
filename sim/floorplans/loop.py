"""Loops: a corridor that runs around a core, with rooms outside and inside of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from rectmerge.errors import SimulationError
from sim.floorplans.drafting import Pen
from sim.floorplans.rows import cut_widths, draw_row
from sim.floorplans.shapes import rectangle
from sim.floorplans.spec import WorldSpec, require_count

CORRIDOR_M = 1.7
Box = tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class Loop(WorldSpec):
    """Ring corridor around a core: rooms on two to four sides outside, some within.

    Parameters
    ----------
    rooms
        Number of rooms outside the ring, 2 to 16.
    core
        Number of rooms within the ring, 0 to 4; with none, the core is shut.
    """

    has_storeys: ClassVar[bool] = True
    family: str = field(default="loop", init=False)
    size_m: tuple[float, float] = (21.0, 16.0)
    rooms: int = 8
    core: int = 2

    def check(self) -> None:
        """Refuse rooms that would be too narrow."""
        require_count("rooms", self.rooms, 2, 16)
        require_count("core", self.core, 0, 4)
        least, ring = self.narrowest_m, 2 * self._corridor_m
        along = ring + max(self.core * least, (self.rooms + 1) // 2 * least - ring, least)
        self.require_room(along, 3 * least + ring, f"{self.rooms} rooms around {self.core}")

    @property
    def _corridor_m(self) -> float:
        return CORRIDOR_M + self.wall_m[1]

    def draw(self, pen: Pen) -> None:
        """Draw the ring, the rooms on its sides, and the core."""
        rng, (left, low, right, high) = pen.rng, pen.box()
        pen.shell(rectangle(left, low, right, high))
        wide, least = self._corridor_m * rng.uniform(1.0, 1.2), self.narrowest_m
        spare = [(right - left - 2 * wide) - max(1, self.core) * least, (high - low - 2 * wide) - least]
        depths = [max(least, 0.5 * spare[1] * rng.uniform(0.7, 0.9)) for _ in range(2)]
        sides = [0.5 * spare[0] * rng.uniform(0.4, 0.7) for _ in range(2)]
        sides = [depth if depth >= least and rng.random() < 0.6 else 0.0 for depth in sides]
        ring = (left + sides[0], low + depths[0], right - sides[1], high - depths[1])
        self._corridors(pen, ring, wide)
        pen.begin_rooms()
        self._outside(pen, ring, wide)
        self._inside(pen, (ring[0] + wide, ring[1] + wide, ring[2] - wide, ring[3] - wide))

    def _corridors(self, pen: Pen, ring: Box, wide: float) -> None:
        left, low, right, high = ring
        legs = {
            "south": rectangle(left, low, right, low + wide),
            "east": rectangle(right - wide, low + wide, right, high - wide),
            "north": rectangle(left, high - wide, right, high),
            "west": rectangle(left, low + wide, left + wide, high - wide),
        }
        names = [f"corridor {side}" for side in legs]
        for name, outline, after in zip(names, legs.values(), names[1:] + names[:1], strict=True):
            pen.room(name, outline, is_bare=True)
            pen.join(name, after)

    def _outside(self, pen: Pen, ring: Box, wide: float) -> None:
        """Draw the rooms around the ring; those to the south and north reach to the building's corners."""
        (left, low, right, high), (x0, y0, x1, y1) = pen.box(), ring
        corners = {  # both ends of the wall, the rooms to its left, and the depth
            "south": ((right, y0), (left, y0), y0 - low, (right - x1, right - x0)),
            "north": ((left, y1), (right, y1), high - y1, (x0 - left, x1 - left)),
            "east": ((x1, y1), (x1, y0), right - x1, (0.0, y1 - y0)),
            "west": ((x0, y0), (x0, y1), x0 - left, (0.0, y1 - y0)),
        }
        spans = {side: at[3][1] - at[3][0] for side, at in corners.items() if at[2] >= self.narrowest_m - 1e-9}
        counts = self._shares(spans)
        for side, count in counts.items():
            start, end, depth, reach = corners[side]
            cuts = cut_widths(pen.rng, *reach, count, self.narrowest_m)
            cuts[0], cuts[-1] = 0.0, np.hypot(end[0] - start[0], end[1] - start[1])
            names = [f"{side} {k + 1}" for k in range(count)]
            draw_row(pen, np.array(start), np.array(end), depth, cuts, names, f"corridor {side}", reach=reach)

    def _shares(self, spans: dict[str, float]) -> dict[str, int]:
        """Return the number of rooms on each side: at least one, more where there is more wall."""
        counts = dict.fromkeys(spans, 1)
        if len(counts) > self.rooms:
            raise SimulationError(f"{self.rooms} rooms cannot lie on {len(counts)} sides")
        for _ in range(self.rooms - len(counts)):
            side = max(spans, key=lambda side: spans[side] / (counts[side] + 1))
            counts[side] += 1
        if any(spans[side] / count < self.narrowest_m for side, count in counts.items()):
            raise SimulationError(f"{self.rooms} rooms do not fit around this ring")
        return counts

    def _inside(self, pen: Pen, core: Box) -> None:
        """Draw the core's rooms side by side, each with a door to the south or to the north."""
        left, low, right, high = core
        cuts = cut_widths(pen.rng, left, right, max(1, self.core), self.narrowest_m)
        edge = pen.inner_m / 2  # closes the core's corners
        gaps: dict[str, list[tuple[float, float, str]]] = {"south": [], "north": []}
        for k in range(self.core):
            pen.room(f"core {k + 1}", rectangle(cuts[k], low, cuts[k + 1], high))
            side = "south" if pen.rng.random() < 0.5 else "north"
            gaps[side].append((cuts[k] - left + edge, cuts[k + 1] - left + edge, f"core {k + 1}"))
        for side, y in (("south", low), ("north", high)):
            doors = [gap for start, end, name in gaps[side] for gap in pen.door(start, end, name, f"corridor {side}")]
            pen.wall([(left - edge, y), (right + edge, y)], doors)
        for x in cuts if self.core else (left, right):
            pen.wall([(x, low), (x, high)])
