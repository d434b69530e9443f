"""Hospital wards: two rows of rooms along a corridor, identical without jitter."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rectmerge.errors import InputError
from sim.floorplans.drafting import JAMB_M, Gap, Pen
from sim.floorplans.pieces import Model, Piece, bed, block, chair
from sim.floorplans.rows import draw_row
from sim.floorplans.shapes import Points, rectangle
from sim.floorplans.spec import WorldSpec, require_count, require_within

BATH_M = (1.6, 1.8)  # a closed wet cell next to the door
CORRIDOR_M = 2.4
TURN_PER_M = 0.5  # radians that furniture turns per metre of jitter


@dataclass(frozen=True, kw_only=True)
class Hospital(WorldSpec):
    """Rows of identical rooms along a corridor, with their furniture, as long as there is no jitter.

    Parameters
    ----------
    rooms
        Number of rooms, even, 4 to 16.
    jitter_m
        Largest displacement of partitions, doors and furniture, 0 to 0.6 m. With 0, and nothing
        changed, shut or of glass, all rooms are the same, those across the corridor turned by half a turn.
    """

    family: str = field(default="hospital", init=False)
    size_m: tuple[float, float] = (24.0, 13.5)
    rooms: int = 10
    jitter_m: float = 0.0

    def check(self) -> None:
        """Refuse rooms that would be too narrow."""
        require_count("rooms", self.rooms, 4, 16)
        if self.rooms % 2:
            raise InputError(f"rooms must be even, half of them on each side, got {self.rooms}")
        require_within("jitter_m", self.jitter_m, 0.0, 0.6)
        cell = max(3.4, BATH_M[0] + self.door_m[0] + 2 * JAMB_M + self.wall_m[1]) + self.jitter_m
        self.require_room(self.rooms / 2 * cell, 2 * 4.6 + CORRIDOR_M, f"{self.rooms} rooms")

    def draw(self, pen: Pen) -> None:
        """Draw the corridor and the two rows, each from the same cell."""
        left, low, right, high = pen.box()
        pen.shell(rectangle(left, low, right, high))
        south, north = (low + high - CORRIDOR_M) / 2, (low + high + CORRIDOR_M) / 2
        pen.room("corridor", rectangle(left, south, right, north), is_bare=True)
        count, wide, deep = self.rooms // 2, (right - left) / (self.rooms // 2), south - low
        door = pen.door(BATH_M[0], wide, "", "")[0]
        for side, start, end in (("north", (left, north), (right, north)), ("south", (right, south), (left, south))):
            corner, along = np.array(start), np.array([1.0 if side == "north" else -1.0, 0.0])
            cuts = np.linspace(0.0, count * wide, count + 1)
            cuts[1:-1] += self._jitters(pen, count - 1)
            names = [f"{side} {k + 1}" for k in range(count)]
            gaps = [self._door(pen, door, cuts[k + 1] - cuts[k], name) for k, name in enumerate(names)]
            draw_row(pen, corner, np.array(end), deep, cuts, names, "corridor", doors=gaps)
            for k, name in enumerate(names):
                self._fill(pen, name, corner + along * cuts[k], along, (cuts[k + 1] - cuts[k], deep))

    def _door(self, pen: Pen, door: Gap, wide: float, name: str) -> Gap:
        """Return the door of a room: the same for every room, apart from jitter."""
        width, edge = door.end - door.start, JAMB_M + pen.inner_m / 2
        if self.jitter_m:
            width = min(float(pen.rng.uniform(*pen.door_m)), wide - BATH_M[0] - 2 * edge)
        at = door.start + float(self._jitters(pen, 1)[0])
        at = float(np.clip(at, BATH_M[0] + edge, wide - edge - width))
        return Gap(at, at + width, name, "corridor")

    def _fill(self, pen: Pen, name: str, corner: Points, along: Points, size: tuple[float, float]) -> None:
        """Put wet cell and furniture into a room whose frame has its origin at the near left corner."""
        frame = np.stack([along, [-along[1], along[0]]])
        edge = pen.inner_m / 2
        pen.block(corner + rectangle(0.0, 0.0, *BATH_M) @ frame)
        pen.bare.add(name)
        wanted = round(self.furniture * size[0] * size[1] / 10)
        for model, at, turn in _layout(size, edge)[:wanted]:
            heading = turn + TURN_PER_M * float(self._jitters(pen, 1)[0])
            local = model.placed(np.array(at) + self._jitters(pen, 2), np.array([np.cos(heading), np.sin(heading)]))
            low, high = local.outline.min(axis=0), local.outline.max(axis=0)
            within = np.maximum(edge - low, 0.0) + np.minimum(np.array(size) - edge - high, 0.0)
            put = local.placed(within, np.array([1.0, 0.0])).placed(corner, along)
            pen.pieces.append(Piece(name, model, put))

    def _jitters(self, pen: Pen, count: int) -> Points:
        return pen.rng.uniform(-self.jitter_m, self.jitter_m, count)


def _layout(size: tuple[float, float], edge: float) -> list[tuple[Model, tuple[float, float], float]]:
    """Return the furniture of a room of a ward, the most needed first: model, origin and heading."""
    wide, deep = size
    seat = Model(chair(np.array([0.25, 0.25]), 0.0), rectangle(0.0, 0.0, 0.5, 0.5))
    return [
        (bed(), (edge, deep - edge - 0.75), -np.pi / 2),
        (block(0.9, 0.6, 1.9), (wide - edge, deep - edge - 1.0), np.pi / 2),
        (block(0.45, 0.45, 0.75), (edge, deep - edge - 0.15), -np.pi / 2),
        (seat, (wide - edge - 0.6, deep - edge - 2.0), 0.0),
    ]
