"""A run: every contender put to every pair, and the folder that keeps what happened."""

from __future__ import annotations

import dataclasses
import functools
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, cast

from rectmerge.alignment import Method
from rectmerge.errors import InputError
from rectmerge.imagefile import replace_file
from rectmerge.resultfolder import plain, to_json
from scenarios.executors import Attempt, WorkerDiedError, completed, describe_machine
from scenarios.pairs import PairSource
from scenarios.rows import TIMEOUT_S, Contender, Row, failed_rows, rows_of_source
from scenarios.statistics import summarise

RUN_FILES = ("run.toml", "machine.json", "results.jsonl", "results.jsonl.part", "summary.json")


def run(
    sources: Sequence[PairSource],
    contenders: Sequence[Contender],
    out: str | Path,
    *,
    suite: str,
    seed: int = 0,
    executor: Executor | None = None,
    timeout_s: float = TIMEOUT_S,
    force: bool = False,
    about: Mapping[str, Any] | None = None,
    command: str = "",
    on_rows: Callable[[Sequence[Row]], None] | None = None,
) -> dict[str, Any]:
    """Put every contender to every pair and write the run's folder.

    Parameters
    ----------
    sources
        Where the pairs come from.
    contenders
        Methods under different labels.
    out
        The run's folder: ``run.toml``, ``machine.json``, ``results.jsonl`` (``results.jsonl.part`` while it grows),
        ``summary.json``.
    suite
        The name of what is run.
    seed
        Of every answer.
    executor
        Where the work is done; None is this process, the one place where a method that kills its process ends the run.
    timeout_s
        For one answer, wall time.
    force
        Clear an earlier run's files first. A run cannot be resumed.
    about
        What else ``run.toml`` keeps: the scenarios as they were resolved.
    command
        What was typed, for the record.
    on_rows
        Told of the rows as they come.

    Returns
    -------
    dict
        The content of ``summary.json``.

    Raises
    ------
    InputError
        If the folder holds a run and `force` is off, or two contenders have one label.
    """
    if len({one.label for one in contenders}) != len(contenders):
        raise InputError(f"labels must differ, got {', '.join(one.label for one in contenders)}")
    settings = {"suite": suite, "seed": seed, "timeout_s": timeout_s, "pairs": sum(len(s.pair_ids) for s in sources)}
    methods = [{"label": one.label, "method": one.method.name, "set": _fields(one.method)} for one in contenders]
    resolved = _toml({**settings, **(about or {}), "methods": methods})
    folder = cleared_folder(out, RUN_FILES, force=force)
    replace_file(folder / "run.toml", resolved.encode())
    write_json(folder / "machine.json", describe_machine(command))
    work = functools.partial(rows_of_source, suite=suite, contenders=contenders, seed=seed, timeout_s=timeout_s)
    rows: list[Row] = []
    part = folder / "results.jsonl.part"
    with part.open("w", encoding="utf-8") as file:
        for new in _rows_as_they_come(executor, work, sources, contenders):
            file.writelines(json.dumps(plain(row), allow_nan=False) + "\n" for row in new)
            file.flush()
            rows += new
            if on_rows:
                on_rows(new)
    part.replace(folder / "results.jsonl")
    summary = {"schema": "rectmerge.summary/1", "suite": suite, "rows": len(rows), "methods": summarise(rows)}
    write_json(folder / "summary.json", summary)
    return summary


def read_rows(folder: str | Path) -> list[Row]:
    """Read the rows of a finished run.

    Raises
    ------
    InputError
        If the folder holds no finished run.
    """
    path = Path(folder) / "results.jsonl"
    if not path.is_file():
        raise InputError(f"{folder}: no finished run: there is no results.jsonl in it")
    with path.open(encoding="utf-8") as lines:
        return [json.loads(line) for line in lines]


def cleared_folder(out: str | Path, names: Sequence[str], *, force: bool) -> Path:
    """Make a folder for results; files of these names or patterns in it are refused, or cleared with `force`."""
    folder = Path(out)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; results go into a folder")
    stale = [path for name in names for path in sorted(folder.glob(name)) if path.is_file()]
    if stale and not force:
        raise InputError(f"{folder}: holds earlier results ({stale[0].name}); --force clears them")
    try:
        for path in stale:
            path.unlink()
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror}") from error
    return folder


def write_json(path: Path, content: Any) -> None:
    """Write JSON so that its name never shows half of it."""
    replace_file(path, f"{to_json(content)}\n".encode())


def _rows_as_they_come(
    executor: Executor | None,
    work: functools.partial[list[Row]],
    sources: Sequence[PairSource],
    contenders: Sequence[Contender],
) -> Iterator[list[Row]]:
    for source, future in completed(executor, work, sources):
        try:
            yield future.result()
        except WorkerDiedError as death:
            yield _one_by_one(executor, work, source, contenders, death)


def _one_by_one(
    executor: Executor | None,
    work: functools.partial[list[Row]],
    source: PairSource,
    contenders: Sequence[Contender],
    death: WorkerDiedError,
) -> list[Row]:
    """Find out whose death it was: put each contender to the source alone."""
    rows: list[Row] = []
    for one in contenders:
        try:
            if executor is None or len(contenders) == 1:
                raise death
            rows += executor.submit(work, source, contenders=[one]).result()
        except WorkerDiedError as error:
            failure: Attempt[Any] = Attempt(
                failure="out-of-memory" if error.out_of_memory else "error", reason=str(error)
            )
            rows += failed_rows(source, source.pair_ids, [one], failure, suite=work.keywords["suite"])
    return rows


def _fields(method: Method) -> dict[str, Any]:
    """Every field of a method, as it was set or by default."""
    return {f.name: getattr(method, f.name) for f in dataclasses.fields(cast(Any, method)) if f.name != "name"}


def _toml(content: dict[str, Any]) -> str:
    try:
        import tomli_w
    except ImportError:
        raise InputError("a run is recorded with tomli-w: pip install 'rectmerge[bench]'") from None
    return tomli_w.dumps(_without_none(plain(content)))


def _without_none(value: Any) -> Any:
    """Leave None out, for which TOML has no word."""
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value if item is not None] if isinstance(value, list) else value
