"""Fitting the plausibility of placements: which of a pair's candidates is right, or none of them.

The model is a conditional logit: of all candidates and of "none", each is right with a probability in proportion to its
odds, "none" having odds of one. A candidate's odds are the sum of those that it has as rigid maps and as bent ones,
each the exponential of a weighted sum of terms (`rectmerge.robust.model`). Likelihood, with a penalty on large weights,
is maximised by Adam (Kingma and Ba, arXiv:1412.6980) from the weights in use.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.robust import model
from rectmerge.robust.weighing import Weights
from scenarios.rows import Row
from scenarios.score import RIGHT

STEPS, RATE = 3000, 0.02
PENALTY = 2e-3  # of squared weights of standardised terms
WEIGHED = tuple(field.name for field in fields(Weights))


@dataclass(frozen=True, slots=True, eq=False)
class Answers:
    """Candidates of P pairs, up to K each, as the fit sees them.

    Parameters
    ----------
    terms
        Shape (P, K, len(TERMS)).
    is_there, is_right
        Shape (P, K): what is a candidate at all, and what is a right one. A nearly right candidate is left out: it
        says nothing against what a right one is like.
    """

    terms: NDArray[np.float64]
    is_there: NDArray[np.bool_]
    is_right: NDArray[np.bool_]

    @classmethod
    def of(cls, rows: Sequence[Row]) -> Answers:
        """Read the candidates of the rows of a run.

        Raises
        ------
        InputError
            If the rows tell no evidence.
        """
        told = [row for row in rows if row.get("evidence")]
        if not told:
            raise InputError("the rows tell no evidence: run the method robust, with --set robust.candidates=20")
        most = max(len(row["evidence"]) for row in told)
        terms = np.zeros((len(told), most, len(model.TERMS)))
        is_there, is_right = np.zeros((2, len(told), most), np.bool_)
        for i, row in enumerate(told):
            found = row["evidence"]
            terms[i, : len(found)] = terms_of(found)
            grades = row["grades"] or ["off"] * len(found)
            is_there[i, : len(found)] = [g != "coarse" for g in grades]
            is_right[i, : len(found)] = [g in RIGHT for g in grades]
        return cls(terms, is_there, is_right)


def terms_of(evidence: Sequence[dict[str, float]]) -> NDArray[np.float64]:
    """Lay out the terms of a pair's candidates, shape (K, len(TERMS))."""
    columns = {name: np.array([each[name] for each in evidence]) for name in (*WEIGHED, "support")}
    support = columns.pop("support")
    return model.terms(Weights(**columns), support)


def fit(answers: Answers) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit the weights of both models, each of shape (len(TERMS),), rigid and bent."""
    spread = answers.terms[answers.is_there].std(axis=0)
    spread[0] = 1.0  # the constant
    table = answers.terms / spread
    weights = np.stack([model.RIGID, model.BENT]) * spread
    shrunk = np.array([0.0, *np.ones(len(model.TERMS) - 1)])
    mean, square = np.zeros_like(weights), np.zeros_like(weights)
    for step in range(1, STEPS + 1):
        slope = _slope(table, answers, weights) + 2 * PENALTY * weights * shrunk
        mean, square = 0.9 * mean + 0.1 * slope, 0.999 * square + 0.001 * slope**2
        weights -= RATE * (mean / (1 - 0.9**step)) / (np.sqrt(square / (1 - 0.999**step)) + 1e-9)
    rigid, bent = weights / spread
    return rigid, bent


def probabilities(answers: Answers, rigid: NDArray[np.float64], bent: NDArray[np.float64]) -> NDArray[np.float64]:
    """Probability of each candidate, shape (P, K)."""
    return _shares(np.logaddexp(answers.terms @ rigid, answers.terms @ bent), answers.is_there)


def loss(answers: Answers, rigid: NDArray[np.float64], bent: NDArray[np.float64]) -> float:
    """Mean negative log-likelihood of what is right, nats a pair."""
    shares = probabilities(answers, rigid, bent)
    right = (shares * answers.is_right).sum(axis=1)
    told = np.where(answers.is_right.any(axis=1), right, 1 - shares.sum(axis=1))
    return float(-np.log(np.maximum(told, 1e-12)).mean())


def _shares(odds: NDArray[np.float64], is_there: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Turn log-odds, shape (P, K), into shares of all candidates and of none."""
    odds = np.where(is_there, odds, -np.inf)
    top = np.maximum(odds.max(axis=1, keepdims=True), 0.0)
    raised = np.exp(odds - top)
    shares: NDArray[np.float64] = raised / (raised.sum(axis=1, keepdims=True) + np.exp(-top))
    return shares


def _slope(table: NDArray[np.float64], answers: Answers, weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Slope of the mean negative log-likelihood in the weights, shape (2, len(TERMS))."""
    rigid, bent = table @ weights[0], table @ weights[1]
    shares = _shares(np.logaddexp(rigid, bent), answers.is_there)
    right = shares * answers.is_right
    wanted = right / np.maximum(right.sum(axis=1, keepdims=True), 1e-300)
    off = shares - wanted  # (P, K)
    as_rigid = 1 / (1 + np.exp(np.clip(bent - rigid, -60, 60)))
    return np.stack([np.einsum("pk,pkt->t", off * part, table) for part in (as_rigid, 1 - as_rigid)]) / len(table)
