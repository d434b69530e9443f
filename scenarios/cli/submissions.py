"""Command `rectbench submit`, and the verification of what it writes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.errors import InputError
from scenarios.execution.terminal import progress, row_callback


def submit(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A finished run's folder.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.json", help="The submission.")],
    force: Annotated[bool, typer.Option("--force", help="Replace an earlier submission.")] = False,
) -> None:
    """Write a finished run as one file to hand in: versions, hardware, seconds, hashes, and the score of every pair.

    It is self-reported until `rectbench verify FILE.json --data-set DATASET` has done it again. It holds no maps and no
    names of folders. `rectbench leaderboard --add FILE.json` shows it beside the others.
    """
    from scenarios.execution.files import write_json
    from scenarios.leaderboard.submission import submission_of

    _refuse_existing(output, force=force)
    submission = submission_of(run)
    write_json(output, submission.to_json_dict())
    size = f"{len(submission.rows)} rows, {output.stat().st_size / 1e6:.1f} MB"
    typer.echo(f"written: {output}, {submission.status}, {size}, data set {submission.data_set.id}")


def verify_submission(
    path: Path,
    dataset: Path | None,
    output: Path | None,
    *,
    commands: Sequence[str],
    every: int,
    workers: int,
    force: bool,
) -> None:
    """Do a submission's run again, print the rows that differ, and write it as verified where none does."""
    from scenarios.bench.run import Execution, RunCallbacks
    from scenarios.execution.executors import workplace
    from scenarios.execution.files import require_place, write_json
    from scenarios.leaderboard.submission import read_submission
    from scenarios.leaderboard.verification import plan_repetition, repeat

    if dataset is None:
        raise InputError(f"{path}: to verify a submission, name its data set with --data-set DATASET")
    if output is not None:
        _refuse_existing(output, force=force)
        require_place(output)
    submission = read_submission(path)
    plan = plan_repetition(submission, path, dataset, commands=commands, every=every)
    with progress(plan.row_count) as advance, workplace(workers, None) as (executor, in_flight):
        done = repeat(
            submission,
            plan,
            execution=Execution(executor=executor, in_flight=in_flight),
            callbacks=RunCallbacks(on_rows=row_callback(advance)),
        )
    for line in done.differences:
        typer.echo(line)
    differing = len(done.differences) or "none"
    typer.echo(f"{done.rows} of {len(submission.rows)} rows done again: {differing} of them differ")
    if done.verified is None:
        raise typer.Exit(console.NO)
    if output is not None:
        write_json(output, done.verified.to_json_dict())
        typer.echo(f"written: {output}, {done.verified.standing}")


def _refuse_existing(output: Path, *, force: bool) -> None:
    if output.exists() and not force:
        raise InputError(f"{output}: is there already; --force replaces it")
