"""Warehouses: racks with pallets along aisles, a loading zone and an office."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from sim.floorplans.drafting import Pen
from sim.floorplans.pieces import Piece, block
from sim.floorplans.shapes import rectangle
from sim.floorplans.spec import WorldSpec, require_share, require_within

RACK_M, BAY_M, POST_M, RACK_TOP_M = 1.1, 2.8, 0.1, 2.4
BACK_M = 0.1  # between two racks back to back
LOADING_M, CROSS_M, OFFICE_M = 5.0, 2.2, 3.6


@dataclass(frozen=True, kw_only=True)
class Warehouse(WorldSpec):
    """Racks with pallets along aisles, a loading zone and a small office.

    The pallets are furniture: a share of them changes between the visits.

    Parameters
    ----------
    aisle_m
        Least width of the aisles, 1.8 to 5 m.
    fill
        Share of the places in the racks that hold a pallet.
    """

    family: str = field(default="warehouse", init=False)
    size_m: tuple[float, float] = (26.0, 17.0)
    furniture: float = 0.6
    aisle_m: float = 2.4
    fill: float = 0.6

    def check(self) -> None:
        """Refuse a floor without room for an aisle."""
        require_within("aisle_m", self.aisle_m, 1.8, 5.0)
        require_share("fill", self.fill)
        across = max(2 * RACK_M + self.aisle_m, OFFICE_M + 3.0)
        self.require_room(LOADING_M + 2 * BAY_M + CROSS_M, across, "racks, a loading zone and an office")

    def draw(self, pen: Pen) -> None:
        """Draw loading zone and office on the left, racks and aisles, and an aisle across at the right end."""
        rng, (left, low, right, high) = pen.rng, pen.box()
        pen.shell(rectangle(left, low, right, high))
        start = left + LOADING_M * rng.uniform(1.0, 1.2)
        bays = math.floor((right - CROSS_M - start) / BAY_M)
        stop = start + bays * BAY_M
        office = max(OFFICE_M, self.narrowest_m) * rng.uniform(0.9, 1.1)
        pen.room("office", rectangle(left, low, start, low + office))
        pen.room("loading", rectangle(left, low + office, start, high))
        pen.wall([(left, low + office), (start, low + office)], pen.door(0.0, start - left, "office", "loading"))
        pen.wall([(start, low + office), (start, low)])
        pen.room("cross aisle", rectangle(stop, low, right, high), is_bare=True)
        edge, racks = pen.inner_m / 2, 2 * RACK_M + BACK_M
        room = high - low - 2 * edge + BACK_M
        count = math.floor(room / (self.aisle_m + racks))
        wide = room / count - racks
        self._rack(pen, low + edge, (start, stop))
        pen.pave(rectangle(start, low, stop, low + edge + RACK_M))
        for k in range(count):
            at = low + edge + RACK_M + k * (wide + racks)
            name, end = f"aisle {k + 1}", at + wide
            pen.room(name, rectangle(start, at, stop, end), is_bare=True)
            pen.join(name, "cross aisle")
            if end > low + office + 1.0:
                pen.join(name, "loading")
            pen.pave(rectangle(start, end, stop, high if k == count - 1 else end + racks))
            self._rack(pen, end, (start, stop))
            if k < count - 1:
                self._rack(pen, end + RACK_M + BACK_M, (start, stop))

    def _rack(self, pen: Pen, low: float, span: tuple[float, float]) -> None:
        """Add the uprights of a rack, and pallets in some of its places, two to a bay."""
        rng, bays = pen.rng, round((span[1] - span[0]) / BAY_M)
        for x in span[0] + BAY_M * np.arange(bays + 1) - POST_M / 2:
            for y in (low, low + RACK_M - POST_M):
                pen.block(rectangle(x, y, x + POST_M, y + POST_M), RACK_TOP_M, is_wall=False)
        for place in range(2 * bays):
            model = block(1.2, rng.uniform(0.8, 1.0), rng.uniform(0.5, 1.4))
            x = span[0] + BAY_M / 2 * place + 0.1 + rng.uniform(0.0, 0.05)
            pallet = Piece(
                "racks", model, model.placed(np.array([x, low + rng.uniform(0.02, 0.1)]), np.array([1.0, 0.0]))
            )
            (pen.pieces if rng.random() < self.fill else pen.spares).append(pallet)
