"""Fit of the probability of a pair's best candidate, from its log-odds and its lead over the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.robust.params import VerdictParams
from scenarios.scoring.score import RIGHT, Grade
from scenarios.studies.conditional_logit import PENALTY, ascend


@dataclass(frozen=True, slots=True, kw_only=True)
class BestCandidate:
    """Best candidate of a pair.

    Parameters
    ----------
    grade
        Of its placement.
    log_odds, rest_log_odds, mirror_log_odds
        As in `rectmerge.robust.verdict.Evidence`.
    is_held
        Whether the walls hold it, at a scale within bounds.
    overlap
        Share of the smaller free area.
    """

    grade: Grade
    log_odds: float
    rest_log_odds: float
    mirror_log_odds: float
    is_held: bool
    overlap: float


def fit_probability(
    candidates: Sequence[BestCandidate], counts: NDArray[np.float64], params: VerdictParams
) -> NDArray[np.float64]:
    """Fit the weights of `rectmerge.robust.verdict.probability` by maximum likelihood, shape (3,).

    Parameters
    ----------
    candidates
        Of N pairs.
    counts
        Shape (N,): as how many pairs each counts.
    params
        What chance reaches. The weights of the log-odds and of the lead are 0 or more.
    """
    own, rest, mirror = np.array(
        [(each.log_odds, each.rest_log_odds, each.mirror_log_odds) for each in candidates]
    ).T  # (N,)
    is_right = np.array([each.grade in RIGHT for each in candidates])
    lead = own - np.logaddexp(np.logaddexp(rest, mirror), params.chance_log_odds)
    terms = np.stack([np.ones_like(own), own, lead], axis=1)
    alone = 1 / (1 + np.exp(np.clip(rest - own, -30.0, 30.0)))

    def gradient(weights: NDArray[np.float64]) -> NDArray[np.float64]:
        stands_out = 1 / (1 + np.exp(-np.clip(terms @ weights, -30.0, 30.0)))
        wrong = np.maximum(1 - stands_out * alone, 1e-12)
        slope = np.where(is_right, stands_out - 1, stands_out * alone * (1 - stands_out) / wrong)
        return np.asarray(terms.T @ (slope * counts) / counts.sum() + 2 * PENALTY * weights)

    return ascend(gradient, np.array([0, 1, 1]))
