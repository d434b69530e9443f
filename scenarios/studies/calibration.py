"""Calibration of the confidence: models of the probability that a candidate is right, fitted to rows of runs.

Both models of `rectmerge.robust.confidence_model` are conditional logits (see `scenarios.studies.conditional_logit`).
The model of rigid maps is fitted first, to what no drift has bent; that of bent maps then adds to its odds. Last come
the weights of `rectmerge.robust.verdict.probability`, fitted to odds of places that took no part in the first two fits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.robust import confidence_model as model
from rectmerge.robust.params import ConfidenceParams
from rectmerge.robust.wall_agreement import WallAgreement
from scenarios.scoring.row import Row
from scenarios.scoring.score import RIGHT
from scenarios.studies.conditional_logit import Choices, fit

BENT_FROM = 0.002  # residual over extent
AGAINST = (
    "clutter_off",
    "violations",
    "contradicted",
    "surface_exact",
    *model.CONTRADICTIONS,
)  # other terms can only speak for
ALIKE = ("hospital",)  # families of rooms that are alike: their wrong placements look like right ones
BY_EYE = "by eye"  # truth of real pairs that may be bent by an unknown amount


@dataclass(frozen=True, slots=True, eq=False)
class OddsWeights:
    """Weights of both models of the odds, as `ConfidenceParams` holds them."""

    rigid: NDArray[np.float64]
    bent: NDArray[np.float64]

    @classmethod
    def in_use(cls) -> OddsWeights:
        """Return the weights of the default method."""
        params = ConfidenceParams()
        return cls(np.array(params.rigid), np.array(params.bent))

    def log_odds(self, evidence: Sequence[dict[str, float]]) -> NDArray[np.float64]:
        """Return the log-odds of a pair's candidates, shape (K,)."""
        rigid, bent = terms_of(evidence)
        return model.plausibility(rigid @ self.rigid, bent @ self.bent + evidence[0]["handicap"])


@dataclass(frozen=True, slots=True, eq=False)
class GradedCandidates:
    """Candidates of P pairs, up to K each, with their terms and grades.

    Parameters
    ----------
    rigid, bent
        Shape (P, K, T): terms of either model.
    handicap
        Shape (P, 1): log-odds by which the maps are less likely bent.
    is_there, is_right
        Shape (P, K): entries that hold a candidate, and right candidates. A nearly right candidate is left out: it
        is no example of a wrong one.
    is_bent
        Shape (P,): pairs whose truth itself leaves more than `BENT_FROM` of A's extent, or an unknown residual.
    """

    rigid: NDArray[np.float64]
    bent: NDArray[np.float64]
    handicap: NDArray[np.float64]
    is_there: NDArray[np.bool_]
    is_right: NDArray[np.bool_]
    is_bent: NDArray[np.bool_]

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
        shape = len(records), max(len(evidence) for _, evidence in records)
        rigid, bent = np.zeros((*shape, len(model.RIGID_TERMS))), np.zeros((*shape, len(model.BENT_TERMS)))
        is_there, is_right = np.zeros((2, *shape), np.bool_)
        handicap, is_bent = np.zeros((len(records), 1)), np.zeros(len(records), np.bool_)
        for i, (row, evidence) in enumerate(records):
            count = len(evidence)
            rigid[i, :count], bent[i, :count] = terms_of(evidence)
            handicap[i] = evidence[0]["handicap"]
            grades = row["grades"] or ["off"] * count
            is_there[i, :count] = [grade != "coarse" for grade in grades]
            is_right[i, :count] = [grade in RIGHT for grade in grades]
            is_bent[i] = (row["info"] or {}).get("truth") == BY_EYE or (row["residual_px"] or 0.0) > BENT_FROM * (
                row["extent_px"] or 1.0
            )
        return cls(rigid, bent, handicap, is_there, is_right, is_bent)

    def without_bent(self) -> GradedCandidates:
        """Return the candidates without the right ones of bent pairs, whose others are all wrong."""
        is_kept = ~(self.is_right & self.is_bent[:, None])
        return replace(self, is_there=self.is_there & is_kept, is_right=self.is_right & is_kept)

    def rigid_choices(self) -> Choices:
        """Return the choices that the model of rigid maps explains."""
        floor = np.full(self.is_there.shape, -np.inf)
        return Choices(self.rigid, self.is_there, self.is_right, floor, np.zeros_like(self.handicap))

    def bent_choices(self, rigid: NDArray[np.float64]) -> Choices:
        """Return the choices that the model of bent maps explains beside that of rigid maps with some weights."""
        floor = np.where(self.is_there, self.rigid @ rigid, -np.inf)
        none_is_rigid = -np.logaddexp(np.logaddexp.reduce(floor, axis=1, keepdims=True), 0.0)
        return Choices(self.bent, self.is_there, self.is_right, floor, self.handicap + none_is_rigid)


def terms_of(evidence: Sequence[dict[str, float]]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the terms of a pair's candidates in either model, shape (K, T) each."""
    params = ConfidenceParams()
    agreement = WallAgreement(
        *(np.array([candidate[name] for candidate in evidence]) for name in WallAgreement._fields)
    )
    support = np.array([candidate["support"] for candidate in evidence])
    surface = np.array([candidate["surface_matched"] for candidate in evidence])
    return model.rigid_terms(agreement, params), model.bent_terms(agreement, support, surface, params)


def usable(rows: Sequence[Row]) -> list[Row]:
    """Return the rows that may be fitted: of real maps or of the split train, identifiable, and with candidates."""
    return [row for row in rows if row["candidates"] and _may_be_fitted(row["info"] or {})]


def _may_be_fitted(info: dict[str, Any]) -> bool:
    is_real = not any(key.startswith("pose_source") for key in info)  # what every simulated pair says
    is_fair = info.get("family") not in ALIKE and info.get("identifiable") is not False
    return is_fair and (is_real or info.get("split") == "train")


def fit_odds(graded: GradedCandidates) -> OddsWeights:
    """Fit the model of rigid maps, then that of bent maps.

    Right candidates of bent pairs take no part in the first fit; their wrong candidates do.
    """
    rigid = fit(graded.without_bent().rigid_choices(), _signs(model.RIGID_TERMS))
    bent = fit(graded.bent_choices(rigid), _signs(model.BENT_TERMS))
    return OddsWeights(rigid, bent)


def _signs(terms: Sequence[str]) -> NDArray[np.int_]:
    return np.array([0 if name == "one" else -1 if name in AGAINST else 1 for name in terms])
