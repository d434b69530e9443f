"""Search for placements: rectangles propose, then every shift, and rivals challenge the best."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rectmerge.robust.features import QUARTER_TURN_DEG
from rectmerge.robust.prepared_map import PreparedMap
from rectmerge.robust.proposal import propose_all_round, propose_by_correlation, propose_by_rectangles, propose_rivals
from rectmerge.robust.ranking import Ranking, rank, rerank
from rectmerge.robust.verdict import log_odds_of_rest, probability
from rectmerge.robust.working_pair import WorkingPair


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """Ranked placements of a pair of maps.

    Parameters
    ----------
    pair, ranking
        The maps and the placements.
    is_full
        Whether every shift was tried, not only the rectangles.
    """

    pair: WorkingPair
    ranking: Ranking
    is_full: bool

    @property
    def convinces(self) -> bool:
        """True if the best placement would be accepted."""
        return _convinces(self.pair, self.ranking)


def search(pair: WorkingPair, fixed: PreparedMap, moving: PreparedMap, *, is_full_allowed: bool = True) -> Search:
    """Search by rectangles in the strongest orthogonal frames; then by every shift, and at angles all round.

    A stage follows where those before it do not convince.

    Whatever the rectangles propose, the best has to hold against every shift and quarter turn at its own scale.
    """
    by_rectangles = rank(pair, propose_by_rectangles(pair, fixed.frames, moving.frames))
    ranking = challenge(pair, by_rectangles)
    if not is_full_allowed or _convinces(pair, ranking):
        return Search(pair, ranking, is_full=False)
    fits = [propose_by_correlation(pair, fixed.frame_angles, moving.frame_angles)]
    params = pair.params.propose
    if min(fixed.contrast, moving.contrast) >= params.weak_contrast:
        fits.append(propose_by_rectangles(pair, fixed.all_frames(), moving.all_frames()))
    else:  # no direction dominates
        angles = np.radians(np.arange(0, QUARTER_TURN_DEG, params.all_round_step_deg))
        fits.append(propose_by_rectangles(pair, fixed.frames[:1], moving.frames_at([float(angle) for angle in angles])))
    ranking = challenge(pair, rerank(pair, ranking.concat(rank(pair, np.concatenate(fits)))))
    if pair.params.all_round.is_used and not _convinces(pair, ranking):
        fits_all_round = propose_all_round(pair, fixed.direction_energies, moving.direction_energies)
        ranking = challenge(pair, rerank(pair, ranking.concat(rank(pair, fits_all_round))))
    return Search(pair, ranking, is_full=True)


def challenge(pair: WorkingPair, ranking: Ranking) -> Ranking:
    """Rank once more, with the best placement's rivals at every shift and quarter turn."""
    if len(ranking) == 0:
        return ranking
    return rerank(pair, ranking.concat(rank(pair, propose_rivals(pair, ranking.placements[0]))))


def _convinces(pair: WorkingPair, ranking: Ranking) -> bool:
    if len(ranking) == 0:
        return False
    rest = float(log_odds_of_rest(ranking.plausibility)[0])
    params = pair.params.verdict
    return probability(ranking.best, rest, -math.inf, params) >= params.asked_of(float(ranking.agreement.overlap[0]))
