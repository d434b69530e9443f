"""Commands `rectbench run` and `rectbench compare`: methods on pairs, and one run against another."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.errors import InputError
from rectmerge.extras import SIMULATOR, require_extras
from scenarios.execution.terminal import progress, resume_callback, row_callback, summary_table


def run(
    target: Annotated[
        str, typer.Argument(metavar="SUITE|DATASET", help="A suite's name or file, or a data set's folder.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="RUN", help="Folder for the run.")],
    method: Annotated[
        list[str] | None, typer.Option("--method", "-m", help="A method, or a label of the suite; may be repeated.")
    ] = None,
    method_command: Annotated[
        list[str] | None,
        typer.Option(metavar="[NAME=]'PROG {a} {b}'", help="A program of any language as a method; may be repeated."),
    ] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="M.F=V", help="Set a field of a method; may be repeated.")
    ] = None,
    known_scale: Annotated[
        bool, typer.Option("--known-scale", help="Tell the methods the ratio of the maps' cells.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of every answer.")] = 0,
    cell_noise: Annotated[
        bool, typer.Option("--cell-noise", help="Even noise of a suite's cells, as version 1 of the suites has it.")
    ] = False,
    workers: Annotated[int | None, typer.Option(min=1, help="Worker processes; 1 unless given.")] = None,
    cluster: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Work on this dask cluster, as in tcp://host:8786.")
    ] = None,
    timeout: Annotated[float, typer.Option(metavar="S", help="Seconds for one answer.")] = 300.0,
    memory: Annotated[
        float | None, typer.Option(metavar="MB", help="Memory for one answer; no limit unless given.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Clear an earlier run in the folder first.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the summary as JSON.")] = False,
) -> None:
    """Put methods to every pair of a suite or a data set and score the answers.

    RUN gets run.toml, machine.json, results.jsonl, a line per answer as it comes, and once it is complete
    summary.json. A run that was interrupted, by Ctrl-C or anything else, goes on when the same command is given again;
    workers and limits may differ. A folder that holds a run of something else is refused without --force.

    An answer that takes more than its limits is ended and counts as failed. A program gets two image files for {a}
    and {b}, or map_server files for {a_yaml} and {b_yaml}; the last line it prints is the 2x3 matrix from B's pixels to
    A's, six numbers row by row, and perhaps its confidence; or the word rejected. Any other last line, and any status
    but 0, is an error. A program is named by NAME=, or by its script. The status is 1 if every answer is an error.

    With --known-scale the methods are told how many cells of A a cell of B is: the true number, and of two places the
    ratio of the resolutions. Programs get it for {scale}.
    """
    from rectmerge.io.json_text import to_json
    from scenarios.bench.plan import plan_run
    from scenarios.bench.run import Execution, RunCallbacks
    from scenarios.bench.run import run as run_plan
    from scenarios.execution.executors import workplace
    from scenarios.execution.limits import Limits

    if workers and cluster:
        raise InputError("--workers and --cluster exclude each other")
    limits = Limits(timeout_s=timeout, memory_mb=memory)
    require_extras(*(() if Path(target).is_dir() else SIMULATOR), "tomli_w")
    plan = plan_run(
        target,
        method or [],
        settings or [],
        method_command or [],
        knows_scale=known_scale,
        cell_noise=cell_noise,
        seed=seed,
    )
    try:
        with progress(plan.row_count) as advance, workplace(workers or 1, cluster) as (executor, in_flight):
            summary = run_plan(
                plan,
                output,
                execution=Execution(executor=executor, in_flight=in_flight, limits=limits),
                callbacks=RunCallbacks(
                    on_start=resume_callback(advance, plan.row_count), on_rows=row_callback(advance)
                ),
                force=force,
                command=f"rectbench {shlex.join(sys.argv[1:])}",
            )
    except KeyboardInterrupt:
        again = "the same command without --force" if force else "the same command"
        console.say(f"rectbench: {output} keeps what is done; {again} goes on from there")
        raise
    if as_json:
        typer.echo(to_json(summary))
    else:
        console.tell(summary_table(summary))
        typer.echo(f"written: {output}")
    if reason := _common_failure(output):
        console.say(f"rectbench: every answer failed, the first by: {reason}")
        raise typer.Exit(console.NO)


def _common_failure(folder: Path) -> str:
    """Return the reason of the first row where every row of a run is a failure; empty where one is an answer."""
    from scenarios.bench.resume import RESULTS, read_row_file
    from scenarios.scoring.score import FAILURES

    first = ""
    for row in read_row_file(folder / RESULTS):
        if row["outcome"] not in FAILURES:
            return ""
        first = first or f"{row['outcome']}: {row['reason']}"
    return first


def compare(
    run_folder: Annotated[Path, typer.Argument(metavar="RUN", help="A finished run's folder, or its results.jsonl.")],
    baseline: Annotated[Path, typer.Argument(metavar="BASELINE", help="An earlier run on the same pairs.")],
) -> None:
    """Print how a run differs from another on the same pairs, as Markdown for a pull request.

    Ends with status 1 on a regression: of a method and stratum, one right answer fewer, one wrong answer or failure
    more, or a median error larger by more than 10 percent and 0.05 cells; or of a method, a processor time longer by
    more than 5 percent and not by chance. Times are compared over those of keypoints-akaze, where both runs hold it,
    else on one machine only. Rows that time out in RUN alone do not count as worse where the machines differ.
    """
    from scenarios.studies.compare import compare_runs

    compared = compare_runs(run_folder, baseline)
    console.tell(compared.page())
    raise typer.Exit(console.NO if compared.regressions else console.YES)
