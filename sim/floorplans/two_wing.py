"""Buildings of two wings that meet at an odd angle in a joint hall, with two dominant orientations."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from rectmerge.errors import InputError, SimulationError
from sim.floorplans.drafting import Gap, Pen
from sim.floorplans.rows import cut_widths, draw_row
from sim.floorplans.shapes import Points
from sim.floorplans.spec import WorldSpec, require_count

CORRIDOR_M = 1.7


@dataclass(frozen=True, kw_only=True)
class TwoWing(WorldSpec):
    """Two wings with rooms along corridors that meet at an odd angle in a joint hall.

    Parameters
    ----------
    rooms
        Number of rooms in both wings, 4 to 16.
    angle_deg
        Least and greatest angle by which one wing is turned against the other, within 25 to 65.
    """

    family: str = field(default="two-wing", init=False)
    size_m: tuple[float, float] = (28.0, 19.0)
    rooms: int = 8
    angle_deg: tuple[float, float] = (25.0, 65.0)

    def check(self) -> None:
        """Refuse rooms that would be too narrow."""
        require_count("rooms", self.rooms, 4, 16)
        if not (len(self.angle_deg) == 2 and 25 <= self.angle_deg[0] <= self.angle_deg[1] <= 65):
            raise InputError(f"angle_deg must be two ascending numbers within 25 to 65, got {list(self.angle_deg)}")
        for degrees in self.angle_deg:
            if not self._fits(self._lengths(math.radians(degrees), self._least_depth_m, self.inside_m)):
                raise InputError(f"size_m: {self.rooms} rooms do not fit into wings turned by {degrees} degrees")

    @property
    def _corridor_m(self) -> float:
        return CORRIDOR_M + self.wall_m[1]

    @property
    def _least_depth_m(self) -> float:
        return 2 * self.narrowest_m + self._corridor_m

    @staticmethod
    def _lengths(angle: float, depth: float, size: tuple[float, float]) -> tuple[float, float]:
        """Return the lengths of the wings that fit into a size, about equal if possible."""
        room = size[0] - depth * math.sin(angle)
        second = min(room / (1 + math.cos(angle)), (size[1] - depth) / math.sin(angle))
        return room - second * math.cos(angle), second

    def _fits(self, lengths: tuple[float, float]) -> bool:
        """Return whether the rooms fit along the corridors of the wings."""
        most = [math.floor(length / self.narrowest_m) for length in lengths]
        return min(most) >= 1 and 2 * sum(most) >= self.rooms

    def draw(self, pen: Pen) -> None:
        """Draw the first wing to the left of the joint, the second turned to the right of it."""
        rng, edge = pen.rng, 1.42 * (pen.outer_m - pen.inner_m / 2)  # a turned corner reaches so far
        size = self.size_m[0] - 2 * edge, self.size_m[1] - 2 * edge
        angle = math.radians(rng.uniform(*self.angle_deg))
        depth = max(self._least_depth_m, 0.55 * size[1] * rng.uniform(0.8, 1.0))
        if not self._fits(self._lengths(angle, depth, size)):
            depth = self._least_depth_m
        lengths = self._lengths(angle, depth, size)
        along = np.array([math.cos(angle), math.sin(angle)])
        inner, foot = np.array([0.0, depth]), np.array([0.0, depth]) + depth * np.array([along[1], -along[0]])
        outer = np.array([depth * math.tan(angle / 2), 0.0])
        ends = inner - [lengths[0], 0.0], foot + along * lengths[1]
        far = [inner - [lengths[0], depth], outer, ends[1], inner + along * lengths[1], inner, ends[0]]
        pen.shell(far)
        pen.room("joint", [np.zeros(2), outer, foot, inner])
        counts = self._counts(lengths)
        self._wing(pen, "west", inner, np.array([-1.0, 0.0]), (lengths[0], depth), counts[:2])
        self._wing(pen, "east", foot, along, (lengths[1], depth), counts[2:])

    def _counts(self, lengths: tuple[float, float]) -> list[int]:
        """Return the number of rooms on each side of each wing."""
        counts = [1, 1, 1, 1]
        for _ in range(self.rooms - 4):
            k = max(range(4), key=lambda k: lengths[k // 2] / (counts[k] + 1))
            counts[k] += 1
        if any(lengths[k // 2] / count < self.narrowest_m for k, count in enumerate(counts)):
            raise SimulationError(f"{self.rooms} rooms do not fit into these wings")
        return counts

    def _wing(
        self, pen: Pen, name: str, origin: Points, along: Points, size: tuple[float, float], counts: list[int]
    ) -> None:
        """Draw one wing that begins at the joint: corridor, both rows, and the opening to the joint."""
        rng, (length, depth), aside = pen.rng, size, np.array([-along[1], along[0]])
        wide = self._corridor_m
        near = self.narrowest_m + (depth - wide - 2 * self.narrowest_m) * rng.uniform(0.2, 0.8)
        corridor = [
            origin + along * x + aside * y
            for x, y in ((0, near), (length, near), (length, near + wide), (0, near + wide))
        ]
        pen.room(f"{name} corridor", corridor, is_bare=True)
        for side, (start, end), deep, count in (
            ("left", (corridor[3], corridor[2]), depth - near - wide, counts[0]),
            ("right", (corridor[1], corridor[0]), near, counts[1]),
        ):
            cuts = cut_widths(rng, 0.0, length, count, self.narrowest_m)
            draw_row(pen, start, end, deep, cuts, [f"{name} {side} {k + 1}" for k in range(count)], f"{name} corridor")
        gap = Gap(near + pen.inner_m / 2, near + wide - pen.inner_m / 2, f"{name} corridor", "joint", is_door=False)
        pen.wall([origin, origin + aside * depth], [gap])
