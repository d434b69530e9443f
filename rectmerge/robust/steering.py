"""Steering of the search by a hint: near a guess, or onto a placement made by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from rectmerge.hints import ByHand, Guess, Hint
from rectmerge.robust.correlation import scales_within
from rectmerge.robust.refinement import to_working
from rectmerge.robust.search import Ranking, Search

GUESS_STD = 0.25  # of a guess, as a share of the radius of the moving map's walls; a turn counts at that radius
SHIFTS, TURNS_DEG = (-0.3, 0.0, 0.3), (-10.0, -5.0, 0.0, 5.0, 10.0)  # around a guess; shifts as shares of the radius
ITSELF_WITHIN, NEAREST_CELLS = 0.1, 3.0  # of that radius, and at least: a placement by hand is the best one so near


def steer(
    hint: Hint, search: Search, ranking: Ranking, grids: tuple[OccupancyGrid, OccupancyGrid], *, is_swapped: bool
) -> Ranking:
    """Return the ranking as the hint changes it.

    Parameters
    ----------
    hint
        The hint, about B on A.
    search, ranking
        The search, and what it proposed without the hint.
    grids
        A and B.
    is_swapped
        The search moves A onto B.
    """
    if isinstance(hint, Guess):
        return _steer_by_guess(hint, search, ranking, grids, is_swapped)
    return _steer_by_hand(hint, search, ranking, is_swapped)


def _steer_by_guess(
    guess: Guess, search: Search, ranking: Ranking, grids: tuple[OccupancyGrid, OccupancyGrid], is_swapped: bool
) -> Ranking:
    """Search around the guess too, and lower the log-odds of each placement by its squared distance from it.

    A guess adds no odds: a placement that the walls contradict stays rejected.
    """

    def at_scale(scale: float) -> NDArray[np.float64]:
        """Place the moving map on the other by the guess, for a scale between the working grids."""
        between_pixels = scale * search.a.factor / search.b.factor
        if is_swapped:
            return to_working(guess.pixels(*grids, 1 / between_pixels).inverse(), search.a, search.b)
        return to_working(guess.pixels(*grids, between_pixels), search.a, search.b)

    starts = np.concatenate([_around(at_scale(scale), search) for scale in scales_within(search.scale_bounds)])
    nearby = search.rank(search.near(starts))
    ranking = search.ranked(ranking.concat(nearby) if len(ranking) else nearby)
    away = np.array([_distance(search, at, at_scale(math.hypot(at[0], at[1]))) for at in ranking.placements])
    loss = 0.5 * (away / (GUESS_STD * max(1.0, search.b.radius))) ** 2
    steered = replace(
        ranking, plausibility=ranking.plausibility - loss, rigid=ranking.rigid - loss, bent=ranking.bent - loss
    )
    return steered.take(np.argsort(-steered.plausibility, kind="stable"))


def _steer_by_hand(hint: ByHand, search: Search, ranking: Ranking, is_swapped: bool) -> Ranking:
    """Put the best placement near the given one first, whatever else was proposed."""
    start = to_working(hint.pixels.inverse() if is_swapped else hint.pixels, search.a, search.b)
    own = search.rank(np.concatenate([start[None], search.near(start[None])]))
    both = own.concat(ranking) if len(ranking) else own
    reach = max(NEAREST_CELLS, ITSELF_WITHIN * search.b.radius)
    away = np.array([_distance(search, at, start) for at in both.placements])
    away[: len(own)] = 0.0  # the refined start is still the same placement
    itself = np.flatnonzero(away < reach)
    first = itself[np.argmax(both.plausibility[itself])]
    apart = np.array([_distance(search, at, both.placements[first]) for at in both.placements])
    placed, rest = both.take(np.array([first])), both.take(np.flatnonzero(apart >= reach))
    return placed.concat(search.best_distinct(rest)) if len(rest) else placed


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
    """Return the largest distance between the landmarks of the moving map under two placements, in working cells."""
    u, v = search.b.landmarks.T
    da, db, dx, dy = one - other
    return float(np.hypot(da * u - db * v + dx, db * u + da * v + dy).max())
