"""The command `rectbench`: run methods over suites and data sets, and show the main job whole."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.cli.console import Debug, Quiet, Version
from rectmerge.errors import InputError
from rectmerge.extras import SIMULATOR, require_extras
from scenarios.cli import carmen as carmencommands
from scenarios.cli import check_method as methodcommands
from scenarios.cli import dataset as datasetcommands
from scenarios.cli import leaderboard as leaderboardcommands
from scenarios.cli import pictures as picturecommands
from scenarios.cli import trust as trustcommands
from scenarios.execution.terminal import progress, resume_callback, row_callback, summary_table, table

app = typer.Typer(
    help="Benchmark map merging on simulated and real pairs with known truth.",
    context_settings=console.SETTINGS,
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
)


@app.callback()
def rectbench(version: Version = False) -> None:
    """Benchmark map merging on simulated and real pairs with known truth."""


@app.command()
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
        typer.Option(metavar="'PROG {a} {b}'", help="A program of any language as a method; may be repeated."),
    ] = None,
    settings: Annotated[
        list[str] | None, typer.Option("--set", metavar="M.F=V", help="Set a field of a method; may be repeated.")
    ] = None,
    known_scale: Annotated[
        bool, typer.Option("--known-scale", help="Tell the methods the ratio of the maps' cells.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of every answer.")] = 0,
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
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Put methods to every pair of a suite or a data set and score the answers.

    RUN gets run.toml, machine.json, results.jsonl, a line per answer as it comes, and once it is complete
    summary.json. A run that was interrupted, by Ctrl-C or anything else, goes on when the same command is given again;
    workers and limits may differ. A folder that holds a run of something else is refused without --force.

    An answer that takes more than its limits is ended and counts as failed. A program gets two image files for {a}
    and {b}, or map_server files for {a_yaml} and {b_yaml}; the last line it prints is the 2x3 matrix from B's pixels to
    A's, six numbers row by row, and perhaps its confidence. Status 1 means rejected, any other but 0 is an error.

    With --known-scale the methods are told how many cells of A a cell of B is: the true number, and of two places the
    ratio of the resolutions. Programs get it for {scale}.
    """
    from rectmerge.results.folder import to_json
    from scenarios.bench.plan import contest_of
    from scenarios.execution.executors import workplace
    from scenarios.execution.limits import Limits

    if workers and cluster:
        raise InputError("--workers and --cluster exclude each other")
    limits = Limits(timeout_s=timeout, memory_mb=memory)
    require_extras(*(() if Path(target).is_dir() else SIMULATOR), "tomli_w")
    contest = contest_of(target, method or [], settings or [], method_command or [], knows_scale=known_scale)
    options = {"seed": seed, "limits": limits, "force": force, "command": _command()}
    try:
        with progress(contest.tasks, quiet) as advance, workplace(workers or 1, cluster) as (executor, in_flight):
            summary = contest.run(
                output,
                executor=executor,
                in_flight=in_flight,
                on_start=resume_callback(advance, contest.tasks, quiet),
                on_rows=row_callback(advance),
                **options,
            )
    except KeyboardInterrupt:
        again = "the same command without --force" if force else "the same command"
        console.say(f"rectbench: {output} keeps what is done; {again} goes on from there")
        raise
    if as_json:
        typer.echo(to_json(summary))
    else:
        typer.echo(summary_table(summary))
        typer.echo(f"written: {output}")


app.command()(datasetcommands.generate)
app.command()(carmencommands.carmen)
app.command()(datasetcommands.verify)
app.command()(trustcommands.calibrate)
app.command()(trustcommands.trust)
app.command()(datasetcommands.certify)
app.command()(leaderboardcommands.tune)
app.command()(leaderboardcommands.report)
app.command()(leaderboardcommands.leaderboard)
app.command()(leaderboardcommands.growth)
app.command()(methodcommands.check_method)
app.command()(picturecommands.explain)
app.command()(picturecommands.figures)


@app.command()
def compare(
    run_folder: Annotated[Path, typer.Argument(metavar="RUN", help="A finished run's folder, or its results.jsonl.")],
    baseline: Annotated[Path, typer.Argument(metavar="BASELINE", help="An earlier run on the same pairs.")],
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Print how a run differs from another on the same pairs, as Markdown for a pull request.

    Ends with status 1 on a regression: of a method and stratum, right answers are rarer, or wrong ones or failures more
    frequent, by more than 2 percent of the pairs, or the median error is larger by more than 10 percent and 0.05 cells.
    """
    from scenarios.studies.compare import compare_runs

    compared = compare_runs(run_folder, baseline)
    typer.echo(compared.page())
    raise typer.Exit(console.NO if compared.regressions else console.YES)


@app.command()
def demo(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the pictures.")] = Path(
        "demo"
    ),
    force: Annotated[bool, typer.Option("--force", help="Clear an earlier demo in the folder first.")] = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Show the main job whole: simulate two robots, build their maps, merge, score, draw.

    Ends with status 0 when the chain ran, whether the answers were right or wrong; the table says which.
    """
    from scenarios.gallery.demo import run_demo

    require_extras(*SIMULATOR)
    shown = run_demo(output, force=force, say=(lambda line: None) if quiet else console.say)
    typer.echo(table(*shown.table()))
    typer.echo(f"pictures: {output / 'demo.png'} and {len(shown.pictures) - 1} more in {output}")
    typer.echo(f"the mission's data: {output / 'mission'}")


@app.command()
def headline(
    run_folder: Annotated[Path, typer.Argument(metavar="RUN", help="A finished run of the suite headline.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.md", help="Where the report goes.")],
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Write the five marks of the paper's experiment, rebuilt, and its trace, from a run of the suite headline."""
    from scenarios.studies.headline import write_report

    write_report(run_folder, output)
    typer.echo(f"written: {output}")


@app.command()
def results(
    maps: Annotated[
        Path, typer.Argument(metavar="MAPS", help="The folder that holds the data sets real_maps and real_lasers.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the page and the baseline.")
    ],
    force: Annotated[bool, typer.Option("--force", help="Replace earlier results in the folder.")] = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Run the default method on real and simulated pairs and write what it reached, and what each stage earns.

    DIR gets README.md and baseline.json, which the accuracy tests hold later versions to; the rows go into DIR/run.
    """
    from scenarios.studies.default_method import Plan, write_results

    require_extras(*SIMULATOR, "tomli_w")
    plan = Plan.of(maps)
    with progress(plan.rows, quiet) as advance:
        write_results(plan, output, force=force, on_rows=row_callback(advance))
    typer.echo(f"written: {output}")


@app.command()
def realism(
    maps: Annotated[
        Path, typer.Argument(metavar="MAPS", help="The folder that holds the data sets real_maps and real_lasers.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the page and the contact sheet.")
    ],
    pairs: Annotated[int, typer.Option(min=1, help="Missions to run, one pair each.")] = 200,
    workers: Annotated[int, typer.Option(min=1, help="Worker processes.")] = 1,
    force: Annotated[bool, typer.Option("--force", help="Replace an earlier page in the folder.")] = False,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Simulate pairs of every kind and set what they are like beside real pairs: README.md and sheet.png."""
    from scenarios.execution.executors import local_workers
    from scenarios.studies.realism import Finding, write_realism

    require_extras(*SIMULATOR)
    with local_workers(workers) as executor, progress(pairs, quiet) as advance:

        def on_done(finding: Finding) -> None:
            advance(1, finding.kind)

        write_realism(
            maps, output, pairs=pairs, executor=executor, force=force, on_done=on_done
        )  # fmt: skip
    typer.echo(f"written: {output}")


@app.command()
def suites(quiet: Quiet = False, debug: Debug = False) -> None:
    """List the suites that come with the package."""
    from scenarios.suites.suite import load_suite, suite_names

    rows = []
    for name in suite_names():
        suite = load_suite(name)
        pairs = sum(len(source.pair_ids) for source in suite.sources())
        rows.append([name, str(pairs), ", ".join(entry.label for entry in suite.methods) or "-", suite.title])
    typer.echo(table(["suite", "pairs", "methods", "what"], rows))


@app.command()
def worlds(
    what: Annotated[str | None, typer.Argument(metavar="FAMILY|FILE", help="A family, a map, or a plan.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="PICTURE.png", help="The picture.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Which building of a family; 0 unless given.")] = None,
    resolution: Annotated[float | None, typer.Option(metavar="M_PER_PIXEL", help="Where a file tells none.")] = None,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """List the families of buildings that can be simulated, or draw a building of one, or what a file holds.

    A FILE is a ROS map's .yaml, an image of a map or of a black-and-white floor plan, or a HouseExpo .json.
    """
    from scenarios.gallery.world_view import list_families, write_picture

    if what is not None:
        typer.echo(write_picture(what, output, seed=seed, resolution=resolution))
    elif output is not None or seed is not None or resolution is not None:
        raise InputError("name a family or a file to draw; without one the families are listed")
    else:
        typer.echo(list_families())


def main() -> None:
    """Run the command and exit with its status."""
    console.end(app, "rectbench")


def _command() -> str:
    return f"rectbench {shlex.join(sys.argv[1:])}"
