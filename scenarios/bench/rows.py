"""One row per pair and contender: the method is asked, timed and scored, and whatever happens becomes a row."""

from __future__ import annotations

import functools
import os
import time
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, cast

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Alignment, Method
from rectmerge.errors import InputError
from rectmerge.grid import FREE, OCCUPIED, OccupancyGrid
from rectmerge.methods import Scale, align, make_method
from scenarios.bench.external_program import MATRIX, PROGRAM_PEAK_MB, Program
from scenarios.execution.attempt import Attempt, attempt, peak_memory_mb, reset_peak_memory
from scenarios.execution.limits import Limits, call_within
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import is_bent, known_extent
from scenarios.scoring.score import grade, measure_errors, outcome_of, stratum_of

Row = dict[str, Any]
Task = tuple[str, str]  # a pair's id and a contender's label


@dataclass(frozen=True, slots=True, kw_only=True)
class Contender:
    """A method under the label that the tables show, and whether it is told the ratio of the maps' cells."""

    label: str
    method: Method
    knows_scale: bool = False


class Entry(Protocol):
    """A contender as a suite names it."""

    @property
    def label(self) -> str:
        """What the tables show."""

    @property
    def method(self) -> str:
        """A registered method's name."""

    @property
    def set(self) -> Mapping[str, Any]:
        """Fields of the method."""


def contenders_of(
    names: Sequence[str], entries: Sequence[Entry], settings: Sequence[str] = (), *, knows_scale: bool = False
) -> list[Contender]:
    """Make contenders.

    Parameters
    ----------
    names
        Labels of `entries`, or registered methods.
    entries
        The contenders of a suite.
    settings
        ``METHOD.FIELD=VALUE``, METHOD being the label or the method of one or more of the contenders.
    knows_scale
        Whether all are told the ratio of the maps' cells.

    Raises
    ------
    InputError
        If a setting is no setting, or of nobody here.
    MethodError
        If there is no such method or field, or a value does not fit.
    """
    known = {entry.label: (entry.method, dict(entry.set)) for entry in entries}
    chosen = {name: known.get(name, (name, {})) for name in names}
    for setting in settings:
        key, equals, value = setting.partition("=")
        owner, dot, field = key.partition(".")
        if not (equals and dot and owner and field):
            raise InputError(f"--set takes METHOD.FIELD=VALUE, got {setting!r}")
        owned = [fields for label, (method, fields) in chosen.items() if owner in (label, method)]
        if not owned:
            raise InputError(f"--set {setting}: no contender is called {owner!r}; there are: {', '.join(chosen)}")
        for fields in owned:
            fields[field] = value
    return [
        Contender(label=label, method=make_method(method, **fields), knows_scale=knows_scale)
        for label, (method, fields) in chosen.items()
    ]


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """A method's answer to one pair, or its failure, and what it took; None is what cannot be told."""

    attempt: Attempt[Alignment]
    wall_s: float | None
    cpu_s: float | None
    peak_mb: float | None


def answer(pair: MapPair, contender: Contender, *, seed: int = 0) -> Answer:
    """Ask a method for one pair, timed; what it compiles on its first call in this process is compiled before."""
    attempt(lambda: _warm_up(cast(Hashable, contender.method)))
    return _timed(pair.a, pair.b, contender.method, seed, _told_scale(pair, contender))


def answer_within(pair: MapPair, contender: Contender, *, seed: int = 0, limits: Limits) -> Answer:
    """Ask a method for one pair in a child process, which times itself and is killed where it takes too much."""
    call = functools.partial(_timed, pair.a, pair.b, contender.method, seed, _told_scale(pair, contender))
    compiles = not isinstance(contender.method, Program)
    first = functools.partial(_warm_up, cast(Hashable, contender.method)) if compiles else None
    got = call_within(limits, call, warm_up=first)
    if got.value is not None:
        return got.value
    lost: Attempt[Alignment] = Attempt(failure=got.failure, reason=got.reason, log=got.log)
    waited = limits.timeout_s if got.failure == "timeout" else None
    return Answer(attempt=lost, wall_s=waited, cpu_s=None, peak_mb=None)


def _told_scale(pair: MapPair, contender: Contender) -> Scale:
    """Return what a contender is told of the pixel scale.

    One that knows it is told the true one, of two places the ratio of the resolutions; where those are not known, none.
    """
    if not contender.knows_scale:
        return "auto"
    if pair.pixels is not None:
        return pair.pixels.scale
    size_a, size_b = (pair.info.get(f"resolution_{name}") for name in "ab")
    return size_b / size_a if size_a and size_b else "free"


def _timed(a: OccupancyGrid, b: OccupancyGrid, method: Method, seed: int, scale: Scale) -> Answer:
    can_measure = reset_peak_memory()
    wall, cpu = time.perf_counter(), _cpu_s()
    got = attempt(lambda: align(a, b, method=method, scale=scale, seed=seed))
    wall, cpu = time.perf_counter() - wall, _cpu_s() - cpu
    peaks = [got.value.trace.get(PROGRAM_PEAK_MB) if got.value else None, peak_memory_mb() if can_measure else None]
    return Answer(attempt=got, wall_s=wall, cpu_s=cpu, peak_mb=max((peak for peak in peaks if peak), default=None))


def _cpu_s() -> float:
    """Time of all cores that this process and the programs it started have used, seconds."""
    used = os.times()
    return time.process_time() + used.children_user + used.children_system


def row_of(pair: MapPair, contender: Contender, given: Answer) -> Row:
    """Score an answer and lay it out as a row of ``results.jsonl``."""
    found = given.attempt.value
    row = blank_row(pair.pair_id, pair.suite, pair.place, contender.label)
    extent = known_extent(pair.a) if pair.pixels else None
    residual = pair.residual_px / extent if extent and pair.residual_px is not None else None
    stratum = stratum_of(pair.related, pair.overlap)
    candidates = _placements(found) if found is not None else []
    errors = [measure_errors(pixels, pair) for pixels in candidates] if extent else []
    grades = [grade(e, residual or 0.0) for e in errors]
    row.update(
        knows_scale=contender.knows_scale,
        related=pair.related,
        stratum=stratum,
        bent=is_bent(residual),
        overlap=pair.overlap,
        residual_px=pair.residual_px,
        extent_px=extent,
        outcome=given.attempt.failure,
        reason=given.attempt.reason,
        log=given.attempt.log,
        seconds=None if given.wall_s is None else {"cpu": given.cpu_s, "wall": given.wall_s},
        peak_mb=given.peak_mb,
        info=dict(pair.info),
    )
    if found is not None:
        row.update(
            outcome=outcome_of(found.verdict, grades, stratum),
            verdict=found.verdict,
            reason=found.reason,
            confidence=found.confidence,
            candidates=[pixels.tolist() for pixels in candidates],
            evidence=[dict(candidate.evidence) for candidate in found.candidates],
            errors=errors[0].as_dict() if errors else None,
            grades=grades,
            trace=dict(found.trace),
        )
    return row


def _placements(found: Alignment) -> list[NDArray[np.float64]]:
    """Return the candidates' pixel matrices; what a program printed stays as it is, mirrored or sheared."""
    if (printed := found.trace.get(MATRIX)) is not None:
        return [np.asarray(printed)]
    return [candidate.pixels.matrix for candidate in found.candidates]


def blank_row(pair_id: str, suite: str, place: str, label: str) -> Row:
    """Lay out a row of which nothing is known yet."""
    row: Row = {"task_id": None, "pair_id": pair_id, "suite": suite, "place": place}
    keys = (
        "knows_scale",
        "related",
        "stratum",
        "bent",
        "overlap",
        "residual_px",
        "extent_px",
        "outcome",
        "verdict",
        "confidence",
    )
    late = ("candidates", "evidence", "grades", "errors", "seconds", "peak_mb", "reason", "log", "info", "trace")
    return {**row, "method": label, **dict.fromkeys((*keys, *late))}


@functools.cache
def _warm_up(method: Method) -> None:
    """Let a method compile and load what it needs, once per process, on a small building seen twice."""
    align(*_small_building(), method=method)


def _small_building() -> tuple[OccupancyGrid, OccupancyGrid]:
    """Draw a building of six rooms, and the same turned by 30 degrees."""
    cells = np.full((96, 128), FREE, np.int8)
    cells[[0, 40, -1], :] = cells[:, [0, 50, 90, -1]] = OCCUPIED
    cells[60:70, 50] = cells[20:30, 90] = cells[40, 15:25] = FREE  # doors
    turn = cv2.getRotationMatrix2D((63.5, 47.5), 30, 1.0) + np.array([[0, 0, 20], [0, 0, 36]])
    turned = cv2.warpAffine(cells.view(np.uint8), turn, (168, 168), flags=cv2.INTER_NEAREST, borderValue=255)
    return OccupancyGrid(cells), OccupancyGrid(turned.view(np.int8))
