"""A run: every contender put to every pair, and the folder that keeps what happened."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from pathlib import Path
from typing import Any, cast

from rectmerge.alignment import Method
from rectmerge.errors import InputError
from rectmerge.io.image_file import replace_file
from rectmerge.results.folder import plain
from scenarios.bench.contenders import Contender
from scenarios.bench.resume import MACHINE, RECORD, RESULTS, SUMMARY, Results, results_in, rows_in
from scenarios.bench.task_ids import run_id, task_ids
from scenarios.bench.tasks import RunSettings, Task, TaskResult, failed_task, run_task
from scenarios.dataset.generate import SCHEMA
from scenarios.dataset.writer import DataSetWriter, finished_info
from scenarios.execution.attempt import Attempt
from scenarios.execution.executors import IN_FLIGHT, WorkerDiedError, completed, describe_machine
from scenarios.execution.files import write_json
from scenarios.execution.limits import Limits
from scenarios.pairs.pair import PairSource
from scenarios.scoring.row import Row
from scenarios.scoring.score import Outcome
from scenarios.scoring.summary import APART, summarise

DATASET = "dataset"  # the folder of a suite's pairs, in the run's


def run(
    sources: Sequence[PairSource],
    contenders: Sequence[Contender],
    out: str | Path,
    *,
    suite: str,
    seed: int = 0,
    executor: Executor | None = None,
    in_flight: int = IN_FLIGHT,
    limits: Limits | None = None,
    force: bool = False,
    about: Mapping[str, Any] | None = None,
    command: str = "",
    on_start: Callable[[int], None] = lambda done: None,
    on_rows: Callable[[Sequence[Row]], None] = lambda rows: None,
    dataset: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Put every contender to every pair and write the run's folder, or go on with the run that it holds.

    Parameters
    ----------
    sources
        Where the pairs come from.
    contenders
        Methods under different labels.
    out
        The run's folder: ``run.toml``, ``machine.json``, ``results.jsonl``, which grows by whole lines in the order in
        which the work ends, and ``summary.json`` once it is complete.
    suite
        The name of what is run.
    seed
        Of every answer.
    executor
        Where pairs are made; None is this process, the one place where a pair whose making kills the process ends the
        run. Answers are given in children of the process that makes the pair.
    in_flight
        How many sources are handed to the executor at a time.
    limits
        What one answer may take.
    force
        Clear an earlier run first.
    about
        What else ``run.toml`` keeps: the scenarios as they were resolved.
    command
        What was typed, for the record.
    on_start
        Told how many rows the folder holds already.
    on_rows
        Told of the rows as they come.
    dataset
        What the card of a data set says of it, `title` and `description`: the pairs are kept in ``dataset/`` below.

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
    if len({one.label for one in contenders}) != len(contenders):
        raise InputError(f"labels must differ, got {', '.join(one.label for one in contenders)}")
    limits = limits or Limits()
    this_run, pairs = run_id(sources, contenders, suite=suite, seed=seed)
    methods = [
        {"label": one.label, "method": one.method.name, "knows_scale": one.knows_scale, "set": _fields(one.method)}
        for one in contenders
    ]
    settings = {"run_id": this_run, "suite": suite, "seed": seed, **dataclasses.asdict(limits), "pairs": pairs}
    record = _toml({**settings, **(about or {}), "methods": methods})
    shared = RunSettings(contenders=contenders, suite=suite, seed=seed, limits=limits)
    with results_in(out, record, force=force) as results:
        on_start(results.count)
        unkept = dataset is not None and (force or not finished_info(results.folder / DATASET))
        if results.count < pairs * len(contenders) or unkept:
            (results.folder / SUMMARY).unlink(missing_ok=True)
            replace_file(results.folder / RECORD, record.encode())
            write_json(results.folder / MACHINE, describe_machine(command))
            identity = {"schema": SCHEMA, "suite": suite, "seed": 0, "pairs": None, "run_id": this_run}
            kept = DataSetWriter(results.folder / DATASET, identity, force=force) if unkept else nullcontext()
            with kept as writer:
                for done in _as_they_come(executor, _due(results, sources, shared, writer), in_flight):
                    if writer and done.package and done.package.source_id not in writer.done:
                        writer.write(done.package)
                    results.add(done.rows)
                    on_rows(done.rows)
                if writer and dataset and next(writer.folder.glob("*/maps/*"), None):
                    writer.finish({**dataset, "versions": describe_machine()["packages"]})
        summary = _summary(suite, contenders, results.folder / RESULTS)
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
    return list(rows_in(Path(folder) / RESULTS))


def _due(
    results: Results, sources: Sequence[PairSource], settings: RunSettings, writer: DataSetWriter | None
) -> Iterator[Task]:
    """Yield the tasks that have no rows yet, or whose pairs are not kept yet."""
    first = 0
    for source in sources:
        ids = task_ids(source, settings.contenders, seed=settings.seed)
        due = {key: task_id for key, task_id in ids.items() if not results.holds(task_id)}
        if due or (writer and source.source_id not in writer.done):
            yield Task(source=source, due=due, settings=settings, first=first if writer else None)
        first += len(source.pair_ids)


def _as_they_come(executor: Executor | None, tasks: Iterator[Task], in_flight: int) -> Iterator[TaskResult]:
    for task, future in completed(executor, run_task, tasks, in_flight=in_flight):
        try:
            yield future.result()
        except WorkerDiedError as death:
            outcome: Outcome = "out-of-memory" if death.out_of_memory else "error"
            failure: Attempt[Any] = Attempt(failure=outcome, reason=str(death))
            yield failed_task(task, failure)


def _summary(suite: str, contenders: Sequence[Contender], path: Path) -> dict[str, Any]:
    strata_of = summarise(rows_in(path))
    methods = {one.label: strata_of[one.label] for one in contenders}
    rows = sum(part["n"] for strata in methods.values() for name, part in strata.items() if name not in APART)
    return {"schema": "rectmerge.summary/1", "suite": suite, "rows": rows, "methods": methods}


def _fields(method: Method) -> dict[str, Any]:
    """Every field of a method, as it was set or by default."""
    return {f.name: getattr(method, f.name) for f in dataclasses.fields(cast(Any, method)) if f.name != "name"}


def _toml(content: dict[str, Any]) -> str:
    import tomli_w

    return tomli_w.dumps(_without_none(plain(content)))


def _without_none(value: Any) -> Any:
    """Leave None out, for which TOML has no word."""
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value if item is not None] if isinstance(value, list) else value
