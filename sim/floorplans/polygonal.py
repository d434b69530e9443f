"""The paper's simple environment: a few spaces among triangles and trapezoids, behind oblique walls."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rectmerge.errors import SimulationError
from sim.floorplans.drafting import Pen
from sim.floorplans.shapes import Points, rectangle
from sim.floorplans.spec import WorldSpec, require_count, require_share
from sim.floorplans.splitting import Split, cut_convex, draw_split, split


@dataclass(frozen=True, kw_only=True)
class Polygonal(WorldSpec):
    """A few rooms among triangles, trapezoids and oblique walls, as in the paper's simple environment.

    Two outer walls are parallel and one room is a triangle or a trapezoid, whatever is drawn: the conditions of the
    paper's conclusion.

    Parameters
    ----------
    rooms
        Number of rooms, 3 to 9.
    oblique
        Share of the inner walls that are not at right angles to the longest wall of the room they part.
    """

    family: str = field(default="polygonal", init=False)
    size_m: tuple[float, float] = (18.0, 13.0)
    rooms: int = 6
    oblique: float = 0.6

    def check(self) -> None:
        """Refuse rooms that would be too narrow."""
        require_count("rooms", self.rooms, 3, 9)
        require_share("oblique", self.oblique)
        least = self.narrowest_m + 0.4
        self.require_room(self.rooms * least / 1.3, 2.8 * least, f"{self.rooms} rooms")

    def draw(self, pen: Pen) -> None:
        """Cut corners off the building, and a triangle off its floor, and split the rest."""
        rng, (left, low, right, high) = pen.rng, pen.box()
        outline, reach = rectangle(left, low, right, high), min(right - left, high - low)
        for k in rng.permutation(4)[: int(rng.integers(1, 3))]:
            outline, _, _ = self._without_corner(outline, _corner(pen, k), reach * rng.uniform(0.15, 0.3, 2))
        pen.shell(outline)
        triangle = max(self.narrowest_m * 1.9, reach * rng.uniform(0.4, 0.55))
        whole = [k for k in range(4) if (np.abs(outline - _corner(pen, k)).max(axis=1) < 1e-9).any()]
        at = _corner(pen, int(rng.choice(whole)))
        rest, corner, line = self._without_corner(outline, at, triangle * rng.uniform(0.9, 1.25, 2))
        floor = Split([rest], [line])
        split(floor, self.rooms - 1, self.narrowest_m + 0.2, rng, oblique=self.oblique)
        floor.pieces.append(corner)
        draw_split(pen, floor, [f"room {k + 1}" for k in range(self.rooms)])

    @staticmethod
    def _without_corner(outline: Points, corner: Points, legs: Points) -> tuple[Points, Points, Points]:
        """Cut a corner off; returns the rest, the triangle, and the line between them."""
        towards = np.sign(outline.mean(axis=0) - corner)
        p, q = corner + np.diag(towards * legs)
        direction = (q - p) / np.hypot(*(q - p))
        right = np.array([direction[1], -direction[0]])
        if (corner - p) @ right > 0:  # the corner is to lie on the left
            direction, right = -direction, -right
        parts = cut_convex(outline, direction, float(p @ right))
        if parts is None:
            raise SimulationError("a corner of this draft cannot be cut off")
        return parts


def _corner(pen: Pen, k: int) -> Points:
    corner: Points = rectangle(*pen.box())[k]
    return corner
