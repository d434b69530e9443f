"""The work of a run: a source's pairs are made, kept where a data set is wanted, and put to the contenders."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from scenarios.bench.rows import Contender, Row, Task, answer_within, blank_row, row_of
from scenarios.dataset.packing import Package, lost, make_within
from scenarios.execution.attempt import Attempt, attempt
from scenarios.execution.limits import MAKING, Limits
from scenarios.pairs.pair import MapPair, PairSource
from scenarios.scoring.score import stratum_of


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
    making
        What one mission and its pairs may take.
    """

    contenders: Sequence[Contender]
    suite: str
    seed: int = 0
    limits: Limits = field(default_factory=Limits)
    making: Limits = MAKING


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
    made = make_within(work.terms.making, work.source, work.first)
    rows = [row for pair in made.pairs for row in _answers(work, pair)]
    told = {row["task_id"] for row in rows}
    for task, task_id in work.tasks.items():
        if task_id not in told:
            why: Attempt[Any] = Attempt(failure=made.failure, reason=made.package.failed.get(task[0], ""), log=made.log)
            rows.append(_failed_row(work, task, why))
    return Done(rows=rows, package=None if work.first is None else made.package)


def failed(work: Work, failure: Attempt[Any]) -> Done:
    """Return what there is of a work none of whose pairs could be made: rows, as of the pairs that were meant."""
    package = None if work.first is None else lost(work.source, failure).package
    return Done(rows=[_failed_row(work, task, failure) for task in work.tasks], package=package)


def _answers(work: Work, pair: MapPair) -> Iterator[Row]:
    """Put to a pair the contenders that have not answered it yet."""
    for one in work.terms.contenders:
        task = (pair.pair_id, one.label)
        if task in work.tasks:
            given = answer_within(pair, one, seed=work.terms.seed, limits=work.terms.limits)
            scored = attempt(functools.partial(row_of, pair, one, given))
            row = scored.value or _failed_row(work, task, scored)
            yield {**row, "task_id": work.tasks[task]}


def _failed_row(work: Work, task: Task, failure: Attempt[Any]) -> Row:
    """Lay out a row without an answer, in the stratum that its pair was meant for."""
    pair_id, label = task
    related = work.source.is_related(pair_id)
    return {
        **blank_row(pair_id, work.terms.suite, work.source.source_id, label),
        "task_id": work.tasks[task],
        "related": related,
        "stratum": stratum_of(related, None),
        "outcome": failure.failure,
        "reason": f"the pair could not be made or scored: {failure.reason}",
        "log": failure.log,
    }
