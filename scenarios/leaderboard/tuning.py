"""Tuning: one budget for every method, on the same training pairs, the threshold of acceptance included.

A configuration is worth its share of pairs that are right and accepted, less the share that is wrong and accepted.
The threshold costs no budget: every configuration is run once, and the threshold taken at which its scores are worth
most.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rectmerge.errors import InputError
from scenarios.bench.entrants import Entrant
from scenarios.scoring.row import Row, is_best_right
from scenarios.suites.suite import ContenderSpec

SCORE, THRESHOLD = "score", "accept_at"  # in a candidate's evidence; the field of the method


@dataclass(frozen=True, slots=True)
class Threshold:
    """Threshold of acceptance, and its worth: right less wrong answers that it accepts."""

    accept_at: float
    worth: int


def best_threshold(rows: Sequence[Row]) -> Threshold | None:
    """Find the threshold at which the scores of a configuration's answers are worth most; None without scores.

    Of equal ones the highest, which accepts least. The highest score itself is always accepted.

    Examples
    --------
    >>> answer = lambda score, grade: {"evidence": [{"score": score}], "grades": [grade]}
    >>> best_threshold([answer(0.9, "right"), answer(0.7, "off"), answer(0.5, "fine"), answer(0.2, "off")])
    Threshold(accept_at=0.8, worth=1)
    """
    scored = [
        (evidence[0][SCORE], is_best_right(row))
        for row in rows
        if (evidence := row["evidence"]) and SCORE in evidence[0]
    ]
    if not scored:
        return None
    scores, is_right = np.array([score for score, _ in scored]), np.array([right for _, right in scored])
    levels = np.unique(scores)[::-1]
    edges = [*((levels[:-1] + levels[1:]) / 2).tolist(), float(levels[-1]) / 2]
    worth = [int((is_right & (scores >= edge)).sum() - (~is_right & (scores >= edge)).sum()) for edge in edges]
    best = int(np.argmax(worth))
    return Threshold(edges[best], worth[best])


def tuned_contender(entrant: Entrant, configurations: Sequence[ContenderSpec], rows: Sequence[Row]) -> ContenderSpec:
    """Return the configuration of an entrant, of those of `entrant.configurations`, that is worth most.

    Raises
    ------
    InputError
        If no answer has a score.
    """
    thresholds = [best_threshold([row for row in rows if row["method"] == spec.label]) for spec in configurations]
    scored = [
        (spec, threshold)
        for spec, threshold in zip(configurations, thresholds, strict=True)
        if threshold is not None and threshold.accept_at > 0
    ]
    if not scored:
        raise InputError(f"{entrant.label}: no answer has a score: a method to be tuned puts one into its evidence")
    best, threshold = max(scored, key=lambda item: item[1].worth)
    fields = {**best.set, THRESHOLD: float(f"{threshold.accept_at:.4g}")}
    return ContenderSpec(label=f"{entrant.label}-tuned", method=entrant.method, set=fields)


def as_table(contenders: Sequence[ContenderSpec]) -> Mapping[str, Any]:
    """Return contenders in the form of ``tuned.toml``."""
    return {"contenders": [{"label": spec.label, "method": spec.method, "set": dict(spec.set)} for spec in contenders]}
