"""Leaderboard of one suite and track: counts, errors, calibration and cost of each method."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenarios.report.reading import TrackResults
from scenarios.scoring.row import Row, checked_outcome
from scenarios.scoring.score import FAILURES
from scenarios.scoring.statistics import Rate, clustered_rate
from scenarios.studies.accuracy import count, is_right, median_error_px
from scenarios.studies.trust import answered, calibration_error

ACCEPTED = ("right-accepted", "wrong-accepted")
WIDEST_ERROR = 0.05  # of L: coarse answers end there


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """Line of one method.

    Parameters
    ----------
    label
        Label of the method.
    right
        Required pairs that are right and accepted, with the interval by place.
    area
        Area under the share of required pairs accepted with an error of at most e, for e from 0 to 5 % of L; None
        without errors.
    best
        Required pairs whose best candidate is right, whatever the verdict; None without grades.
    wrong
        Pairs of one place that are accepted though wrong.
    merged
        Pairs of two places that are accepted, with the interval by place.
    checked_right, checked_wrong
        Required pairs that are right and accepted, and pairs that are accepted though wrong or of two places, where the
        judge of `rectmerge check` has the last word; None where it was not asked.
    ambiguous, failed
        Of all pairs.
    aurc
        Area under the risk-coverage curve: the mean share of wrong answers among the most confident, over all shares
        that are kept; None without answers.
    brier, calibration
        Brier score and expected calibration error of the confidence.
    error_cells
        Median error of the best candidate on required pairs, a pair without one counting as worst; None if that is it.
    seconds
        Median processor time of an answer.
    memory_mb
        Largest peak of memory.
    """

    label: str
    right: Rate
    area: float | None
    best: int | None
    wrong: int
    merged: Rate
    checked_right: int | None
    checked_wrong: int | None
    ambiguous: int
    failed: int
    aurc: float | None
    brier: float | None
    calibration: float | None
    error_cells: float | None
    seconds: float | None
    memory_mb: float | None


def standings(track_results: TrackResults) -> list[Standing]:
    """Return the lines of a suite and track, the most right and accepted first."""
    lines = [_standing(label, rows) for label, rows in track_results.by_method().items()]
    return sorted(lines, key=lambda line: (-line.right.k, line.wrong + line.merged.k))


def tie(lines: Sequence[Standing]) -> str:
    """Return the counts that all of several methods share; empty where they differ or there is one method."""
    counts = {(line.right.k, line.wrong, line.merged.k) for line in lines}
    if len(lines) < 2 or len(counts) > 1:
        return ""
    right, wrong, merged = counts.pop()
    return f"each has {right} of {lines[0].right.n} right and accepted, {wrong} wrong and {merged} false merges"


def _standing(label: str, rows: Sequence[Row]) -> Standing:
    required = [row for row in rows if row["stratum"] == "required"]
    unrelated = [row for row in rows if row["stratum"] == "unrelated"]
    counts = count(rows)
    checked = Counter(checked_outcome(row) for row in rows if row["stratum"] != "optional")
    is_graded, was_checked = _has_grades(rows), None not in checked
    confidence, right = confident(rows if is_graded else [])
    seconds = [row["seconds"]["cpu"] for row in rows if row["seconds"] and row["seconds"]["cpu"] is not None]
    peaks = [row["peak_mb"] for row in rows if row["peak_mb"]]
    error = median_error_px(required)
    return Standing(
        label=label,
        right=rate_of(required, "right-accepted"),
        area=accuracy_area(required),
        best=sum(map(is_right, required)) if is_graded else None,
        wrong=sum(row["outcome"] == "wrong-accepted" for row in rows if row["stratum"] != "unrelated"),
        merged=rate_of(unrelated, "wrong-accepted"),
        checked_right=checked["right-accepted"] if was_checked else None,
        checked_wrong=checked["wrong-accepted"] if was_checked else None,
        ambiguous=counts["ambiguous"],
        failed=counts["failed"],
        aurc=float(risks(confidence, right).mean()) if len(right) else None,
        brier=float(np.mean((confidence - right) ** 2)) if len(right) else None,
        calibration=calibration_error(confidence, right) if len(right) else None,
        error_cells=error,
        seconds=float(np.median(seconds)) if seconds else None,
        memory_mb=max(peaks, default=None),
    )


def accuracy_area(required: Sequence[Row]) -> float | None:
    """Return the area under the share of pairs accepted with an error of at most e, for e from 0 to 5 % of L.

    Parameters
    ----------
    required
        Rows of pairs that are to be merged; all of them count.

    Returns
    -------
    float or None
        0..1, the mean of 1 - e / (5 % of L), 0 beyond and for what is not accepted; None where no accepted answer has
        an error.

    Examples
    --------
    >>> accepted = [{"outcome": "right-accepted", "errors": {"e_over_l": e}} for e in (0.0, 0.025, 0.2)]
    >>> accuracy_area([*accepted, {"outcome": "rejected", "errors": {"e_over_l": 0.0}}])
    0.375
    """
    accepted = [row for row in required if row["outcome"] in ACCEPTED]
    errors = np.array([row["errors"]["e_over_l"] for row in accepted if row["errors"]])
    if not required or (accepted and not len(errors)):
        return None
    return float(np.maximum(0.0, 1.0 - errors / WIDEST_ERROR).sum() / len(required))


def _has_grades(rows: Sequence[Row]) -> bool:
    """Return False if no answer is graded, as in rows that others hand in."""
    answers = [row for row in rows if row["outcome"] not in FAILURES]
    return not answers or any(row["grades"] is not None for row in answers)


def rate_of(rows: Sequence[Row], outcome: str) -> Rate:
    """Count an outcome, with its interval by place."""
    return clustered_rate([row["outcome"] == outcome for row in rows], [row["place"] for row in rows])


def confident(rows: Sequence[Row]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the confidence of answers that have one, and 1.0 where they are right, most confident first."""
    confidence, right = answered([row for row in rows if row["confidence"] is not None])
    order = np.argsort(-confidence, kind="stable")
    return confidence[order], right[order]


def risks(confidence: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the share that is wrong of the first 1, 2, ... answers; of equally confident ones, of all of them.

    Examples
    --------
    >>> risks(np.array([0.9, 0.5, 0.5, 0.1]), np.array([1.0, 1.0, 0.0, 0.0])).round(2).tolist()
    [0.0, 0.33, 0.33, 0.5]
    """
    shares = np.cumsum(1 - right) / np.arange(1, len(right) + 1)
    last = np.searchsorted(-confidence, -confidence, side="right") - 1
    return np.asarray(shares[last], np.float64)


def as_cells(line: Standing) -> Mapping[str, tuple[str, Any]]:
    """Return the cells of a line by heading: the text, and the number to sort by or None."""
    return {
        "right and accepted": (str(line.right), line.right.value),
        "area": _number(line.area, 2),
        "best right": _number(line.best, 0),
        "wrong": (str(line.wrong), line.wrong),
        "false merges": (str(line.merged) if line.merged.n else "-", line.merged.value),
        "checked: right / wrong": (
            "-" if line.checked_right is None else f"{line.checked_right} / {line.checked_wrong}",
            line.checked_right,
        ),
        "ambiguous": (str(line.ambiguous), line.ambiguous),
        "failed": (str(line.failed), line.failed),
        "AURC": _number(line.aurc, 3),
        "Brier": _number(line.brier, 3),
        "ECE": _number(line.calibration, 3),
        "e, cells": _number(line.error_cells, 2),
        "CPU s": _number(line.seconds, 2),
        "MB": _number(line.memory_mb, 0),
    }


def _number(value: float | None, digits: int) -> tuple[str, float | None]:
    return ("-" if value is None else f"{value:.{digits}f}"), value
