"""Held-out verdicts: rows of real places judged anew by weights that were fitted without those places."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from rectmerge.errors import InputError
from rectmerge.robust import confidence_model as model
from rectmerge.robust.params import VerdictParams
from rectmerge.robust.verdict import log_odds_of_rest, posterior
from scenarios.scoring.row import Row
from scenarios.scoring.score import RIGHT
from scenarios.studies.calibration import GradedCandidates, Weights, fit_weights, terms_of, usable

FOLDS = 5


def report(rows: Sequence[Row]) -> str:
    """Fit the weights to all usable rows, and return them, their losses and the verdicts on held-out places as text.

    Raises
    ------
    InputError
        If there are no such rows with evidence.
    """
    training = usable(rows)
    if not training:
        raise InputError("no row may be fitted: rows of the split train or of real places, with candidates, are needed")
    graded = GradedCandidates.from_rows(training)
    weights, in_use = fit_weights(graded), Weights.in_use()
    lines = [
        f"# {len(training)} pairs, {int(graded.is_right.any(axis=1).sum())} of them with a right candidate",
        f"rigid = ({', '.join(f'{weight:.2f}' for weight in weights.rigid)})",
        f"bent = ({', '.join(f'{weight:.2f}' for weight in weights.bent)})",
        *(f"# {name}: {loss:.4f} nats a pair; by the numbers in use {used:.4f}" for name, loss, used in zip(
            ("rigid maps", "all maps"), losses(graded, weights), losses(graded, in_use), strict=True)),
        "",
        *held_out_table(training),
    ]  # fmt: skip
    return "\n".join(lines)


def losses(graded: GradedCandidates, weights: Weights) -> tuple[float, float]:
    """Return the mean loss, nats a pair, of the model of rigid maps without bent pairs, and of both on all pairs."""
    rigid = graded.without_bent().with_none_right().rigid_choices().loss(weights.rigid)
    return rigid, graded.with_none_right().bent_choices(weights.rigid).loss(weights.bent)


def held_out_table(rows: Sequence[Row]) -> list[str]:
    """Count the verdicts on pairs of real places by weights that saw no map of these places, by kind of pair."""
    real = [row for row in rows if "split" not in (row["info"] or {})]
    places = sorted({place for row in real for place in _places(row)})
    fold_of = {place: k % FOLDS for k, place in enumerate(places)}
    folds = {id(row): frozenset(fold_of[place] for place in _places(row)) for row in real}
    counts: dict[str, Counter[str]] = {}
    for held in sorted(set(folds.values()), key=sorted):
        seen = [row for row in rows if not folds.get(id(row), frozenset()) & held]
        weights = fit_weights(GradedCandidates.from_rows(seen))
        for row in real:
            if folds[id(row)] == held:
                counts.setdefault(_kind(row), Counter()).update(["n", outcome(row, weights)])
    columns = ("n", "right-accepted", "wrong-accepted", "refused")
    return [
        "# held-out places (with the mirror image's odds by the weights in use)",
        *(
            f"{kind}: {', '.join(f'{count[name]} {name}' for name in columns)}"
            for kind, count in sorted(counts.items())
        ),
    ]


def outcome(row: Row, weights: Weights) -> str:
    """Judge a row's candidates by weights: "right-accepted", "wrong-accepted" or "refused"."""
    evidence, params = row["evidence"] or [], VerdictParams()
    rigid_terms, bent_terms = terms_of(evidence)
    rigid, bent = rigid_terms @ weights.rigid, bent_terms @ weights.bent + evidence[0]["handicap"]
    odds = model.plausibility(rigid, bent)
    best = int(np.argmax(odds))
    mirror = evidence[0]["mirror_log_odds"]  # None where it was not asked
    probability = posterior(odds[best], log_odds_of_rest(odds)[best], -math.inf if mirror is None else mirror)
    is_held = evidence[best]["slack_cells"] <= params.max_slack_cells and not evidence[best]["is_at_limit"]
    if probability < params.accept_at or not is_held:
        return "refused"
    return "right-accepted" if (row["grades"] or ["off"] * len(evidence))[best] in RIGHT else "wrong-accepted"


def _places(row: Row) -> list[str]:
    return row["place"].split("+")


def _kind(row: Row) -> str:
    return f"{row['suite']} {(row['info'] or {}).get('variant', '')}".strip()
