"""Pieces of furniture: parts on the floor and between legs, with their heights."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from sim.floorplans.shapes import Points, disc, rectangle
from sim.world import Prism

LEG_M, BOARD_M = 0.05, 0.03
SEAT_M, TABLE_M = 0.45, 0.75


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """Model of a piece in its own frame: its parts, and its convex outline (N, 2), whose back lies on y = 0."""

    parts: tuple[Prism, ...]
    outline: Points

    def placed(self, at: Points, along: Points) -> Model:
        """Move the origin to a point (2,) and the x axis to a direction (2,)."""
        frame = np.stack([along, [-along[1], along[0]]])
        parts = tuple(replace(part, outline=at + part.outline @ frame) for part in self.parts)
        return Model(parts, at + self.outline @ frame)


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Piece of furniture in a room: its model, and the same in the frame of the building."""

    room: str
    model: Model
    put: Model


def cupboard(rng: np.random.Generator) -> Model:
    """Make a cupboard, shelf or sideboard that stands on the floor."""
    return block(rng.uniform(0.7, 2.0), rng.uniform(0.35, 0.65), float(rng.choice([0.75, 1.2, 1.9])))


def block(wide: float, deep: float, top: float, bottom: float = 0.0) -> Model:
    """Make a box."""
    outline = rectangle(0.0, 0.0, wide, deep)
    return Model((Prism(outline, top, bottom),), outline)


def sofa(rng: np.random.Generator) -> Model:
    """Make a sofa with arms, 0.1 m above the floor."""
    wide, deep = rng.uniform(1.3, 2.2), rng.uniform(0.8, 0.95)
    parts = [(0.0, 0.0, wide, 0.2, 0.8), (0.0, 0.0, 0.18, deep, 0.6), (wide - 0.18, 0.0, wide, deep, 0.6)]
    seat = Prism(rectangle(0.18, 0.2, wide - 0.18, deep), SEAT_M, 0.1)
    return Model((seat, *(Prism(rectangle(*at), top, 0.05) for *at, top in parts)), rectangle(0.0, 0.0, wide, deep))


def bed(wide: float = 0.95, long: float = 2.05) -> Model:
    """Make a bed on legs, its head at the wall."""
    mattress = Prism(rectangle(0.0, 0.0, wide, long), 0.55, 0.22)
    return Model((mattress, *_legs(mattress.outline, 0.6)), rectangle(0.0, 0.0, wide, long))


def desk(rng: np.random.Generator) -> Model:
    """Make a desk between side panels, with a chair before it."""
    wide, deep = rng.uniform(1.1, 1.7), rng.uniform(0.6, 0.8)
    panels = [rectangle(0.0, 0.0, 0.04, deep), rectangle(wide - rng.uniform(0.04, 0.45), 0.0, wide, deep)]
    top = Prism(rectangle(0.0, 0.0, wide, deep), TABLE_M, TABLE_M - BOARD_M)
    seat = chair(np.array([rng.uniform(0.3, 0.45) * wide, deep + rng.uniform(0.0, 0.15)]), rng.uniform(-0.5, 0.5))
    outline = rectangle(0.0, 0.0, wide, deep + 0.5)
    return Model((top, *(Prism(panel, TABLE_M - BOARD_M) for panel in panels), *seat), outline)


def table(rng: np.random.Generator) -> Model:
    """Make a table on four thin legs with chairs along its sides."""
    wide, deep = rng.uniform(1.1, 2.0), rng.uniform(0.7, 0.95)
    edge = rectangle(0.0, 0.35, wide, 0.35 + deep)
    top = Prism(edge, TABLE_M, TABLE_M - BOARD_M)
    seats: list[Prism] = []
    for x in np.linspace(0.0, wide, 2 + int(wide > 1.5) + 1)[1:-1]:
        for y, turn in ((0.18, np.pi), (0.52 + deep, 0.0)):
            if rng.random() < 0.8:
                seats += chair(np.array([x, y]), turn + rng.uniform(-0.3, 0.3))
    return Model((top, *_legs(edge, TABLE_M - BOARD_M), *seats), rectangle(0.0, 0.0, wide, deep + 0.7))


def round_table(rng: np.random.Generator) -> Model:
    """Make a round table on a column."""
    radius = rng.uniform(0.35, 0.6)
    middle = np.array([radius, radius])
    column = Prism(disc(middle, 0.09, 6), TABLE_M - BOARD_M)
    return Model((Prism(disc(middle, radius, 10), TABLE_M, TABLE_M - BOARD_M), column), disc(middle, radius, 10))


def island(rng: np.random.Generator) -> Model:
    """Make a free-standing solid box: a counter, a copier or a plant box."""
    return block(rng.uniform(0.6, 1.8), rng.uniform(0.5, 1.0), float(rng.uniform(0.75, 1.2)))


def chair(middle: Points, turn: float) -> tuple[Prism, ...]:
    """Make the parts of a chair on four legs, from the middle (2,) of its seat and its heading in radians."""
    along = np.array([np.cos(turn), np.sin(turn)])
    seat = Prism(rectangle(-0.2, -0.2, 0.2, 0.2), SEAT_M, SEAT_M - BOARD_M)
    loose = Model((seat, *_legs(seat.outline, SEAT_M - BOARD_M)), seat.outline)
    return loose.placed(middle, along).parts


AT_WALL = (cupboard, cupboard, desk, sofa)
STANDING = (table, round_table, island)


def _legs(edge: Points, top: float) -> Iterable[Prism]:
    low, high = edge.min(axis=0), edge.max(axis=0)
    for x in (low[0], high[0] - LEG_M):
        for y in (low[1], high[1] - LEG_M):
            yield Prism(rectangle(x, y, x + LEG_M, y + LEG_M), top)
