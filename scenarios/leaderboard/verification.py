"""Verification of a submission: its methods put to its pairs again, and the rows that differ."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rectmerge import methods
from rectmerge.errors import InputError
from scenarios.bench.contenders import Contender
from scenarios.bench.external_program import Program
from scenarios.bench.plan import RunPlan
from scenarios.bench.run import IN_THIS_PROCESS, SILENT, Execution, RunCallbacks, read_rows, run
from scenarios.dataset.dataset_id import SHOWN_DIGITS
from scenarios.dataset.reader import open_dataset
from scenarios.execution.executors import describe_machine
from scenarios.leaderboard.submission import (
    MethodRecord,
    Submission,
    Verification,
    cpu_seconds,
    data_set_record,
    machine_record,
)
from scenarios.scoring.row import Row

SAME = ("related", "stratum", "place", "outcome", "checked_outcome", "verdict", "grades")
ERROR_WITHIN_PX = 0.05  # cells: processors round differently; `rectbench compare` takes smaller errors for equal
CONFIDENCE_WITHIN = 0.01  # hand, no data: the second digit
SHARE_WITHIN = 0.001  # of an error over the extent, and of an overlap


@dataclass(frozen=True, slots=True, kw_only=True)
class Repetition:
    """Rows of a submission done again: the lines of what differs, and the verified submission where nothing does."""

    differences: tuple[str, ...]
    rows: int
    verified: Submission | None


def plan_repetition(
    submission: Submission, path: Path, dataset: Path, *, commands: Sequence[str] = (), every: int = 1
) -> RunPlan:
    """Plan a submission's run again.

    Parameters
    ----------
    submission, path
        As it was read, and from where.
    dataset
        The folder of its data set.
    commands
        Command lines of its programs, as in `Program`, by their labels: what a stranger's file says is never run.
    every
        Take every so many-th pair only.

    Raises
    ------
    InputError
        If the data set is another one, a method cannot be made here, or a program has no command line.
    """
    here = data_set_record(dataset)
    if here.id != submission.data_set.id:
        ids = f"{here.id[:SHOWN_DIGITS]}, {path.name} is of {submission.data_set.id[:SHOWN_DIGITS]}"
        raise InputError(f"{dataset}: is another data set: its id is {ids} ({submission.data_set.name})")
    wanted = {row["pair_id"] for row in submission.rows}
    sources = [source for source in open_dataset(dataset) if wanted.intersection(source.pair_ids)]
    if lost := wanted - {pair_id for source in sources for pair_id in source.pair_ids}:
        raise InputError(f"{path}: rows: {min(lost)!r} is no pair of {dataset}")
    programs = {program.label: program for program in map(Program.parse, commands)}
    contenders = [_contender(method, programs, path) for method in submission.methods]
    return RunPlan(
        suite=submission.data_set.name, sources=sources[::every], contenders=contenders, seed=submission.seed
    )


def repeat(
    submission: Submission, plan: RunPlan, *, execution: Execution = IN_THIS_PROCESS, callbacks: RunCallbacks = SILENT
) -> Repetition:
    """Run a plan of `plan_repetition` and compare its rows with those of the submission.

    Times are not compared: they are the machine's.
    """
    limited = replace(execution, limits=submission.limits)
    with tempfile.TemporaryDirectory(prefix="rectbench-") as folder:
        run(plan, folder, execution=limited, callbacks=callbacks)
        rows = read_rows(folder)
    handed_in = {(row["method"], row["pair_id"]): row for row in submission.as_rows()}
    due = {key: row for row in rows if (key := (row["method"], row["pair_id"])) in handed_in}
    differing = [line for key, row in sorted(due.items()) if (line := difference(handed_in[key], row))]
    if differing:
        return Repetition(differences=tuple(differing), rows=len(due), verified=None)
    verification = Verification(
        rows=len(due),
        of=len(submission.rows),
        machine=machine_record(describe_machine()),
        seconds=cpu_seconds(rows),
    )
    verified = replace(submission, status="verified", verification=verification)
    return Repetition(differences=(), rows=len(due), verified=verified)


def difference(handed_in: Row, now: Row) -> str:
    """Return how a row differs from the one that was handed in; empty if it does not. What that lacks is no difference.

    Numbers may differ a little between processors: an error by 0.05 cells, a confidence by 0.01.
    """
    changes = list(_changes(handed_in, now))
    return f"{now['method']}, {now['pair_id']}: {'; '.join(changes)}" if changes else ""


def _changes(handed_in: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    for key in SAME:
        if handed_in[key] is not None and handed_in[key] != now[key]:
            yield f"{key} was {handed_in[key]}, is {now[key]}"
    errors, relative = ([(row["errors"] or {}).get(key) for row in (handed_in, now)] for key in ("e_px", "e_over_l"))
    for key, (was, found), within in (
        ("e_px", errors, ERROR_WITHIN_PX),
        ("e_over_l", relative, SHARE_WITHIN),
        ("overlap", (handed_in["overlap"], now["overlap"]), SHARE_WITHIN),
        ("confidence", (handed_in["confidence"], now["confidence"]), CONFIDENCE_WITHIN),
    ):
        if was is not None and (found is None or abs(was - found) > within):
            yield f"{key} was {was:.3f}, is {'unknown' if found is None else format(found, '.3f')}"


def _contender(record: MethodRecord, programs: Mapping[str, Program], path: Path) -> Contender:
    if record.label in programs:
        return Contender(label=record.label, method=programs[record.label], knows_scale=record.knows_scale)
    if record.method not in methods.available():
        raise InputError(
            f"{path}: methods: {record.method!r} is not installed here; "
            f"if it is a program, give its command line: --method-command '{record.label}=PROG {{a}} {{b}}'"
        )
    return Contender(
        label=record.label, method=methods.make_method(record.method, **record.set), knows_scale=record.knows_scale
    )
