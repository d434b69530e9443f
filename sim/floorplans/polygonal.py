"""Simple environment of the paper: a few spaces among triangles and trapezoids, behind oblique walls."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from rectmerge.errors import InputError, SimulationError
from sim.floorplans.drafting import Pen
from sim.floorplans.shapes import Points, rectangle
from sim.floorplans.spec import WorldSpec, require_count, require_share
from sim.floorplans.splitting import Split, cut_convex, draw_split, split

OUTLINES = ("cut", "irregular", "trapezoid", "rectangle", "u")


@dataclass(frozen=True, kw_only=True)
class Polygonal(WorldSpec):
    """Polygonal rooms: triangles, trapezoids and oblique walls, as in the simple environment of the paper.

    Unless an outline is given, two outer walls are parallel and one room is a triangle or a trapezoid: the conditions
    of the conclusion of the paper.

    Parameters
    ----------
    rooms
        Number of rooms, 3 to 9; 1 to 9 where the outline is given, and 1 in a "u".
    oblique
        Share of the inner walls that are not at right angles to the longest wall of the room that they divide.
    outline
        "cut": a rectangle with one or two corners cut off, and a room that is a triangle. A quadrilateral without
        either: "irregular", where no two outer walls are parallel; "trapezoid", where two are, the longest;
        "rectangle", where two pairs are. "u": one space that is no rectangle, but in which three rectangles are found.
    """

    family: str = field(default="polygonal", init=False)
    size_m: tuple[float, float] = (18.0, 13.0)
    rooms: int = 6
    oblique: float = 0.6
    outline: Literal["cut", "irregular", "trapezoid", "rectangle", "u"] = "cut"

    def check(self) -> None:
        """Refuse rooms that would be too narrow."""
        if self.outline not in OUTLINES:
            raise InputError(f"outline must be one of {', '.join(OUTLINES)}, got {self.outline!r}")
        require_count("rooms", self.rooms, 3 if self.outline == "cut" else 1, 1 if self.outline == "u" else 9)
        require_share("oblique", self.oblique)
        least = self.narrowest_m + 0.4
        self.require_room(max(2.0, self.rooms / 1.3) * least, 2.8 * least, f"{self.rooms} rooms")

    def draw(self, pen: Pen) -> None:
        """Draw the outline and split the floor within."""
        if self.outline == "cut":
            self._draw_cut(pen)
        elif self.outline == "u":
            self._draw_u(pen)
        else:
            outline = self._quadrilateral(pen)
            pen.shell(outline)
            floor = Split([outline], [])
            split(floor, self.rooms, self.narrowest_m + 0.2, pen.rng, oblique=self.oblique)
            draw_split(pen, floor, [f"room {k + 1}" for k in range(self.rooms)])

    def _quadrilateral(self, pen: Pen) -> Points:
        """Lean the sides of a rectangle: the upright ones of a trapezoid, of an irregular one the upper one too."""
        outline = rectangle(*pen.box())
        reach = outline.max(axis=0) - outline.min(axis=0)
        if self.outline != "rectangle":
            inwards = reach[0] * pen.rng.permutation([pen.rng.uniform(0.05, 0.1), pen.rng.uniform(0.18, 0.25)])
            outline[2, 0] -= inwards[0]
            outline[3, 0] += inwards[1]
        if self.outline == "irregular":
            outline[pen.rng.integers(2, 4), 1] -= reach[1] * pen.rng.uniform(0.15, 0.25)
        return outline

    def _draw_u(self, pen: Pen) -> None:
        """Draw a bar along the lower side and an arm up from either end, of different widths and lengths."""
        rng, (left, low, right, high) = pen.rng, pen.box()
        wide, deep = right - left, high - low
        arms = wide * rng.permutation([rng.uniform(0.22, 0.27), rng.uniform(0.3, 0.36)])
        tops = high - deep * rng.permutation([0.0, rng.uniform(0.1, 0.2)])
        bar, x0, x1 = low + deep * rng.uniform(0.38, 0.48), left + arms[0], right - arms[1]
        zones = {
            "bar": rectangle(left, low, right, bar),
            "left arm": rectangle(left, bar, x0, tops[0]),
            "right arm": rectangle(x1, bar, right, tops[1]),
        }
        pen.shell(
            [
                (left, low),
                (right, low),
                (right, tops[1]),
                (x1, tops[1]),
                (x1, bar),
                (x0, bar),
                (x0, tops[0]),
                (left, tops[0]),
            ]
        )
        for name, zone in zones.items():
            pen.room(name, zone)
            if name != "bar":
                pen.join("bar", name)

    def _draw_cut(self, pen: Pen) -> None:
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
        """Cut a corner off and return the rest, the triangle, and the line between them."""
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
