"""One row per pair and contender: the method is asked, timed and scored, and whatever happens becomes a row."""

from __future__ import annotations

import functools
import time
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, cast

import cv2
import numpy as np

from rectmerge.alignment import Alignment, Method
from rectmerge.errors import InputError
from rectmerge.grid import FREE, OCCUPIED, OccupancyGrid
from rectmerge.methods import align, make_method
from scenarios.executors import Attempt, attempt, peak_memory_mb, reset_peak_memory
from scenarios.pairs import MapPair, PairSource
from scenarios.score import CANDIDATES_HEARD, grade, measure_errors, outcome_of, stratum_of
from scenarios.truth import is_bent, known_extent

Row = dict[str, Any]
TIMEOUT_S = 300.0  # of one answer


@dataclass(frozen=True, slots=True, kw_only=True)
class Contender:
    """A method under the label that the tables show."""

    label: str
    method: Method


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


def contenders_of(names: Sequence[str], entries: Sequence[Entry], settings: Sequence[str] = ()) -> list[Contender]:
    """Make contenders.

    Parameters
    ----------
    names
        Labels of `entries`, or registered methods.
    entries
        The contenders of a suite.
    settings
        ``METHOD.FIELD=VALUE``, METHOD being the label or the method of one or more of the contenders.

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
    return [Contender(label=label, method=make_method(method, **fields)) for label, (method, fields) in chosen.items()]


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """A method's answer to one pair, or its failure, and what it took; `peak_mb` is None where it cannot be told."""

    attempt: Attempt[Alignment]
    wall_s: float
    cpu_s: float
    peak_mb: float | None


def answer(pair: MapPair, contender: Contender, *, seed: int = 0, timeout_s: float = TIMEOUT_S) -> Answer:
    """Ask a method for one pair, timed; what it compiles on its first call in this process is compiled before."""
    attempt(lambda: _warm_up(cast(Hashable, contender.method)), timeout_s)
    can_measure = reset_peak_memory()
    wall, cpu = time.perf_counter(), time.process_time()
    got = attempt(lambda: align(pair.a, pair.b, method=contender.method, seed=seed), timeout_s)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return Answer(attempt=got, wall_s=wall, cpu_s=cpu, peak_mb=peak_memory_mb() if can_measure else None)


def row_of(pair: MapPair, contender: Contender, given: Answer) -> Row:
    """Score an answer and lay it out as a row of ``results.jsonl``."""
    found = given.attempt.value
    row = _blank_row(pair.pair_id, pair.suite, pair.place, contender.label)
    extent = known_extent(pair.a) if pair.pixels else None
    residual = pair.residual_px / extent if extent and pair.residual_px is not None else None
    stratum = stratum_of(pair.related, pair.overlap)
    candidates = [candidate.pixels for candidate in found.candidates] if found is not None else []
    errors = [measure_errors(pixels, pair) for pixels in candidates[:CANDIDATES_HEARD]] if extent else []
    grades = [grade(e, residual or 0.0) for e in errors]
    row.update(
        related=pair.related,
        stratum=stratum,
        bent=is_bent(residual),
        overlap=pair.overlap,
        residual_px=pair.residual_px,
        extent_px=extent,
        outcome=given.attempt.failure,
        reason=given.attempt.reason,
        log=given.attempt.log,
        seconds={"cpu": given.cpu_s, "wall": given.wall_s},
        peak_mb=given.peak_mb,
        info=dict(pair.info),
    )
    if found is not None:
        row.update(
            outcome=outcome_of(found.verdict, grades, stratum),
            verdict=found.verdict,
            reason=found.reason,
            confidence=found.confidence,
            candidates=[pixels.matrix.tolist() for pixels in candidates],
            errors=errors[0].as_dict() if errors else None,
            grades=grades,
            trace=dict(found.trace),
        )
    return row


def rows_of_source(
    source: PairSource, *, suite: str, contenders: Sequence[Contender], seed: int = 0, timeout_s: float = TIMEOUT_S
) -> list[Row]:
    """Make the pairs of a source and put every contender to each of them.

    A pair that cannot be made is an error row of every contender: it stays in the denominator.
    """
    rows: list[Row] = []
    missing = list(source.pair_ids)
    lost: Attempt[Any] = Attempt(failure="error", reason="its source ended without it")
    for made in _made_pairs(source):
        if (pair := made.value) is None:
            lost = made
            break
        missing = [pair_id for pair_id in missing if pair_id != pair.pair_id]
        for one in contenders:
            given = answer(pair, one, seed=seed, timeout_s=timeout_s)
            scored = attempt(functools.partial(row_of, pair, one, given))
            rows += [scored.value] if scored.value else failed_rows(source, [pair.pair_id], [one], scored, suite=suite)
    return rows + failed_rows(source, missing, contenders, lost, suite=suite)


def failed_rows(
    source: PairSource, pair_ids: Sequence[str], contenders: Sequence[Contender], failure: Attempt[Any], *, suite: str
) -> list[Row]:
    """Make the rows of pairs that could not be made: they stay in the denominator, as pairs that had to be merged."""
    return [
        {
            **_blank_row(pair_id, suite, source.source_id, one.label),
            "stratum": "required",
            "outcome": failure.failure,
            "reason": f"the pair could not be made or scored: {failure.reason}",
            "log": failure.log,
        }
        for pair_id in pair_ids
        for one in contenders
    ]


def _blank_row(pair_id: str, suite: str, place: str, label: str) -> Row:
    row: Row = {"task_id": f"{suite}/{pair_id}/{label}", "pair_id": pair_id, "suite": suite, "place": place}
    keys = ("related", "stratum", "bent", "overlap", "residual_px", "extent_px", "outcome", "verdict", "confidence")
    late = ("candidates", "grades", "errors", "seconds", "peak_mb", "reason", "log", "info", "trace")
    return {**row, "method": label, **dict.fromkeys((*keys, *late))}


def _made_pairs(source: PairSource) -> Iterator[Attempt[MapPair]]:
    """Make pairs one by one; the first failure ends it."""
    opened = attempt(lambda: iter(source.pairs()))
    while opened.value is not None:
        made = attempt(functools.partial(next, opened.value, None))
        if made.value is None and made.failure is None:
            return
        yield made
        if made.failure:
            return
    yield Attempt(failure=opened.failure, reason=opened.reason, log=opened.log)


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
