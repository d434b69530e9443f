"""Round buildings: a rotunda in the middle, and rooms between its wall and the outer one."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from sim.floorplans.drafting import Gap, Pen
from sim.floorplans.rows import THROUGH
from sim.floorplans.shapes import Points, disc
from sim.floorplans.spec import WorldSpec, require_count

SIDES = 56  # of the outer wall
INNER_SHARE = 0.45  # of the radius, the rotunda's


@dataclass(frozen=True, kw_only=True)
class Round(WorldSpec):
    """Round or oval building: a rotunda, and rooms like slices around it.

    Parameters
    ----------
    rooms
        Number of rooms around the rotunda, 5 to 12.
    """

    family: str = field(default="round", init=False)
    size_m: tuple[float, float] = (19.0, 17.0)
    rooms: int = 7

    def check(self) -> None:
        """Refuse rooms that would be too narrow."""
        require_count("rooms", self.rooms, 5, 12)
        across = 2 * max(self.rooms * self.narrowest_m / (math.tau * INNER_SHARE * 0.95), 1.9 * self.narrowest_m)
        self.require_room(across, across, f"{self.rooms} rooms around a rotunda")

    def draw(self, pen: Pen) -> None:
        """Draw the outer wall, the rotunda and, slice by slice, the rooms."""
        rng, (left, low, right, high) = pen.rng, pen.box()
        middle, reach = np.array([left + right, low + high]) / 2, np.array([right - left, high - low]) / 2

        def at(angle: ArrayLike, radius: ArrayLike) -> Points:
            turned = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
            points: Points = middle + reach * turned * np.asarray(radius)[..., None]
            return points

        least = 0.6 + 0.4 * (rng.random() < 0.3)
        shares = least + (1 - least) * self.rooms * rng.dirichlet(np.full(self.rooms, 3.0))
        cuts = rng.uniform(0, math.tau) + np.concatenate([[0.0], np.cumsum(shares)]) * (math.tau / self.rooms)
        inner = INNER_SHARE * rng.uniform(0.95, 1.1)
        slices = [_arc(cuts[k], cuts[k + 1]) for k in range(self.rooms)]
        ring = np.concatenate([arc[:-1] for arc in slices])
        pen.shell(at(ring, np.ones(len(ring))))
        pen.room("rotunda", at(ring, np.full(len(ring), inner)))
        lobby = int(rng.integers(self.rooms)) if rng.random() < 0.5 else -1
        for k, arc in enumerate(slices):
            name, tangent = f"room {k + 1}", inner / np.cos(arc - (arc[0] + arc[-1]) / 2)
            ends = at(arc[[-1, 0]], tangent[[-1, 0]])
            pen.room(name, np.concatenate([at(arc, np.ones(len(arc))), ends]))
            self._wedges(pen, at(arc, np.full(len(arc), inner)), at(arc, tangent))
            self._front(pen, at(arc, np.full(len(arc), inner)), name, is_lobby=k == lobby)
            radial = at(arc[[0, 0]], [inner, 1.0])
            between = pen.door(
                1.0, float(np.hypot(*(radial[1] - radial[0]))) - 0.5, f"room {k or self.rooms}", name, is_needed=False
            )
            pen.wall(radial, between if rng.random() < THROUGH else [])
        if rng.random() < 0.5:
            pen.block(disc(middle, rng.uniform(0.5, 0.9), 12), 1.1, is_wall=False)

    def _front(self, pen: Pen, arc: Points, name: str, *, is_lobby: bool) -> None:
        """Draw the curved wall between a room and the rotunda."""
        length = float(np.hypot(*np.diff(arc, axis=0).T).sum())
        opening = [Gap(0.3, length - 0.3, name, "rotunda", is_door=False)]
        pen.wall(arc, opening if is_lobby else pen.door(0.0, length, name, "rotunda"))

    def _wedges(self, pen: Pen, arc: Points, tangent: Points) -> None:
        """Pave the floor between the curved wall of the rotunda and the straight near side of the outline of a room."""
        for k in range(len(arc) - 1):
            corners = np.stack([arc[k], tangent[k], tangent[k + 1], arc[k + 1]])
            pen.pave(
                corners[
                    [
                        True,
                        np.hypot(*(tangent[k] - arc[k])) > 1e-9,
                        np.hypot(*(tangent[k + 1] - arc[k + 1])) > 1e-9,
                        True,
                    ]
                ]
            )


def _arc(start: float, end: float) -> Points:
    """Return angles along a slice, with one in the middle."""
    return np.linspace(start, end, 2 * max(2, round(SIDES * (end - start) / (2 * math.tau))) + 1)
