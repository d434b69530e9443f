"""What people know of a placement, put to use: a guess to search near, or a placement by hand to be judged."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.robust.correlation import scales_within
from rectmerge.robust.refinement import to_working
from rectmerge.robust.search import Ranking, Search
from rectmerge.similarity import Similarity

GUESS_STD = 0.25  # of a guess, as a share of the radius of the moving map's walls; a turn counts at that radius
SHIFTS, TURNS_DEG = (-0.3, 0.0, 0.3), (-10.0, -5.0, 0.0, 5.0, 10.0)  # around a guess; shifts as shares of the radius
ITSELF_WITHIN, NEAREST_CELLS = 0.1, 3.0  # of that radius, and at least: a placement by hand is the best one so near


class Hint(Protocol):
    """Something known of the placement."""

    @property
    def better_elsewhere(self) -> str:
        """The reason where it is not borne out, and another placement explains the walls better."""

    def steer(self, search: Search, ranking: Ranking, *, is_swapped: bool) -> Ranking:
        """Return what was found, as the hint has it; `is_swapped` where the search moves A onto B."""


@dataclass(frozen=True, slots=True, eq=False)
class Guess:
    """About where map B lies on map A.

    Parameters
    ----------
    a, b
        The maps.
    x, y, yaw
        The origin of B's map frame in A's, and B's yaw there: map units of A, and radians.

    Notes
    -----
    The search starts around the guess too, and every placement loses log-odds with its squared distance from it, as
    from a guess with a standard deviation of a quarter of the radius of the map's walls. A guess adds no odds: what the
    walls do not bear out stays rejected.
    """

    a: OccupancyGrid
    b: OccupancyGrid
    x: float
    y: float
    yaw: float

    @property
    def better_elsewhere(self) -> str:
        """The reason where the guess is not borne out."""
        return "the walls agree better far from the guess than near it: correct it, or leave it out"

    def pixels(self, scale: float) -> Similarity:
        """Return the guess between pixels, for a scale in cells of A per cell of B."""
        in_map_units = scale * self.a.cell_size / self.b.cell_size
        return map_frame_to_pixels(Similarity(in_map_units, self.yaw, self.x, self.y), self.a, self.b)

    def steer(self, search: Search, ranking: Ranking, *, is_swapped: bool) -> Ranking:
        """Search around the guess too, and weigh what was found by its distance from it."""
        starts = np.concatenate(
            [_around(self._working(search, scale, is_swapped), search) for scale in scales_within(search.scale_bounds)]
        )
        found = search.rank(search.near(starts))
        ranking = search.ranked(ranking.beside(found) if len(ranking) else found)
        away = np.array(
            [
                _distance(search, at, self._working(search, math.hypot(at[0], at[1]), is_swapped))
                for at in ranking.placements
            ]
        )
        loss = 0.5 * (away / (GUESS_STD * max(1.0, search.b.radius))) ** 2
        weighed = replace(
            ranking,
            plausibility=ranking.plausibility - loss,
            rigid=ranking.rigid - loss,
            bent=ranking.bent - loss,
        )
        return weighed.of(np.argsort(-weighed.plausibility, kind="stable"))

    def _working(self, search: Search, scale: float, is_swapped: bool) -> NDArray[np.float64]:
        """Place the moving map on the other by the guess, for a scale between the working grids."""
        between_pixels = scale * search.a.factor / search.b.factor
        pixels = self.pixels(1 / between_pixels).inverse() if is_swapped else self.pixels(between_pixels)
        return to_working(pixels, search.a, search.b)


@dataclass(frozen=True, slots=True, eq=False)
class ByHand:
    """A placement to be judged like any other: as the best placement beside it, against all others.

    Parameters
    ----------
    pixels
        From B's pixels to A's.
    """

    pixels: Similarity

    @property
    def better_elsewhere(self) -> str:
        """The reason where the placement is not borne out."""
        return "the walls agree better elsewhere: correct the placement, or leave it out and it is searched for"

    def steer(self, search: Search, ranking: Ranking, *, is_swapped: bool) -> Ranking:
        """Put the placement first, whatever else was found."""
        start = to_working(self.pixels.inverse() if is_swapped else self.pixels, search.a, search.b)
        own = search.rank(np.concatenate([start[None], search.near(start[None])]))
        both = own.beside(ranking) if len(ranking) else own
        reach = max(NEAREST_CELLS, ITSELF_WITHIN * search.b.radius)
        away = np.array([_distance(search, at, start) for at in both.placements])
        away[: len(own)] = 0.0  # where it slides when it is made exact is still the same placement
        itself = np.flatnonzero(away < reach)
        first = itself[np.argmax(both.plausibility[itself])]
        apart = np.array([_distance(search, at, both.placements[first]) for at in both.placements])
        placed, rest = both.of(np.array([first])), both.of(np.flatnonzero(apart >= reach))
        return placed.beside(search.best_distinct(rest)) if len(rest) else placed


def _around(start: NDArray[np.float64], search: Search) -> NDArray[np.float64]:
    """Shift and turn a placement a little, about the middle of the moving map's walls; shape (N, 4)."""
    middle = search.b.landmarks.mean(axis=0)
    linear = np.array([[start[0], -start[1]], [start[1], start[0]]])
    centre = linear @ middle + start[2:]
    placements = []
    for turn in np.radians(TURNS_DEG):
        cos, sin = math.cos(turn), math.sin(turn)
        turned = np.array([[cos, -sin], [sin, cos]]) @ linear
        for u in SHIFTS:
            for v in SHIFTS:
                shift = centre + np.array([u, v]) * search.b.radius - turned @ middle
                placements.append([turned[0, 0], turned[1, 0], *shift])
    return np.array(placements)


def _distance(search: Search, one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """How far apart two placements put the moving map's landmarks, in working cells."""
    u, v = search.b.landmarks.T
    da, db, dx, dy = one - other
    return float(np.hypot(da * u - db * v + dx, db * u + da * v + dy).max())
