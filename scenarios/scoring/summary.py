"""The summary of a run's rows by method and stratum, added up row by row: no row is kept."""

from __future__ import annotations

import math
from array import array
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from scenarios.scoring.bends import BendTally
from scenarios.scoring.score import RIGHT
from scenarios.scoring.statistics import mean_of_places, rate_of_places

STRATA = ("required", "identifiable", "unidentifiable", "optional", "unrelated", "bent")
APART = ("identifiable", "unidentifiable", "bent")  # whose rows are in the other strata as well


def summarise(rows: Iterable[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Summarise rows of ``results.jsonl`` by method and stratum.

    Parameters
    ----------
    rows
        As in DESIGN's contract; every row counts, whatever its outcome.

    Returns
    -------
    dict
        By method, then by stratum, as `strata_of` has them. Strata without rows are left out. The same whatever the
        order of the rows, methods by name.
    """
    tallies: dict[tuple[str, str], _Tally] = {}
    for row in rows:
        for stratum in strata_of(row):
            tallies.setdefault((row["method"], stratum), _Tally()).add(row)
    methods = sorted({method for method, _ in tallies})
    return {
        method: {name: tallies[method, name].summary() for name in STRATA if (method, name) in tallies}
        for method in methods
    }


def strata_of(row: Mapping[str, Any]) -> tuple[str, ...]:
    """Name the strata of a row: "required", "optional" or "unrelated", and which of those apart it is in.

    Required pairs whose building is known are "identifiable" or not; if not, "ambiguous" is the right answer.
    """
    apart = ["bent"] if row["bent"] else []
    can_be_told = (row.get("info") or {}).get("identifiable")
    if row["stratum"] == "required" and isinstance(can_be_told, bool):
        apart.append("identifiable" if can_be_told else "unidentifiable")
    return (row["stratum"], *apart)


class _Tally:
    """Running totals of rows: counts, by place for the intervals, and a few numbers each."""

    def __init__(self) -> None:
        self._outcomes: Counter[str] = Counter()
        self._checked: Counter[str] = Counter()
        self._best: Counter[str] = Counter()
        self._places: dict[str, list[int]] = {}  # rows, right-accepted, wrong-accepted
        self._errors, self._errors_right, self._walls = array("d"), array("d"), array("d")
        self._missed, self._not_right = array("d"), array("b")
        self._bends = BendTally()

    def add(self, row: Mapping[str, Any]) -> None:
        outcome, best = row["outcome"], row["grades"][0] if row["grades"] else "none"
        right, wrong = outcome == "right-accepted", outcome == "wrong-accepted"
        self._outcomes[outcome] += 1
        self._checked[row.get("checked_outcome", outcome)] += 1  # rows of earlier versions have none
        self._best[best] += 1
        counts = self._places.setdefault(row["place"], [0, 0, 0])
        counts[:] = [counts[0] + 1, counts[1] + right, counts[2] + wrong]
        # a row without a candidate is as bad as can be
        error = float(row["errors"]["e_px"]) if row["errors"] else math.inf
        self._errors.append(error)
        self._bends.add(row)
        if right:
            self._errors_right.append(error)
        if row["seconds"]:
            self._walls.append(row["seconds"]["wall"])
        if row["verdict"]:
            self._not_right.append(best not in RIGHT)
            if row["confidence"] is not None:
                self._missed.append((row["confidence"] - (best in RIGHT)) ** 2)

    def summary(self) -> dict[str, Any]:
        counts, rights, wrongs = np.array([self._places[place] for place in sorted(self._places)], dtype=np.float64).T
        return {
            "n": int(counts.sum()),
            "places": len(counts),
            "outcomes": _sorted(self._outcomes),
            "checked_outcomes": _sorted(self._checked),
            "right_accepted": rate_of_places(rights, counts).as_dict(),
            "right_accepted_mean_of_places": mean_of_places(rights, counts),
            "wrong_accepted": rate_of_places(wrongs, counts).as_dict(),
            "best_candidate": _sorted(self._best),
            "median_e_px": _median(self._errors),
            "median_e_px_right": _median(self._errors_right),
            "median_wall_s": _median(self._walls),
            "bends": self._bends.summary(),
            "brier": _mean(self._missed),
            "share_of_answers_not_right": _mean(self._not_right),
        }


def _sorted(counts: Counter[str]) -> dict[str, int]:
    return dict(sorted(counts.items()))


def _mean(values: array[float] | array[int]) -> float | None:
    return math.fsum(values) / len(values) if values else None


def _median(values: array[float]) -> float | None:
    """Return the median; None of nothing, or if half of the values are infinite."""
    ordered = np.sort(np.array(values))
    middle = float(ordered[len(ordered) // 2]) if len(ordered) else math.inf
    return float(np.median(ordered)) if math.isfinite(middle) else None
