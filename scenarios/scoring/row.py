"""The row of a run's results: one method's answer to one pair, scored."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, TypedDict, get_args

from rectmerge.alignment import Verdict
from scenarios.scoring.bends import BendValues
from scenarios.scoring.score import RIGHT, ErrorValues, Grade, Outcome, Stratum

MOST = 1e300  # of a number in a row: more are damage
VERSIONS_EXPLAINED = (
    "Noise 1 to 3 is even noise of the cells in version 1 of a suite, and fitted to maps of robots from version 2 on."
)


class Seconds(TypedDict):
    """Time of an answer: all cores, and on the clock."""

    cpu: float | None
    wall: float


class Row(TypedDict):
    """One line of ``results.jsonl``.

    A new column is a key here, its default in `empty_row` and its value in `scenarios.bench.rows.score_answer`.

    A row without an answer (error, timeout, out of memory) has None wherever the answer would be needed.
    """

    task_id: str  # hash of all that determines the row
    pair_id: str
    suite: str
    place: str  # the cluster for statistics
    method: str  # the contender's label
    knows_scale: bool | None
    related: bool
    stratum: Stratum
    bent: bool | None
    overlap: float | None  # the true one
    residual_px: float | None  # of the truth on its control points, in cells of A
    extent_px: float | None  # diagonal of A's known cells
    outcome: Outcome  # by the method's own verdict
    checked_outcome: Outcome | None  # by the verdict that `merge` acts on, the judge's; None where it was not asked
    verdict: Verdict | None
    confidence: float | None
    candidates: list[list[list[float]]] | None  # 2x3 pixel matrices, B to A, best first
    evidence: list[dict[str, float]] | None  # of each candidate
    grades: list[Grade] | None  # of each candidate; empty without truth
    errors: ErrorValues | None
    bend: BendValues | None  # of an answer that `merge` would write, by the checked verdict
    seconds: Seconds | None
    peak_mb: float | None
    reason: str
    log: str | None  # traceback
    info: dict[str, Any] | None  # everything else that is known of the pair
    trace: dict[str, Any] | None  # numbers that the method reports of its own work


def empty_row(
    *,
    pair_id: str,
    suite: str,
    place: str,
    method: str,
    related: bool,
    stratum: Stratum,
    outcome: Outcome,
    reason: str,
    log: str | None = None,
    task_id: str = "",
) -> Row:
    """Return the row of a task without an answer; its keys stand in the order in which files have them."""
    return {
        "task_id": task_id,
        "pair_id": pair_id,
        "suite": suite,
        "place": place,
        "method": method,
        "knows_scale": None,
        "related": related,
        "stratum": stratum,
        "bent": None,
        "overlap": None,
        "residual_px": None,
        "extent_px": None,
        "outcome": outcome,
        "checked_outcome": outcome,
        "verdict": None,
        "confidence": None,
        "candidates": None,
        "evidence": None,
        "grades": None,
        "errors": None,
        "bend": None,
        "seconds": None,
        "peak_mb": None,
        "reason": reason,
        "log": log,
        "info": None,
        "trace": None,
    }


def row_fault(row: object) -> str:
    """Return what keeps an object from being a row, such as a missing id or an impossible number; empty if nothing."""
    if not isinstance(row, dict):
        return f"it is a {type(row).__name__}"
    for key in ("pair_id", "suite", "place", "method", "reason"):
        if not isinstance(row.get(key), str):
            return f"{key} must be text, got {row.get(key)!r:.40}"
    for key, allowed in (("outcome", get_args(Outcome)), ("stratum", get_args(Stratum))):
        if row.get(key) not in allowed:
            return f"{key} must be one of {', '.join(allowed)}, got {row.get(key)!r:.40}"
    for key, kind in _CONTAINERS.items():
        if not isinstance(row.get(key), kind | None):
            return f"{key} must be of type {kind.__name__} or null"
    numbers = {key: row.get(key) for key in ("overlap", "residual_px", "extent_px", "peak_mb")}
    bend = {key: value for key, value in (row.get("bend") or {}).items() if key != "reason"}
    return _numbers_fault(numbers | (row.get("seconds") or {}) | (row.get("errors") or {}) | bend)


def _numbers_fault(numbers: Mapping[str, Any]) -> str:
    """Return which number is none, or cannot be: infinite or negative."""
    for key, value in numbers.items():
        if value is not None and not (isinstance(value, int | float) and 0 <= value < MOST):
            return f"{key} must be a number from 0, or null"
    return ""


_CONTAINERS = MappingProxyType(
    dict.fromkeys(("candidates", "evidence", "grades"), list)
    | dict.fromkeys(("errors", "bend", "seconds", "info", "trace"), dict)
)


def checked_outcome(row: Row) -> Outcome | None:
    """Return the outcome by the verdict that `merge` acts on; of rows of version 0.1, by the method's own."""
    return row.get("checked_outcome", row["outcome"])


def is_best_right(row: Row) -> bool:
    """Return True if the best candidate is right, whatever the verdict; False without truth or candidate."""
    grades = row["grades"]
    return grades is not None and len(grades) > 0 and grades[0] in RIGHT


def versions_line(rows: Iterable[Row]) -> str:
    """Return a line of Markdown that names the version of every simulated suite among rows; empty where none is.

    Pairs made before suites had versions are of version 1.
    """
    infos = [(row["suite"], row.get("info")) for row in rows]
    versions = sorted({(suite, int(info.get("suite_version", 1))) for suite, info in infos if info and "noise" in info})
    if not versions:
        return ""
    named = ", ".join(f"`{suite}` version {version}" for suite, version in versions)
    return f"Suites: {named}. {VERSIONS_EXPLAINED}\n"


def by_method(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Return the rows of each label, in order of first appearance."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row["method"], []).append(row)
    return found
