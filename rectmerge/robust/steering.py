"""Steering of the search by a hint: near a guess, or onto a placement made by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from rectmerge.hints import ByHand, Guess, Hint
from rectmerge.robust.correlation import scales_within
from rectmerge.robust.proposal import propose_near
from rectmerge.robust.ranking import Ranking, best_distinct, rank, rerank
from rectmerge.robust.refinement import to_working
from rectmerge.robust.working_pair import WorkingPair


def steer(
    hint: Hint, pair: WorkingPair, ranking: Ranking, grids: tuple[OccupancyGrid, OccupancyGrid], *, is_swapped: bool
) -> Ranking:
    """Return the ranking as the hint changes it.

    Parameters
    ----------
    hint
        The hint, about B on A.
    pair, ranking
        The maps, and the ranking without the hint.
    grids
        A and B.
    is_swapped
        Whether A is moved onto B.
    """
    if isinstance(hint, Guess):
        return _steer_by_guess(hint, pair, ranking, grids, is_swapped)
    return _steer_by_hand(hint, pair, ranking, is_swapped)


def _steer_by_guess(
    guess: Guess, pair: WorkingPair, ranking: Ranking, grids: tuple[OccupancyGrid, OccupancyGrid], is_swapped: bool
) -> Ranking:
    """Search around the guess too, and lower the log-odds of each placement by its squared distance from it.

    A guess adds no odds: a placement that the walls contradict stays rejected.
    """

    def at_scale(scale: float) -> NDArray[np.float64]:
        """Place the moving map on the other by the guess, for a scale between the working grids."""
        between_pixels = scale * pair.a.factor / pair.b.factor
        if is_swapped:
            return to_working(guess.pixels(*grids, 1 / between_pixels).inverse(), pair.a, pair.b)
        return to_working(guess.pixels(*grids, between_pixels), pair.a, pair.b)

    starts = np.concatenate(
        [_around(at_scale(scale), pair) for scale in scales_within(pair.scale_bounds, pair.params.correlate.scale_step)]
    )
    nearby = rank(pair, propose_near(pair, starts))
    ranking = rerank(pair, ranking.concat(nearby) if len(ranking) else nearby)
    away = np.array([_distance(pair, at, at_scale(math.hypot(at[0], at[1]))) for at in ranking.placements])
    loss = 0.5 * (away / (pair.params.hint.guess_std * max(1.0, pair.b.radius))) ** 2
    steered = replace(
        ranking, plausibility=ranking.plausibility - loss, rigid=ranking.rigid - loss, bent=ranking.bent - loss
    )
    return steered.take(np.argsort(-steered.plausibility, kind="stable"))


def _steer_by_hand(hint: ByHand, pair: WorkingPair, ranking: Ranking, is_swapped: bool) -> Ranking:
    """Put the best placement near the given one first, whatever else was proposed."""
    start = to_working(hint.pixels.inverse() if is_swapped else hint.pixels, pair.a, pair.b)
    own = rank(pair, np.concatenate([start[None], propose_near(pair, start[None])]))
    both = own.concat(ranking) if len(ranking) else own
    reach = max(pair.params.hint.by_hand_cells, pair.params.hint.by_hand_share * pair.b.radius)
    away = np.array([_distance(pair, at, start) for at in both.placements])
    away[: len(own)] = 0.0  # the refined start is still the same placement
    itself = np.flatnonzero(away < reach)
    first = itself[np.argmax(both.plausibility[itself])]
    apart = np.array([_distance(pair, at, both.placements[first]) for at in both.placements])
    placed, rest = both.take(np.array([first])), both.take(np.flatnonzero(apart >= reach))
    return placed.concat(best_distinct(pair, rest)) if len(rest) else placed


def _around(start: NDArray[np.float64], pair: WorkingPair) -> NDArray[np.float64]:
    """Shift and turn a placement a little, about the middle of the moving map's walls; shape (N, 4)."""
    params = pair.params.hint
    middle = pair.b.landmarks.mean(axis=0)
    linear = np.array([[start[0], -start[1]], [start[1], start[0]]])
    centre = linear @ middle + start[2:]
    placements = []
    for turn in np.radians(params.guess_turns_deg):
        cos, sin = math.cos(turn), math.sin(turn)
        turned = np.array([[cos, -sin], [sin, cos]]) @ linear
        for u in params.guess_shifts:
            for v in params.guess_shifts:
                shift = centre + np.array([u, v]) * pair.b.radius - turned @ middle
                placements.append([turned[0, 0], turned[1, 0], *shift])
    return np.array(placements)


def _distance(pair: WorkingPair, one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the largest distance between the landmarks of the moving map under two placements, in working cells."""
    u, v = pair.b.landmarks.T
    da, db, dx, dy = one - other
    return float(np.hypot(da * u - db * v + dx, db * u + da * v + dy).max())
