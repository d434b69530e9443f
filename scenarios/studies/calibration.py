"""Calibration of the confidence: a model of the probability that a candidate is right, fitted to rows.

The model is a conditional logit: of all candidates and of "none", each is right with a probability in proportion to its
odds, "none" having odds of one. A candidate's odds are the exponential of a weighted sum of terms
(`rectmerge.robust.confidence_model`). Likelihood, with a penalty on large weights, is
maximised by Adam (Kingma and Ba, arXiv:1412.6980).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.robust import confidence_model as model
from rectmerge.robust.params import ConfidenceParams
from rectmerge.robust.wall_agreement import WallAgreement
from scenarios.scoring.row import Row
from scenarios.scoring.score import RIGHT

STEPS, RATE = 3000, 0.02
BENT_FROM = 0.002  # residual over extent
PENALTY = 2e-4  # of squared weights of standardised terms
AGAINST = ("clutter_off", "violations")  # terms that can only speak against a placement; others only for it
SIGNS = np.array([0 if name == "one" else -1 if name in AGAINST else 1 for name in model.RIGID_TERMS])
ALIKE = ("hospital",)  # families of rooms that are alike: their wrong placements look like right ones


@dataclass(frozen=True, slots=True, eq=False)
class GradedCandidates:
    """Candidates of P pairs, up to K each, with their terms and grades.

    Parameters
    ----------
    terms
        Shape (P, K, len(RIGID_TERMS)).
    is_there, is_right
        Shape (P, K): entries that hold a candidate, and right candidates. A nearly right candidate is left out: it
        is no example of a wrong one.
    is_bent
        Shape (P,): pairs whose truth itself leaves more than `BENT_FROM` of A's extent.
    """

    terms: NDArray[np.float64]
    is_there: NDArray[np.bool_]
    is_right: NDArray[np.bool_]
    is_bent: NDArray[np.bool_]

    def without_bent(self) -> GradedCandidates:
        """Return the candidates without the right ones of bent pairs, whose others are all wrong."""
        is_kept = ~(self.is_right & self.is_bent[:, None])
        return replace(self, is_there=self.is_there & is_kept, is_right=self.is_right & is_kept)

    @classmethod
    def from_rows(cls, rows: Sequence[Row]) -> GradedCandidates:
        """Read the candidates of the rows of a run.

        Raises
        ------
        InputError
            If no row has evidence.
        """
        records = [(row, evidence) for row in rows if (evidence := row.get("evidence"))]
        if not records:
            raise InputError("the rows hold no evidence: run the method robust, with --set robust.max_candidates=20")
        most = max(len(evidence) for _, evidence in records)
        terms = np.zeros((len(records), most, len(model.RIGID_TERMS)))
        is_there, is_right = np.zeros((2, len(records), most), np.bool_)
        for i, (row, evidence) in enumerate(records):
            terms[i, : len(evidence)] = terms_of(evidence)
            grades = row["grades"] or ["off"] * len(evidence)
            is_there[i, : len(evidence)] = [grade != "coarse" for grade in grades]
            is_right[i, : len(evidence)] = [grade in RIGHT for grade in grades]
        is_bent = np.array([(row["residual_px"] or 0.0) > BENT_FROM * (row["extent_px"] or 1.0) for row, _ in records])
        return cls(terms, is_there, is_right, is_bent)


def report(rows: Sequence[Row]) -> str:
    """Fit the weights to the rows of the split train, and return them and their losses as text.

    Raises
    ------
    InputError
        If there are no such rows with evidence.
    """
    info = [row["info"] or {} for row in rows]
    training = [
        row
        for row, about in zip(rows, info, strict=True)
        if about.get("split") == "train" and about.get("family") not in ALIKE and row["candidates"]
    ]
    graded = GradedCandidates.from_rows(training)
    weights = fit(graded)
    with_right = int(graded.is_right.any(axis=1).sum())
    rigid, in_use = graded.without_bent(), np.array(ConfidenceParams().rigid)
    lines = (
        f"# {len(training)} pairs, {with_right} of them with a right candidate",
        f"rigid = ({', '.join(f'{weight:.2f}' for weight in weights)})",
        f"# {loss(rigid, weights):.4f} nats a pair; the numbers in use {loss(rigid, in_use):.4f}",
    )
    return "\n".join(lines)


def terms_of(evidence: Sequence[dict[str, float]]) -> NDArray[np.float64]:
    """Return the terms of a pair's candidates, shape (K, len(RIGID_TERMS))."""
    columns = (np.array([candidate[name] for candidate in evidence]) for name in WallAgreement._fields)
    return model.rigid_terms(WallAgreement(*columns), ConfidenceParams())


def fit(graded: GradedCandidates) -> NDArray[np.float64]:
    """Fit the weights of the model of rigid maps, shape (len(RIGID_TERMS),).

    Right candidates of bent pairs take no part in the fit; their wrong candidates do.
    """
    spread = graded.terms[graded.is_there].std(axis=0)
    spread[spread < 1e-9] = 1.0  # such as the constant
    weights: NDArray[np.float64] = _maximise(replace(graded, terms=graded.terms / spread).without_bent()) / spread
    return weights


def _maximise(graded: GradedCandidates) -> NDArray[np.float64]:
    """Maximise the penalised likelihood, each weight of its sign or zero."""
    shrunk = np.array([0.0, *np.ones(len(model.RIGID_TERMS) - 1)])
    weights, mean, square = np.zeros((3, len(model.RIGID_TERMS)))
    for step in range(1, STEPS + 1):
        gradient = _gradient(graded, weights) + 2 * PENALTY * weights * shrunk
        mean, square = 0.9 * mean + 0.1 * gradient, 0.999 * square + 0.001 * gradient**2
        weights = weights - RATE * (mean / (1 - 0.9**step)) / (np.sqrt(square / (1 - 0.999**step)) + 1e-9)
        weights = np.where(weights * SIGNS < 0, 0.0, weights)
    return weights


def loss(graded: GradedCandidates, weights: NDArray[np.float64]) -> float:
    """Return the mean negative log-likelihood of the right candidates, nats per pair."""
    posterior = _posterior(graded.terms @ weights, graded.is_there)
    right = (posterior * graded.is_right).sum(axis=1)
    likelihood = np.where(graded.is_right.any(axis=1), right, 1 - posterior.sum(axis=1))
    return float(-np.log(np.maximum(likelihood, 1e-12)).mean())


def _posterior(odds: NDArray[np.float64], is_there: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return the probability of each candidate, shape (P, K), from log-odds against "none"."""
    odds = np.where(is_there, odds, -np.inf)
    top = np.maximum(odds.max(axis=1, keepdims=True), 0.0)
    raised = np.exp(odds - top)
    posterior: NDArray[np.float64] = raised / (raised.sum(axis=1, keepdims=True) + np.exp(-top))
    return posterior


def _gradient(graded: GradedCandidates, weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the gradient of the mean negative log-likelihood in the weights, shape (len(RIGID_TERMS),)."""
    posterior = _posterior(graded.terms @ weights, graded.is_there)
    right = posterior * graded.is_right
    wanted = right / np.maximum(right.sum(axis=1, keepdims=True), 1e-300)
    gradient: NDArray[np.float64] = np.einsum("pk,pkt->t", posterior - wanted, graded.terms) / len(graded.terms)
    return gradient
