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
    """A threshold of acceptance, and how many more answers it accepts that are right than wrong."""

    accept_at: float
    worth: int


def best_threshold(rows: Sequence[Row]) -> Threshold | None:
    """Find the threshold at which the scores of a configuration's answers are worth most; None where none are told.

    Of equals the highest: it accepts least. The highest score itself is always accepted: its method allows no more.

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
    """Take of an entrant's configurations, run as `entrant.configurations` gave them, the one that is worth most.

    Raises
    ------
    InputError
        If none of them told a score.
    """
    found = [(one, best_threshold([row for row in rows if row["method"] == one.label])) for one in configurations]
    told = [(one, threshold) for one, threshold in found if threshold is not None and threshold.accept_at > 0]
    if not told:
        raise InputError(f"{entrant.label}: no answer tells a score: a method to be tuned names one in its evidence")
    best, threshold = max(told, key=lambda pair: pair[1].worth)
    fields = {**best.set, THRESHOLD: float(f"{threshold.accept_at:.4g}")}
    return ContenderSpec(label=f"{entrant.label}-tuned", method=entrant.method, set=fields)


def as_table(contenders: Sequence[ContenderSpec]) -> Mapping[str, Any]:
    """Lay contenders out as ``tuned.toml`` has them."""
    return {"contenders": [{"label": one.label, "method": one.method, "set": dict(one.set)} for one in contenders]}
