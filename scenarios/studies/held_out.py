"""Held-out verdicts: the confidence fitted to rows in folds of places, and tried on places that a fit has not seen."""

from __future__ import annotations

import math
import zlib
from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.robust.params import VerdictParams
from rectmerge.robust.verdict import log_odds_of_rest, probability
from scenarios.scoring.row import Row
from scenarios.scoring.score import RIGHT
from scenarios.studies.calibration import GradedCandidates, OddsWeights, fit_odds, usable
from scenarios.studies.probability_fit import BestCandidate, fit_probability

FOLDS = 5
WITHOUT_RIGHT = 0.3  # weight of a related pair without its right candidates; by hand, no data
INNER_FOLDS = 3  # for the odds to which the probability is fitted
COLUMNS = ("n", "right-accepted", "wrong-accepted", "refused")


def report(rows: Sequence[Row]) -> str:
    """Fit all weights to all usable rows, and return them and the verdicts on held-out places as text.

    Raises
    ------
    InputError
        If there are no such rows with evidence.
    """
    training = usable(rows)
    if not training:
        raise InputError("no row may be fitted: rows of the split train or of real places, with candidates, are needed")
    graded = GradedCandidates.from_rows(training)
    odds = fit_odds(graded)
    lines = [
        f"# {len(training)} pairs, {int(graded.is_right.any(axis=1).sum())} of them with a right candidate",
        f"confidence.rigid = {_written(odds.rigid)}",
        f"confidence.bent = {_written(odds.bent)}",
        f"verdict.weights = {_written(fit_verdict(training))}",
        "# pairs judged by weights that were fitted without their places; the mirror image by the weights in use",
        *held_out_table(training),
    ]
    return "\n".join(lines)


def fit_verdict(rows: Sequence[Row]) -> NDArray[np.float64]:
    """Fit the weights of the probability to the odds of rows whose places took no part in the fit of the odds, (3,).

    What chance reaches is taught by unrelated pairs, and by related pairs without their right and nearly right
    candidates, which count for less.
    """
    best, weights = [], []
    for held in range(INNER_FOLDS):
        odds = fit_odds(GradedCandidates.from_rows([row for row in rows if held not in _folds(row, INNER_FOLDS)]))
        for row in rows:
            if min(_folds(row, INNER_FOLDS)) == held:
                best.append(best_candidate(row, odds))
                weights.append(0.0 if best[-1].grade == "coarse" else 1.0)
                if wrong := without_right(row):
                    best.append(best_candidate(wrong, odds))
                    weights.append(WITHOUT_RIGHT)
    return fit_probability(best, np.array(weights), VerdictParams())


def without_right(row: Row) -> Row | None:
    """Return a row of a related pair without its right and nearly right candidates; None where nothing is left."""
    grades, evidence = row["grades"] or [], row["evidence"] or []
    kept = [i for i, grade in enumerate(grades) if grade == "off"]
    if not kept or len(kept) == len(grades):
        return None
    mirror = {"mirror_log_odds": evidence[0]["mirror_log_odds"]}
    return {**row, "grades": [grades[i] for i in kept], "evidence": [{**evidence[i], **mirror} for i in kept]}


def held_out_table(rows: Sequence[Row]) -> list[str]:
    """Count the verdicts on held-out pairs, by kind of pair and overlap, at several thresholds of the probability."""
    counts: dict[str, Counter[str]] = {}
    for held in sorted({_folds(row, FOLDS) for row in rows}, key=sorted):
        seen = [row for row in rows if not _folds(row, FOLDS) & held]
        odds, weights = fit_odds(GradedCandidates.from_rows(seen)), fit_verdict(seen)
        params = VerdictParams(weights=tuple(float(weight) for weight in weights))
        for row in rows:
            if _folds(row, FOLDS) == held:
                counts.setdefault(_kind(row), Counter()).update(["n", outcome(best_candidate(row, odds), params)])
    return [
        f"# {kind}: {', '.join(f'{count[name]} {name}' for name in COLUMNS)}" for kind, count in sorted(counts.items())
    ]


def best_candidate(row: Row, odds: OddsWeights) -> BestCandidate:
    """Return the best candidate of a row by some odds."""
    evidence = row["evidence"] or []
    log_odds = odds.log_odds(evidence)
    best = int(np.argmax(log_odds))
    mirror = evidence[0]["mirror_log_odds"]  # None where it was not asked
    return BestCandidate(
        grade=(row["grades"] or ["off"] * len(evidence))[best],
        log_odds=float(log_odds[best]),
        rest_log_odds=float(log_odds_of_rest(log_odds)[best]),
        mirror_log_odds=-math.inf if mirror is None else mirror,
        is_held=evidence[best]["slack_cells"] <= VerdictParams().max_slack_cells and not evidence[best]["is_at_limit"],
        overlap=evidence[best]["overlap"],
    )


def outcome(best: BestCandidate, params: VerdictParams) -> str:
    """Judge a candidate: "right-accepted", "wrong-accepted" or "refused"."""
    confidence = probability(best.log_odds, best.rest_log_odds, best.mirror_log_odds, params)
    if confidence < params.asked_of(best.overlap) or not best.is_held:
        return "refused"
    return "right-accepted" if best.grade in RIGHT else "wrong-accepted"


def _folds(row: Row, count: int) -> frozenset[int]:
    """Return the folds of a row's places: equal names, equal folds in every run."""
    return frozenset(zlib.crc32(place.encode()) % count for place in row["place"].split("+"))


def _kind(row: Row) -> str:
    if not row["related"]:
        return f"{row['suite']}, two places"
    variant = (row["info"] or {}).get("variant", "")
    low = int(10 * (row["overlap"] or 0.0)) / 10
    return (
        f"{row['suite']} {variant}, overlap {low:.1f} and more"
        if low < 0.3
        else f"{row['suite']} {variant}, overlap 0.3 and more"
    )


def _written(weights: NDArray[np.float64]) -> str:
    return f"({', '.join(f'{weight:.2f}' for weight in weights)})"
