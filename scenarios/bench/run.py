"""A run: every contender put to every pair, and the folder that keeps the rows."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from rectmerge.io.atomic_file import replace_file
from rectmerge.io.json_text import plain
from rectmerge.method_fields import field_values
from scenarios.bench.contenders import Contender
from scenarios.bench.plan import RunPlan
from scenarios.bench.resume import MACHINE, RECORD, RESULTS, SUMMARY, Results, open_results, read_row_file
from scenarios.bench.task_ids import run_id, task_ids
from scenarios.bench.tasks import RunSettings, Task, TaskResult, failed_task, run_task
from scenarios.dataset.generate import SCHEMA
from scenarios.dataset.writer import DataSetWriter, finished_info
from scenarios.execution.attempt import Attempt
from scenarios.execution.executors import IN_FLIGHT, WorkerDiedError, completed, describe_machine
from scenarios.execution.files import write_json
from scenarios.execution.limits import Limits
from scenarios.scoring.row import Row
from scenarios.scoring.score import Outcome
from scenarios.scoring.summary import APART, summarise

DATASET = "dataset"  # the folder of a suite's pairs, in the run's


@dataclass(frozen=True, slots=True, kw_only=True)
class Execution:
    """Place and limits of the work.

    Parameters
    ----------
    executor
        Where pairs are made; None is this process, the one place where a pair whose making kills the process ends the
        run. Answers are given in children of the process that makes the pair.
    in_flight
        Number of tasks that the executor holds at a time.
    limits
        Limits of one answer.
    """

    executor: Executor | None = None
    in_flight: int = IN_FLIGHT
    limits: Limits = field(default_factory=Limits)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunCallbacks:
    """Callbacks of a run: `on_start` gets the number of rows in the folder, `on_rows` new rows as they come."""

    on_start: Callable[[int], None] = lambda count: None
    on_rows: Callable[[Sequence[Row]], None] = lambda rows: None


IN_THIS_PROCESS, SILENT = Execution(), RunCallbacks()


def run(
    plan: RunPlan,
    out: str | Path,
    *,
    execution: Execution = IN_THIS_PROCESS,
    callbacks: RunCallbacks = SILENT,
    force: bool = False,
    command: str = "",
) -> dict[str, Any]:
    """Put every contender to every pair and write the run's folder, or go on with the run that it holds.

    Parameters
    ----------
    plan
        Pairs and contenders.
    out
        The run's folder: ``run.toml``, ``machine.json``, ``results.jsonl``, which grows by whole lines in the order in
        which tasks end, and ``summary.json`` once it is complete.
    execution
        Place and limits of the work.
    callbacks
        Called as rows come.
    force
        Clear an earlier run first.
    command
        The command line, for ``machine.json``.

    Returns
    -------
    dict
        The content of ``summary.json``.

    Raises
    ------
    InputError
        If the folder holds a run of something else and `force` is off, another process writes into it, or two
        contenders have one label.
    """
    labels = [contender.label for contender in plan.contenders]
    if len(set(labels)) != len(labels):
        raise InputError(f"labels must differ, got {', '.join(labels)}")
    this_run, pairs = run_id(plan.sources, plan.contenders, suite=plan.suite, seed=plan.seed)
    record = _record(plan, execution.limits, this_run, pairs)
    with open_results(out, record, force=force) as results:
        callbacks.on_start(results.count)
        keeps_pairs = plan.card is not None and (force or not finished_info(results.folder / DATASET))
        if results.count < pairs * len(labels) or keeps_pairs:
            (results.folder / SUMMARY).unlink(missing_ok=True)
            replace_file(results.folder / RECORD, record.encode())
            write_json(results.folder / MACHINE, describe_machine(command))
            identity = {"schema": SCHEMA, "suite": plan.suite, "seed": 0, "pairs": None, "run_id": this_run}
            kept = DataSetWriter(results.folder / DATASET, identity, force=force) if keeps_pairs else nullcontext()
            with kept as writer:
                _run_tasks(plan, execution, results, writer, callbacks.on_rows)
        summary = _summary(plan, results.folder / RESULTS)
        write_json(results.folder / SUMMARY, summary)
    return summary


def read_rows(folder: str | Path) -> list[Row]:
    """Read the rows of a finished run.

    Raises
    ------
    InputError
        If the folder holds no finished run.
    """
    for name in (RESULTS, SUMMARY):
        if not (Path(folder) / name).is_file():
            raise InputError(f"{folder}: no finished run: there is no {name} in it")
    return list(read_row_file(Path(folder) / RESULTS, has_progress=True))


def _run_tasks(
    plan: RunPlan,
    execution: Execution,
    results: Results,
    writer: DataSetWriter | None,
    on_rows: Callable[[Sequence[Row]], None],
) -> None:
    """Run the tasks that are due and write their rows, and their pairs where there is a writer."""
    for result in _results_of(_due_tasks(plan, execution.limits, results, writer), execution):
        if writer and result.package and result.package.source_id not in writer.done:
            writer.write(result.package)
        results.add(result.rows)
        on_rows(result.rows)
    if writer and plan.card and next(writer.folder.glob("*/maps/*"), None):
        writer.finish({**plan.card, "versions": describe_machine()["packages"]})


def _due_tasks(plan: RunPlan, limits: Limits, results: Results, writer: DataSetWriter | None) -> Iterator[Task]:
    """Yield the tasks whose rows are not written, or whose pairs are not kept yet."""
    settings = RunSettings(contenders=plan.contenders, suite=plan.suite, seed=plan.seed, limits=limits)
    first = 0
    for source in plan.sources:
        ids = task_ids(source, plan.contenders, seed=plan.seed)
        due = {key: task_id for key, task_id in ids.items() if not results.holds(task_id)}
        if due or (writer and source.source_id not in writer.done):
            yield Task(source=source, due=due, settings=settings, first=first if writer else None)
        first += len(source.pair_ids)


def _results_of(tasks: Iterator[Task], execution: Execution) -> Iterator[TaskResult]:
    """Yield the results of tasks as they end; a task whose worker died is a failure of each of its rows."""
    for task, future in completed(execution.executor, run_task, tasks, in_flight=execution.in_flight):
        try:
            yield future.result()
        except WorkerDiedError as death:
            outcome: Outcome = "out-of-memory" if death.out_of_memory else "error"
            failure: Attempt[Any] = Attempt(failure=outcome, reason=str(death))
            yield failed_task(task, failure)


def _record(plan: RunPlan, limits: Limits, this_run: str, pairs: int) -> str:
    """Return the content of ``run.toml``."""
    settings = {"run_id": this_run, "suite": plan.suite, "seed": plan.seed, **dataclasses.asdict(limits)}
    methods = [_contender_record(contender) for contender in plan.contenders]
    return _toml({**settings, "pairs": pairs, **plan.about, "methods": methods})


def _contender_record(contender: Contender) -> dict[str, Any]:
    """Return a contender's table in ``run.toml``: every field of its method, set or by default."""
    method = contender.method
    labels = {"label": contender.label, "method": method.name, "knows_scale": contender.knows_scale}
    return labels | {"set": field_values(method)}


def _summary(plan: RunPlan, path: Path) -> dict[str, Any]:
    """Return the content of ``summary.json``."""
    by_method = summarise(read_row_file(path))
    methods = {contender.label: by_method[contender.label] for contender in plan.contenders}
    rows = sum(part["n"] for strata in methods.values() for name, part in strata.items() if name not in APART)
    return {"schema": "rectmerge.summary/1", "suite": plan.suite, "rows": rows, "methods": methods}


def _toml(content: dict[str, Any]) -> str:
    """Return plain data as TOML."""
    import tomli_w

    return tomli_w.dumps(_without_none(plain(content)))


def _without_none(value: Any) -> Any:
    """Drop None, which TOML cannot express."""
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value if item is not None] if isinstance(value, list) else value
