"""Tuning: one budget for every method, on the same training pairs, by the area under the risk-coverage curve.

The configuration is chosen first, by the order of its scores alone: the least area, so that no threshold and no single
pair decides. Its threshold of acceptance costs no budget, since every configuration is run once: the one at which right
less wrong answers are most takes the place of the configuration's own where it is better by more than a standard error.
So the authors' parameters, which are the first configuration, and their threshold stay where nothing is surely better.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from scenarios.bench.contenders import make_contenders
from scenarios.bench.entrants import Entrant
from scenarios.report.standings import risks
from scenarios.scoring.row import Row, is_best_right
from scenarios.suites.suite import ContenderSpec

SCORE, THRESHOLD = "score", "accept_at"  # in a candidate's evidence; the field of the method


@dataclass(frozen=True, slots=True)
class ScoredAnswers:
    """Scores (N,) of a configuration's answers to all pairs, and whether each is right; of no candidate -inf, wrong."""

    scores: NDArray[np.float64]
    is_right: NDArray[np.bool_]

    @classmethod
    def from_rows(cls, rows: Sequence[Row]) -> ScoredAnswers:
        """Read the score of each row's best candidate."""
        scores = [evidence[0].get(SCORE, -math.inf) if (evidence := row["evidence"]) else -math.inf for row in rows]
        right = [is_best_right(row) and math.isfinite(score) for row, score in zip(rows, scores, strict=True)]
        return cls(np.array(scores, np.float64), np.array(right, np.bool_))

    def aurc(self) -> float:
        """Return the area under the risk-coverage curve: the mean share wrong among the best scored, over all shares.

        A pair without an answer counts as wrong and comes last, so a method gains nothing by answering less.

        Examples
        --------
        >>> round(ScoredAnswers(np.array([0.9, 0.5, 0.4, -np.inf]), np.array([True, False, True, False])).aurc(), 3)
        0.333
        """
        order = np.argsort(-self.scores, kind="stable")
        return float(risks(self.scores[order], self.is_right[order].astype(np.float64)).mean())

    def worth(self, accept_at: float) -> int:
        """Return the right less the wrong answers that a threshold accepts."""
        accepted = self.scores >= accept_at
        return int((self.is_right & accepted).sum() - (~self.is_right & accepted).sum())

    def threshold(self, own: float) -> float:
        """Return the threshold that is worth most, or the method's own where that is within a standard error.

        The standard error of the difference of two thresholds is the root of the number of answers on which they
        differ, each of which counts for or against. Of equal thresholds the highest, which accepts least.

        Notes
        -----
        The one-standard-error rule of L. Breiman et al., "Classification and Regression Trees", 1984.

        Examples
        --------
        >>> answers = ScoredAnswers(np.array([1.5, 1.4, 1.2, 0.9]), np.array([True, True, False, True]))
        >>> answers.threshold(1.0)
        1.0
        """
        levels = np.unique(self.scores[np.isfinite(self.scores) & (self.scores > 0)])[::-1]
        if not len(levels):
            return own
        edges = [*((levels[:-1] + levels[1:]) / 2).tolist(), float(levels[-1]) / 2]
        best = edges[int(np.argmax([self.worth(edge) for edge in edges]))]
        differing = int(np.sum((self.scores >= best) != (self.scores >= own)))
        return best if self.worth(best) - self.worth(own) > math.sqrt(differing) else own


def tuned_contender(entrant: Entrant, configurations: Sequence[ContenderSpec], rows: Sequence[Row]) -> ContenderSpec:
    """Return the configuration of least area, of those of `entrant.configurations`, with its threshold.

    Of equal areas the first, so that the authors' own parameters stay where nothing is better.

    Raises
    ------
    InputError
        If no answer has a score.
    """
    answers = [ScoredAnswers.from_rows([row for row in rows if row["method"] == spec.label]) for spec in configurations]
    if not any(np.isfinite(answer.scores).any() for answer in answers):
        raise InputError(f"{entrant.label}: no answer has a score: a method to be tuned puts one into its evidence")
    best = int(np.argmin([answer.aurc() for answer in answers]))
    own = own_threshold(configurations[best])
    accept_at = answers[best].threshold(own)
    changed = {} if accept_at == own else {THRESHOLD: float(f"{accept_at:.4g}")}
    return ContenderSpec(
        label=f"{entrant.label}-tuned", method=entrant.method, set={**configurations[best].set, **changed}
    )


def own_threshold(spec: ContenderSpec) -> float:
    """Return the threshold of acceptance that a configuration has, by its method's default where it sets none."""
    (contender,) = make_contenders([spec.label], [spec])
    return float(getattr(contender.method, THRESHOLD))


def as_table(contenders: Sequence[ContenderSpec]) -> Mapping[str, Any]:
    """Return contenders in the form of ``tuned.toml``."""
    return {"contenders": [{"label": spec.label, "method": spec.method, "set": dict(spec.set)} for spec in contenders]}
