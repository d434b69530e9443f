"""Comparison of two runs on the same pairs: improvements, regressions, and their intervals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rectmerge.errors import InputError
from scenarios.bench.resume import RESULTS, SUMMARY, read_row_file
from scenarios.scoring.score import FAILURES, Outcome
from scenarios.scoring.statistics import clustered_difference
from scenarios.scoring.summary import STRATA, strata_of
from scenarios.studies.speed import SLOWER_AT_MOST, Key, SpeedRatio, Timed, compare_speed, machine_of

ERROR_TOLERANCE = 0.10  # of the baseline's median error,
ERROR_TOLERANCE_PX = 0.05  # and this many cells
TIMEOUT: Outcome = "timeout"  # depends on the machine and its load
Rate = tuple[str, tuple[Outcome, ...], int]  # name, outcomes, sign of improvement
RIGHT_ANSWER: dict[str, tuple[Rate, ...]] = {  # by stratum, where the right answer is not to accept
    "unidentifiable": (("ambiguous, with the truth", ("ambiguous-with-truth",), +1),),
    "unrelated": (),
}
ACCEPTED: tuple[Rate, ...] = (("right, accepted", ("right-accepted",), +1),)
RATES: tuple[Rate, ...] = (
    ("wrong, accepted", ("wrong-accepted",), -1),
    ("failed", FAILURES, -1),
)


@dataclass(frozen=True, slots=True)
class Compared:
    """Columns of a row that are compared."""

    place: str
    strata: tuple[str, ...]
    outcome: str
    e_px: float
    cpu_s: float | None


Rows = Mapping[Key, Compared]


@dataclass(frozen=True, slots=True)
class ComparisonLine:
    """Line of a table: one measure in both runs.

    Parameters
    ----------
    method, stratum, n, what
        The rows, their number, and the name of the measure.
    before, now, difference
        As text.
    is_regression
        Whether it became worse by more than the tolerance.
    """

    method: str
    stratum: str
    n: int
    what: str
    before: str
    now: str
    difference: str
    is_regression: bool


@dataclass(frozen=True, slots=True)
class Comparison:
    """Differences of a run from a baseline, with notes on what could not be compared."""

    lines: Sequence[ComparisonLine]
    notes: Sequence[str]

    @property
    def regressions(self) -> list[ComparisonLine]:
        """Lines that became worse by more than the tolerance."""
        return [line for line in self.lines if line.is_regression]

    def page(self) -> str:
        """Return the comparison in Markdown."""
        worse = [f"{line.method}, {line.stratum}: {line.what}" for line in self.regressions]
        verdict = f"**Regression**: {'; '.join(worse)}." if worse else "No regression."
        parts = [verdict, *self.notes]
        for method in dict.fromkeys(line.method for line in self.lines):
            parts += [f"### {method}", "\n".join(_table([line for line in self.lines if line.method == method]))]
        return "\n\n".join([*parts, _legend()])


def compare_runs(run: str | Path, baseline: str | Path) -> Comparison:
    """Compare a run with another on the pairs that both have.

    Parameters
    ----------
    run, baseline
        A finished run's folder, or its ``results.jsonl``.

    Raises
    ------
    InputError
        If one of them is no finished run, or they share no method and pair.
    """
    now, before = _read_rows(Path(run)), _read_rows(Path(baseline))
    common = [key for key in before if key in now]
    if not common:
        raise InputError(f"{run} and {baseline} have no pair and method in common")
    timed = [{key: Timed(row.place, row.cpu_s) for key, row in rows.items()} for rows in (now, before)]
    machines = [machine_of(Path(path)) for path in (run, baseline)]
    speed = compare_speed(timed[0], timed[1], machines)
    of_machine = [] if machines[0] and machines[0] == machines[1] else _timed_out(common, now, before)
    lines: list[ComparisonLine] = []
    for method in sorted({method for method, _ in common}):
        for stratum in STRATA:
            keys = [key for key in common if key[0] == method and stratum in before[key].strata]
            if keys:
                lines += _lines(method, stratum, keys, (now, before), of_machine)
        if method in speed.ratios:
            lines.append(_speed_line(method, speed.ratios[method]))
    notes = [
        f"{len(rows) - len(common)} of {len(rows)} rows of the {name} have no partner and are left out."
        for name, rows in (("run", now), ("baseline", before))
        if len(rows) > len(common)
    ]
    if of_machine:
        notes.append(
            f"Timeouts of the run alone, {len(of_machine)} rows, are not counted as worse: the machines differ, or are "
            "unknown."
        )
    return Comparison(lines, [*notes, *([speed.note] if speed.note else [])])


def _timed_out(common: Sequence[Key], now: Rows, before: Rows) -> list[Key]:
    """Return the rows that ran out of time in the new run only."""
    return [key for key in common if now[key].outcome == TIMEOUT != before[key].outcome]


def _read_rows(path: Path) -> Rows:
    """Read the compared columns of a run, by method and pair."""
    file = path / RESULTS if path.is_dir() else path
    if not file.is_file() or (path.is_dir() and not (path / SUMMARY).is_file()):
        raise InputError(f"{path}: no finished run; name its folder or its {RESULTS}")
    kept = {}
    for row in read_row_file(file, has_progress=True):
        try:
            kept[row["method"], row["pair_id"]] = _compared(row)
        except (KeyError, TypeError) as error:
            raise InputError(f"{file}: not the rows of a run: {error}") from error
    return kept


def _compared(row: Mapping[str, Any]) -> Compared:
    e_px = float(row["errors"]["e_px"]) if row["errors"] else math.inf
    cpu_s = (row.get("seconds") or {}).get("cpu")
    return Compared(row["place"], strata_of(row), row["outcome"], e_px, cpu_s)


def _lines(
    method: str, stratum: str, keys: Sequence[Key], runs: tuple[Rows, Rows], of_machine: Sequence[Key]
) -> Iterator[ComparisonLine]:
    """Compare a method on a stratum; rows in `of_machine` are shown, and make nothing worse."""
    now, before = ([rows[key] for key in keys] for rows in runs)
    places, n, counted = [row.place for row in before], len(before), [key not in of_machine for key in keys]
    for what, outcomes, better in (*RIGHT_ANSWER.get(stratum, ACCEPTED), *RATES):
        hits = [[float(row.outcome in outcomes) for row in rows] for rows in (now, before)]
        mean, low, high = clustered_difference(hits[0], hits[1], places)
        counts = [int(sum(values)) for values in hits]
        shown = [f"{count} ({100 * count / n:.1f} %)" for count in counts]
        difference = f"{100 * mean:+.1f} ({100 * low:+.1f} to {100 * high:+.1f})"
        change = sum(a - b for a, b, counts_too in zip(*hits, counted, strict=True) if counts_too)
        is_worse = better * change < 0
        yield ComparisonLine(method, stratum, n, what, shown[1], shown[0], difference, is_worse)
    if stratum != "unrelated" and (line := _error_line(method, stratum, now, before)):
        yield line


def _error_line(
    method: str, stratum: str, now: Sequence[Compared], before: Sequence[Compared]
) -> ComparisonLine | None:
    """Compare the errors of the pairs that both have right, with the interval of their mean log ratio."""
    both = [(a, b) for a, b in zip(now, before, strict=True) if a.outcome == b.outcome == "right-accepted"]
    if not both:
        return None
    new, old = (np.array([row.e_px for row in rows]) for rows in zip(*both, strict=True))
    medians = float(np.median(new)), float(np.median(old))
    logs = [np.log(np.maximum(errors, ERROR_TOLERANCE_PX)) for errors in (new, old)]  # smaller errors count as equal
    ratios = np.exp(clustered_difference(logs[0].tolist(), logs[1].tolist(), [row.place for row, _ in both]))
    mean, low, high = 100 * (ratios - 1)
    worse = medians[0] > medians[1] + max(ERROR_TOLERANCE * medians[1], ERROR_TOLERANCE_PX)
    difference = f"{mean:+.1f} % ({low:+.1f} to {high:+.1f})"
    what = "median error, cells"
    return ComparisonLine(method, stratum, len(both), what, f"{medians[1]:.3f}", f"{medians[0]:.3f}", difference, worse)


def _speed_line(method: str, speed: SpeedRatio) -> ComparisonLine:
    change, low, high = (100 * (ratio - 1) for ratio in (speed.ratio, speed.low, speed.high))
    difference = f"{change:+.1f} % ({low:+.1f} to {high:+.1f})"
    before, now = f"{speed.before:.3f}", f"{speed.now:.3f}"
    return ComparisonLine(method, "all", speed.n, "median CPU s", before, now, difference, speed.is_slower)


def _table(lines: Sequence[ComparisonLine]) -> Iterator[str]:
    yield "| pairs | n | | baseline | run | difference | |"
    yield "| --- | --- | --- | --- | --- | --- | --- |"
    for line in lines:
        mark = "**worse**" if line.is_regression else ""
        cells = [line.stratum, str(line.n), line.what, line.before, line.now, line.difference, mark]
        yield f"| {' | '.join(cells)} |"


def _legend() -> str:
    return (
        "Differences are in percent of the pairs, with the 95 % interval by bootstrap over places on the same pairs; "
        "of errors, the mean ratio where both are right; of times, the mean ratio. Worse: a single pair fewer that is "
        "right, or more that is wrong or failed (by a timeout only on one machine); a median error by more than "
        f"{100 * ERROR_TOLERANCE:g} % and {ERROR_TOLERANCE_PX:g} cells; a time by more than "
        f"{100 * SLOWER_AT_MOST:g} %, the interval above 0. "
        "Bent, identifiable and unidentifiable pairs are in the other strata too."
    )
