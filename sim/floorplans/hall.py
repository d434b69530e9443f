"""Halls: one large space with rows of pillars, and a few rooms at one end."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from sim.floorplans.drafting import Pen
from sim.floorplans.rows import cut_widths, draw_row
from sim.floorplans.shapes import Points, disc, rectangle
from sim.floorplans.spec import WorldSpec, require_count, require_share, require_within

ZONE_M = 7.0  # the hall is several rooms side by side, each about so long
SIDE_DEPTH_M = 3.6


@dataclass(frozen=True, kw_only=True)
class Hall(WorldSpec):
    """Hall with rows of pillars, and a few rooms at one end.

    Parameters
    ----------
    spacing_m
        From pillar to pillar, about, 3 to 10 m.
    jitter_m
        Largest displacement of pillars, 0 to 1 m.
    missing
        Share of the pillars that are left out.
    side_rooms
        Number of rooms at the end, 0 to 4.
    """

    family: str = field(default="hall", init=False)
    size_m: tuple[float, float] = (24.0, 16.0)
    furniture: float = 0.4
    spacing_m: float = 4.5
    jitter_m: float = 0.1
    missing: float = 0.1
    side_rooms: int = 3

    def check(self) -> None:
        """Refuse pillars and rooms that do not fit."""
        require_within("spacing_m", self.spacing_m, 3.0, 10.0)
        require_within("jitter_m", self.jitter_m, 0.0, 1.0)
        require_share("missing", self.missing)
        require_count("side_rooms", self.side_rooms, 0, 4)
        depth = max(SIDE_DEPTH_M, self.narrowest_m) if self.side_rooms else 0.0
        self.require_room(
            depth + 6.0, max(5.0, self.side_rooms * self.narrowest_m), f"a hall and {self.side_rooms} rooms"
        )

    def draw(self, pen: Pen) -> None:
        """Draw the hall in zones, its pillars, and the rooms at its right end."""
        rng, (left, low, right, high) = pen.rng, pen.box()
        pen.shell(rectangle(left, low, right, high))
        end = right - max(SIDE_DEPTH_M * rng.uniform(0.9, 1.1), self.narrowest_m) if self.side_rooms else right
        ends = np.linspace(left, end, max(2, round((end - left) / ZONE_M)) + 1)
        for k in range(len(ends) - 1):
            pen.room(f"hall {k + 1}", rectangle(ends[k], low, ends[k + 1], high))
            if k:
                pen.join(f"hall {k}", f"hall {k + 1}")
        if self.side_rooms:
            cuts = cut_widths(rng, 0.0, high - low, self.side_rooms, self.narrowest_m)
            names = [f"side {k + 1}" for k in range(self.side_rooms)]
            draw_row(
                pen, np.array([end, high]), np.array([end, low]), right - end, cuts, names, f"hall {len(ends) - 1}"
            )
        self._pillars(pen, (left, low, end, high))

    def _pillars(self, pen: Pen, space: tuple[float, float, float, float]) -> None:
        """Stand pillars of one kind on a grid."""
        rng, (left, low, right, high) = pen.rng, space
        is_round, half = bool(rng.random() < 0.5), rng.uniform(0.15, 0.35)
        across, up = (math.ceil((hi - lo) / self.spacing_m - 0.5) for lo, hi in ((left, right), (low, high)))
        for x in np.linspace(left, right, max(2, across) + 1)[1:-1]:
            for y in np.linspace(low, high, max(2, up) + 1)[1:-1]:
                middle = np.array([x, y]) + rng.uniform(-self.jitter_m, self.jitter_m, 2)
                if rng.random() >= self.missing:
                    pen.block(disc(middle, half, 12) if is_round else _square(middle, half))


def _square(middle: Points, half: float) -> Points:
    return middle + rectangle(-half, -half, half, half)
