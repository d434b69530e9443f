"""Command `rectbench fleets`: many maps at a time, joined and scored."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.errors import InputError
from scenarios.execution.terminal import progress


def fleets(
    datasets: Annotated[
        list[Path], typer.Argument(metavar="DATASET...", help="Data sets of fleets, made by `rectbench generate`.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the results.")],
    workers: Annotated[int | None, typer.Option(min=1, help="Worker processes; 1 works in this process.")] = None,
    cluster: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Work on this dask cluster, as in tcp://host:8786.")
    ] = None,
) -> None:
    """Join the maps of every fleet, by `align_many` and as peers do, and write what became of them.

    DIR gets results.jsonl, a line for each fleet as it is done, and README.md with the tables. Interrupted and called
    again it goes on where it was; name another folder after a change of the method.
    """
    from scenarios.execution.executors import workplace
    from scenarios.studies.fleets import fleets_of, study_fleets

    if workers and cluster:
        raise InputError("--workers and --cluster exclude each other")
    chosen = fleets_of(datasets)
    with workplace(workers or 1, cluster) as (executor, in_flight), progress(len(chosen)) as advance:
        try:
            study_fleets(
                chosen,
                output,
                executor=executor,
                in_flight=in_flight,
                command=f"rectbench {shlex.join(sys.argv[1:])}",
                on_done=lambda count: advance(count, "fleets"),
            )
        except KeyboardInterrupt:
            console.say(f"rectbench: {output} keeps the fleets that are done; the same command goes on from there")
            raise
    typer.echo(f"written: {output}")
