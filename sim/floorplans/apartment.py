"""Apartments: rooms of all sizes around each other, with a small hall or none, and no corridor."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from sim.floorplans.drafting import Pen
from sim.floorplans.shapes import rectangle
from sim.floorplans.spec import WorldSpec, require_count, require_share
from sim.floorplans.splitting import Split, area, draw_split, split


@dataclass(frozen=True, kw_only=True)
class Apartment(WorldSpec):
    """Apartment of three to eight rooms of unequal size, perhaps around a small hall.

    Parameters
    ----------
    rooms
        Number of rooms, the hall among them, 3 to 8.
    hall
        Probability of a small hall in the middle, where there are five rooms or more.
    """

    family: str = field(default="apartment", init=False)
    size_m: tuple[float, float] = (15.0, 11.0)
    rooms: int = 7
    hall: float = 0.6

    def check(self) -> None:
        """Refuse rooms that would be too narrow."""
        require_count("rooms", self.rooms, 3, 8)
        require_share("hall", self.hall)
        self.require_room(self.rooms * self.narrowest_m / 1.8, 2.2 * self.narrowest_m, f"{self.rooms} rooms")

    def draw(self, pen: Pen) -> None:
        """Split the floor, or the four rooms around a hall, and join the rooms by doors."""
        left, low, right, high = pen.box()
        pen.shell(rectangle(left, low, right, high))
        has_hall = self.rooms >= 5 and pen.rng.random() < self.hall
        floor = _pinwheel(pen, self.narrowest_m) if has_hall else Split([rectangle(left, low, right, high)], [])
        kept = [floor.pieces.pop()] if has_hall else []  # the hall is not split
        split(floor, self.rooms - len(kept), self.narrowest_m, pen.rng)
        floor.pieces += kept
        sizes = np.argsort([-area(piece) for piece in floor.pieces[: len(floor.pieces) - len(kept)]])
        names = [""] * len(floor.pieces)
        for rank, k in enumerate(sizes):
            names[k] = "living room" if rank == 0 else f"room {rank + 1}"
        if kept:
            names[-1] = "hall"
        draw_split(pen, floor, names, hub=len(names) - 1 if kept else int(sizes[0]))


def _pinwheel(pen: Pen, narrowest: float) -> Split:
    """Split the floor into four rooms in a pinwheel around a small hall, which comes last."""
    rng, (left, low, right, high) = pen.rng, pen.box()
    wide, deep = (rng.uniform(narrowest, max(narrowest, 0.3 * side)) for side in (right - left, high - low))
    x0 = left + narrowest + (right - left - wide - 2 * narrowest) * rng.uniform(0.2, 0.8)
    y0 = low + narrowest + (high - low - deep - 2 * narrowest) * rng.uniform(0.2, 0.8)
    x1, y1 = x0 + wide, y0 + deep
    pieces = [
        rectangle(left, low, x1, y0),
        rectangle(x1, low, right, y1),
        rectangle(x0, y1, right, high),
        rectangle(left, y0, x0, high),
        rectangle(x0, y0, x1, y1),
    ]
    lines = [[(left, y0), (x1, y0)], [(x1, low), (x1, y1)], [(right, y1), (x0, y1)], [(x0, high), (x0, y0)]]
    return Split(pieces, [np.array(line) for line in lines])
