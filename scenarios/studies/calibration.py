"""Fitting the plausibility of placements: which of a pair's candidates is right, or none of them.

The model is a conditional logit: of all candidates and of "none", each is right with a probability in proportion to its
odds, "none" having odds of one. A candidate's odds are the exponential of a weighted sum of terms
(`rectmerge.robust.confidence_model`). Likelihood, with a penalty on large weights, is
maximised by Adam (Kingma and Ba, arXiv:1412.6980).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.robust import confidence_model as model
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
class Answers:
    """Candidates of P pairs, up to K each, as the fit sees them.

    Parameters
    ----------
    terms
        Shape (P, K, len(RIGID_TERMS)).
    is_there, is_right
        Shape (P, K): what is a candidate at all, and what is a right one. A nearly right candidate is left out: it
        says nothing against what a right one is like.
    is_bent
        Shape (P,): pairs whose truth itself leaves more than `BENT_FROM` of A's extent.
    """

    terms: NDArray[np.float64]
    is_there: NDArray[np.bool_]
    is_right: NDArray[np.bool_]
    is_bent: NDArray[np.bool_]

    def without_bent(self) -> Answers:
        """Leave the right candidates of bent pairs out; what is left of these is all wrong."""
        is_kept = ~(self.is_right & self.is_bent[:, None])
        return replace(self, is_there=self.is_there & is_kept, is_right=self.is_right & is_kept)

    @classmethod
    def from_rows(cls, rows: Sequence[Row]) -> Answers:
        """Read the candidates of the rows of a run.

        Raises
        ------
        InputError
            If the rows tell no evidence.
        """
        told = [(row, evidence) for row in rows if (evidence := row.get("evidence"))]
        if not told:
            raise InputError("the rows tell no evidence: run the method robust, with --set robust.candidates=20")
        most = max(len(evidence) for _, evidence in told)
        terms = np.zeros((len(told), most, len(model.RIGID_TERMS)))
        is_there, is_right = np.zeros((2, len(told), most), np.bool_)
        for i, (row, found) in enumerate(told):
            terms[i, : len(found)] = terms_of(found)
            grades = row["grades"] or ["off"] * len(found)
            is_there[i, : len(found)] = [g != "coarse" for g in grades]
            is_right[i, : len(found)] = [g in RIGHT for g in grades]
        is_bent = np.array([(row["residual_px"] or 0.0) > BENT_FROM * (row["extent_px"] or 1.0) for row, _ in told])
        return cls(terms, is_there, is_right, is_bent)


def report(rows: Sequence[Row]) -> str:
    """Fit the rows of the split train and lay out the numbers, and how well they fit.

    Raises
    ------
    InputError
        If there are no such rows with evidence.
    """
    info = [row["info"] or {} for row in rows]
    told = [
        row
        for row, of in zip(rows, info, strict=True)
        if of.get("split") == "train" and of.get("family") not in ALIKE and row["candidates"]
    ]
    answers = Answers.from_rows(told)
    weights = fit(answers)
    found = int(answers.is_right.any(axis=1).sum())
    rigid = answers.without_bent()
    lines = (
        f"# {len(told)} pairs, {found} of them with a right candidate",
        f"RIGID = np.array([{', '.join(f'{weight:.2f}' for weight in weights)}])",
        f"# {loss(rigid, weights):.4f} nats a pair; the numbers in use {loss(rigid, model.RIGID):.4f}",
    )
    return "\n".join(lines)


def terms_of(evidence: Sequence[dict[str, float]]) -> NDArray[np.float64]:
    """Lay out the terms of a pair's candidates, shape (K, len(RIGID_TERMS))."""
    columns = {field.name: np.array([each[field.name] for each in evidence]) for field in fields(WallAgreement)}
    return model.rigid_terms(WallAgreement(**columns))


def fit(answers: Answers) -> NDArray[np.float64]:
    """Fit the weights of the model of rigid maps, shape (len(RIGID_TERMS),).

    Of pairs of bent maps it has to say of what is wrong that it is.
    """
    spread = answers.terms[answers.is_there].std(axis=0)
    spread[spread < 1e-9] = 1.0  # the constant, for one
    weights: NDArray[np.float64] = _climbed(replace(answers, terms=answers.terms / spread).without_bent()) / spread
    return weights


def _climbed(answers: Answers) -> NDArray[np.float64]:
    """Find the weights at which the penalised likelihood is highest, none against its sign."""
    shrunk = np.array([0.0, *np.ones(len(model.RIGID_TERMS) - 1)])
    weights, mean, square = np.zeros((3, len(model.RIGID_TERMS)))
    for step in range(1, STEPS + 1):
        slope = _slope(answers, weights) + 2 * PENALTY * weights * shrunk
        mean, square = 0.9 * mean + 0.1 * slope, 0.999 * square + 0.001 * slope**2
        weights = weights - RATE * (mean / (1 - 0.9**step)) / (np.sqrt(square / (1 - 0.999**step)) + 1e-9)
        weights = np.where(weights * SIGNS < 0, 0.0, weights)
    return weights


def loss(answers: Answers, weights: NDArray[np.float64]) -> float:
    """Mean negative log-likelihood of what is right, nats a pair."""
    shares = _shares(answers.terms @ weights, answers.is_there)
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


def _slope(answers: Answers, weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Slope of the mean negative log-likelihood in the weights of one model, shape (len(RIGID_TERMS),)."""
    shares = _shares(answers.terms @ weights, answers.is_there)
    right = shares * answers.is_right
    wanted = right / np.maximum(right.sum(axis=1, keepdims=True), 1e-300)
    slope: NDArray[np.float64] = np.einsum("pk,pkt->t", shares - wanted, answers.terms) / len(answers.terms)
    return slope
