"""Row of a submission: the part of a run's row that its line of the table needs, and its check key by key."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from typing import Any, cast

from rectmerge.alignment import Verdict
from rectmerge.errors import InputError, ScenarioError
from scenarios.corruption import NoiseLevel
from scenarios.scoring.row import Row, empty_row, row_fault
from scenarios.scoring.score import FAILURES, Grade, Outcome, Stratum
from scenarios.suites.toml_tables import structure


@dataclass(frozen=True, slots=True, kw_only=True)
class SubmittedErrors:
    """Errors of the best candidate, as in `scenarios.scoring.score.Errors`; no table needs those that may miss."""

    e_px: float
    e_over_l: float
    e_m: float | None = None
    rotation_deg: float | None = None
    scale_pct: float | None = None
    reflected: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class SubmittedSeconds:
    """Time of an answer, on all cores and on the clock; None where it was not measured."""

    cpu: float | None
    wall: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SubmittedInfo:
    """Facts about a pair by which tables sort it; the box of a difficulty grid among them."""

    split: str | None = None
    noise: NoiseLevel = 0
    suite_version: int = 1
    variant: str | None = None
    family: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SubmittedRow:
    """Row of a submission. Its fields mean what they mean in `scenarios.scoring.row.Row`; others are refused."""

    pair_id: str
    suite: str
    place: str
    method: str
    related: bool
    stratum: Stratum
    outcome: Outcome
    knows_scale: bool | None = None
    bent: bool | None = None
    overlap: float | None = None
    residual_px: float | None = None
    extent_px: float | None = None
    checked_outcome: Outcome | None = None
    verdict: Verdict | None = None
    confidence: float | None = None
    candidates: list[list[list[float]]] | None = None
    grades: list[Grade] | None = None
    errors: SubmittedErrors | None = None
    seconds: SubmittedSeconds | None = None
    peak_mb: float | None = None
    reason: str = ""
    info: SubmittedInfo | None = None

    def __post_init__(self) -> None:
        if self.confidence is not None and not 0 <= self.confidence <= 1:
            raise InputError(f"confidence must lie in 0..1 or be null, got {self.confidence}")
        if not all(_is_matrix(candidate) for candidate in self.candidates or []):
            raise InputError("candidates must be 2x3 matrices of finite numbers")


REQUIRED = tuple(field.name for field in fields(SubmittedRow) if field.default is MISSING)
KEPT = tuple(field.name for field in fields(SubmittedRow))
KEPT_INFO = tuple(field.name for field in fields(SubmittedInfo))


def submitted_row_fault(row: Mapping[str, Any], at: str) -> str:
    """Return what is wrong with a row, beginning with its path `at` and the key; empty if nothing."""
    try:
        structure(row, SubmittedRow, at)
    except ScenarioError as error:
        return str(error).splitlines()[0]
    fault = row_fault(whole_row(row))
    return f"{at}.{fault}" if fault else ""


def whole_row(row: Mapping[str, Any]) -> Row:
    """Fill up a submission's row with None; what the judge says stays unknown where it was not asked."""
    filled = empty_row(**{key: row[key] for key in REQUIRED}, reason="")
    return cast(Row, {**filled, "checked_outcome": None, **row})


def reduced_row(row: Row) -> dict[str, Any]:
    """Leave out what no line of the table needs, the candidates after the first among it.

    The reason of a failure is left out too: an error may name files of the machine.
    """
    kept: dict[str, Any] = {key: value for key, value in row.items() if key in KEPT}
    info = {key: value for key, value in (row["info"] or {}).items() if key in KEPT_INFO and value not in (None, "")}
    kept |= {"candidates": None if row["candidates"] is None else row["candidates"][:1], "info": info}
    if row["outcome"] in FAILURES:
        del kept["reason"]
    return {key: value for key, value in kept.items() if value is not None}


def _is_matrix(candidate: list[list[float]]) -> bool:
    return [len(line) for line in candidate] == [3, 3] and all(math.isfinite(x) for line in candidate for x in line)
