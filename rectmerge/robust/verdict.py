"""Verdict on the best placement: its evidence, its probability, and the thresholds."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields

import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Verdict
from rectmerge.robust.params import VerdictParams
from rectmerge.robust.wall_agreement import WallAgreement

NO_AGREEMENT: WallAgreement[float] = WallAgreement(*[0.0] * len(WallAgreement._fields))


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """Evidence for a placement.

    Parameters
    ----------
    plausibility
        Log-odds that it is right, were there no other: from how the walls of both maps meet under it, and how much.
    rest_log_odds
        The same of all other distinct placements together: the logarithm of the sum of their odds.
    mirror_log_odds
        The same of the best placement of the mirror image. No placement of a mirror image can be right, so it shows
        what chance achieves on maps like these. Minus infinity where it was not asked.
    rigid, bent
        The same if the maps are rigid, and if they are bent.
    handicap
        Log-odds by which the maps are less likely bent, in `bent`.
    likelihood, support
        Log-likelihood ratio of all walls against chance, and per wall point of the map that has fewer.
    agreement
        Agreement of the walls, of this placement.
    surface_matched
        Share of the wall surface on known cells of the other map that lies within two cells of that map's.
    conflict
        As in `rectmerge.analysis.overlap.Agreement`.
    slack_cells
        Standard deviation of the placement in its least certain direction, in cells of the map that stays.
    is_at_limit
        Whether the scale ended at the limit of what was allowed: the maps would fit better beyond it.
    residual_cells
        Root mean square distance of the matched surfaces, in cells of the map that stays.
    bend_log_odds
        Log-odds that unbending adds: 0 where it was not tried, or where walls held back from the fit do not confirm it.
    params
        Thresholds of the verdict.
    """

    plausibility: float
    rest_log_odds: float = -math.inf
    mirror_log_odds: float = -math.inf
    rigid: float = -math.inf
    bent: float = -math.inf
    handicap: float = 0.0
    likelihood: float = 0.0
    support: float = 0.0
    agreement: WallAgreement[float] = NO_AGREEMENT
    surface_matched: float = 0.0
    conflict: float = 0.0
    slack_cells: float = 0.0
    is_at_limit: bool = False
    residual_cells: float = 0.0
    bend_log_odds: float = 0.0
    params: VerdictParams = field(default_factory=VerdictParams)

    @property
    def probability(self) -> float:
        """Probability that the placement is right, and none of the others."""
        alone = probability(
            self.plausibility, self.rest_log_odds, self.mirror_log_odds, self.params, bend_log_odds=self.bend_log_odds
        )
        return min(alone, 0.5) if self.is_slack or self.is_at_limit else alone

    @property
    def asked(self) -> float:
        """Probability from which the placement is accepted."""
        return self.params.asked_of(self.agreement.overlap)

    @property
    def probability_without_rivals(self) -> float:
        """Probability of the placement by its own log-odds, whatever the others."""
        return posterior(self.plausibility)

    @property
    def is_sure(self) -> bool:
        """True if the mirror image need not be searched: as rigid maps alone this is the answer."""
        return posterior(self.rigid, self.rest_log_odds) >= self.params.sure_at

    @property
    def is_slack(self) -> bool:
        """True if the walls in common leave the placement free to slide or turn."""
        return self.slack_cells > self.params.max_slack_cells

    def as_dict(self) -> dict[str, float]:
        """Return the measurements by name, those of the agreement among them."""
        own = {item.name: getattr(self, item.name) for item in fields(self) if item.name != "params"}
        measured: dict[str, float] = {}
        for name, value in own.items():
            measured |= self.agreement._asdict() if name == "agreement" else {name: value}
        return measured


def probability(
    log_odds: float,
    rest_log_odds: float,
    mirror_log_odds: float,
    params: VerdictParams,
    *,
    bend_log_odds: float = 0.0,
) -> float:
    """Return the probability that a placement is right, from its log-odds and its lead over all others.

    Of two maps of different places, many placements are about as good as the best; a right one leads. What the others
    reach, the mirror image's among them, is what chance reaches on maps like these, and it always reaches something. An
    equal rival leaves even odds at most, and so does a mirror image that fits better.

    Parameters
    ----------
    log_odds, rest_log_odds, mirror_log_odds
        Of the placement, of all others together, and of the best of the mirror image; minus infinity where there is
        none.
    params
        Weights of both.
    bend_log_odds
        Log-odds that unbending adds. They do not count against other placements, which may be unbent as well.
    """
    alone = posterior(calibrated_log_odds(log_odds, rest_log_odds, mirror_log_odds, params) + bend_log_odds)
    alone *= posterior(log_odds - rest_log_odds)
    return min(alone, 0.5) if mirror_log_odds > log_odds else alone


def calibrated_log_odds(log_odds: float, rest_log_odds: float, mirror_log_odds: float, params: VerdictParams) -> float:
    """Return the log-odds that a placement is right against none, from its own and its lead; see `probability`."""
    lead = log_odds - float(np.logaddexp.reduce([rest_log_odds, mirror_log_odds, params.chance_log_odds]))
    constant, of_own, of_lead = params.weights
    return constant + of_own * log_odds + of_lead * lead


def posterior(plausibility: float, rest_log_odds: float = -math.inf, mirror_log_odds: float = -math.inf) -> float:
    """Turn log-odds into the probability of one of several answers that exclude each other, and of none.

    Examples
    --------
    >>> posterior(0.0), posterior(50.0, 50.0)
    (0.5, 0.5)
    """
    against = np.logaddexp(np.logaddexp(0.0, rest_log_odds), mirror_log_odds)
    return float(1 / (1 + np.exp(np.clip(against - plausibility, -30.0, 30.0))))


def log_odds_of_rest(plausibility: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the logarithm of the summed odds of all answers but each one, shape (N,)."""
    rest = np.tile(plausibility, (len(plausibility), 1))
    np.fill_diagonal(rest, -np.inf)
    summed: NDArray[np.float64] = np.logaddexp.reduce(rest, axis=1)
    return summed


def judge(evidence: Evidence) -> Verdict:
    """Give the verdict on the best placement."""
    if evidence.probability >= evidence.asked:
        return "accepted"
    is_held = not (evidence.is_slack or evidence.is_at_limit)
    is_likely = evidence.probability >= evidence.params.likely_at
    has_rivals = evidence.probability_without_rivals >= evidence.params.ambiguous_at
    return "ambiguous" if is_held and (is_likely or has_rivals) else "rejected"
