"""The task of a run: a source's pairs, made and put to the contenders, and the rows that come of it."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from scenarios.bench.asking import ask_within
from scenarios.bench.contenders import Contender
from scenarios.bench.rows import score_answer_and_bend
from scenarios.bench.task_ids import TaskKey
from scenarios.dataset.packing import Package, failed_source, make_within
from scenarios.execution.attempt import Attempt, attempt
from scenarios.execution.limits import MAKING, Limits
from scenarios.pairs.pair import MapPair, PairSource
from scenarios.scoring.row import Row, empty_row
from scenarios.scoring.score import stratum_of


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSettings:
    """Settings that all tasks of a run share.

    Parameters
    ----------
    contenders
        Methods under different labels.
    suite
        Name of the suite or the data set.
    seed
        Seed of every answer.
    limits
        Limits of one answer.
    making
        Limits of one mission and its pairs.
    """

    contenders: Sequence[Contender]
    suite: str
    seed: int = 0
    limits: Limits = field(default_factory=Limits)
    making: Limits = MAKING


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """A source, and which of its pairs and contenders are due.

    Parameters
    ----------
    source
        The source of the pairs.
    due
        The id of each row that is due; other rows are left alone.
    settings
        Settings of the run.
    first
        The number of the source's first pair in the run's data set; None where pairs are not kept.
    """

    source: PairSource
    due: Mapping[TaskKey, str]
    settings: RunSettings
    first: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class TaskResult:
    """Rows of a task, and its pairs where they are kept in a data set."""

    rows: list[Row]
    package: Package | None = None


def run_task(task: Task) -> TaskResult:
    """Make the pairs of a source; put every contender to each of them, and score the answers.

    A pair that cannot be made or kept is an error row of every contender: it stays in the denominator.
    """
    made = make_within(task.settings.making, task.source, task.first)
    rows: dict[TaskKey, Row] = {}
    for pair in made.pairs:
        for contender in task.settings.contenders:
            if (key := (pair.pair_id, contender.label)) in task.due:
                rows[key] = _answer_row(task, pair, contender)
    for key in [key for key in task.due if key not in rows]:
        reason = made.package.failed.get(key[0], "")
        rows[key] = _failed_row(task, key, Attempt(failure=made.failure, reason=reason, log=made.log))
    return TaskResult(rows=list(rows.values()), package=None if task.first is None else made.package)


def failed_task(task: Task, failure: Attempt[Any]) -> TaskResult:
    """Return the error rows of a task none of whose pairs could be made."""
    package = None if task.first is None else failed_source(task.source, failure).package
    return TaskResult(rows=[_failed_row(task, key, failure) for key in task.due], package=package)


def _answer_row(task: Task, pair: MapPair, contender: Contender) -> Row:
    """Put a contender to a pair; an answer that cannot be scored is an error row."""
    key = (pair.pair_id, contender.label)
    answer = ask_within(pair, contender, seed=task.settings.seed, limits=task.settings.limits)
    scored = attempt(functools.partial(score_answer_and_bend, pair, contender, answer))
    row = scored.value or _failed_row(task, key, scored)
    return {**row, "task_id": task.due[key]}


def _failed_row(task: Task, key: TaskKey, failure: Attempt[Any]) -> Row:
    """Return a row without an answer, in the stratum that its pair was meant for."""
    pair_id, label = key
    related = task.source.is_related(pair_id)
    return empty_row(
        task_id=task.due[key],
        pair_id=pair_id,
        suite=task.settings.suite,
        place=task.source.source_id,
        method=label,
        related=related,
        stratum=stratum_of(related, None),
        outcome=failure.failure or "error",
        reason=f"the pair could not be made or scored: {failure.reason}",
        log=failure.log,
    )
