"""The work of a run: a source's pairs are made, kept where a data set is wanted, and put to the contenders."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from scenarios.attempts import Attempt, attempt
from scenarios.limits import Limits
from scenarios.packing import Explorer, Package, pack_pairs
from scenarios.pairs import MapPair, PairSource
from scenarios.rows import Contender, Row, Task, answer_within, blank_row, row_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Terms:
    """What all tasks of a run share.

    Parameters
    ----------
    contenders
        Methods under different labels.
    suite
        The name of what is run.
    seed
        Of every answer.
    limits
        What one answer may take.
    """

    contenders: Sequence[Contender]
    suite: str
    seed: int = 0
    limits: Limits = field(default_factory=Limits)


@dataclass(frozen=True, slots=True, kw_only=True)
class Work:
    """A source, and the tasks on its pairs that are to be done, with their ids; others are left alone.

    Where its pairs are to be kept in a data set, `first` is the number of its first pair there.
    """

    source: PairSource
    tasks: Mapping[Task, str]
    terms: Terms
    first: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Done:
    """What came of a work: rows, and its pairs where they are to be kept."""

    rows: list[Row]
    package: Package | None = None


def do(work: Work) -> Done:
    """Make the pairs of a source and put the contenders to each of them.

    A pair that cannot be made, or not be kept, is an error row of every contender: it stays in the denominator.
    """
    rows: list[Row] = []
    package = None if work.first is None else Package(source_id=work.source.source_id)
    tried = attempt(functools.partial(_make, work, rows, package))
    why = tried.reason or "its source ended without it"
    lost: Attempt[Any] = Attempt(failure=tried.failure or "error", reason=why, log=tried.log)
    told = {row["task_id"] for row in rows}
    rows += [row for row in failed(work, lost).rows if row["task_id"] not in told]
    if package is not None:
        made = {row["pair_id"] for row in package.rows}
        package.failed.update({pair_id: why for pair_id in work.source.pair_ids if pair_id not in made})
    return Done(rows=rows, package=package)


def failed(work: Work, failure: Attempt[Any]) -> Done:
    """Return what there is of a work none of whose pairs could be made: rows, as of pairs that had to be merged."""
    package = None
    if work.first is not None:
        lost = dict.fromkeys(work.source.pair_ids, failure.reason)
        package = Package(source_id=work.source.source_id, failed=lost)
    return Done(rows=[_failed_row(work, task, failure) for task in work.tasks], package=package)


def _make(work: Work, rows: list[Row], package: Package | None) -> None:
    source, log = work.source, None
    if package is None or work.first is None:
        for _ in _answering(work, source.pairs(), rows):
            pass  # nobody keeps it
        return
    if isinstance(source, Explorer):
        log = source.mission()
    pairs = source.pairs() if log is None or not isinstance(source, Explorer) else source.pairs_of(log)
    pack_pairs(source, _answering(work, pairs, rows), work.first, package, log)


def _answering(work: Work, pairs: Iterable[MapPair], rows: list[Row]) -> Iterator[MapPair]:
    """Hand every pair on to be kept, and put to it the contenders that have not answered it yet."""
    for pair in pairs:
        yield pair
        for one in work.terms.contenders:
            task = (pair.pair_id, one.label)
            if task in work.tasks:
                given = answer_within(pair, one, seed=work.terms.seed, limits=work.terms.limits)
                scored = attempt(functools.partial(row_of, pair, one, given))
                row = scored.value or _failed_row(work, task, scored)
                rows.append({**row, "task_id": work.tasks[task]})
        if work.first is None and len(rows) == len(work.tasks):
            return


def _failed_row(work: Work, task: Task, failure: Attempt[Any]) -> Row:
    pair_id, label = task
    return {
        **blank_row(pair_id, work.terms.suite, work.source.source_id, label),
        "task_id": work.tasks[task],
        "stratum": "required",
        "outcome": failure.failure,
        "reason": f"the pair could not be made or scored: {failure.reason}",
        "log": failure.log,
    }
