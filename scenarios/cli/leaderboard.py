"""Commands of `rectbench` around the leaderboard."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.cli import console
from rectmerge.extras import SIMULATOR, require_extras
from scenarios.execution.terminal import progress, resume_callback, row_callback

if TYPE_CHECKING:
    from scenarios.bench.plan import RunPlan


def tune(
    dataset: Annotated[Path, typer.Argument(metavar="DATASET", help="A data set; its split train is used.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="RUN", help="Folder for the run.")],
    method: Annotated[
        list[str] | None, typer.Option("--method", "-m", help="An entrant of the leaderboard; may be repeated.")
    ] = None,
    budget: Annotated[int, typer.Option(min=1, help="Configurations tried of each method.")] = 12,
    every: Annotated[int, typer.Option(min=1, help="Take every so many-th pair only.")] = 1,
    workers: Annotated[int, typer.Option(min=1, help="Worker processes.")] = 1,
    force: Annotated[bool, typer.Option("--force", help="Clear an earlier run in the folder first.")] = False,
) -> None:
    """Tune the methods of the leaderboard, all with one budget, and print what scenarios/bench/tuned.toml takes.

    The first configuration of each is its authors' own; the others are drawn from its space in
    scenarios/bench/entrants.toml. Taken is the one with the least area under the risk-coverage curve, and its threshold
    changes only where right less wrong answers get more by over a standard error. Interrupted and called again it goes
    on where it was.
    """
    require_extras("tomli_w")
    import tomli_w

    from scenarios.bench.contenders import make_contenders
    from scenarios.bench.entrants import entrants_named
    from scenarios.bench.plan import RunPlan
    from scenarios.bench.run import read_rows
    from scenarios.dataset.reader import dataset_name, open_dataset
    from scenarios.leaderboard.tuning import as_table, tuned_contender

    sources = open_dataset(dataset, split="train")[::every]
    searches = [(entrant, entrant.configurations(budget)) for entrant in entrants_named(method or [])]
    entries = [entry for _, configurations in searches for entry in configurations]
    contenders = make_contenders([entry.label for entry in entries], entries)
    plan = RunPlan(suite=dataset_name(dataset), sources=sources, contenders=contenders)
    _run(plan, output, workers=workers, force=force)
    rows = read_rows(output)
    table = as_table([tuned_contender(entrant, configurations, rows) for entrant, configurations in searches])
    typer.echo(tomli_w.dumps(table))


def report(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Finished runs.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.html", help="The page.")],
    latex: Annotated[
        Path | None, typer.Option(metavar="FILE.tex", help="The leaderboards as LaTeX tables, too.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an earlier report.")] = False,
) -> None:
    """Write finished runs as one page: leaderboard, charts, and a gallery of every pair. It needs no network."""
    from scenarios.report.page import write_report

    count = write_report(runs, output, table=latex, force=force)
    typer.echo(f"written: {output}, {count} answers, {output.stat().st_size / 1e6:.1f} MB")


def leaderboard(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for all of it.")],
    maps: Annotated[
        Path | None,
        typer.Option(metavar="MAPS", help="The folder of the data sets real_maps, real_lasers, real_places."),
    ] = None,
    suite: Annotated[
        list[str] | None, typer.Option("--suite", help="A simulated suite, in place of all; may be repeated.")
    ] = None,
    workers: Annotated[int, typer.Option(min=1, help="Worker processes.")] = 1,
    finished: Annotated[
        bool, typer.Option("--finished", help="Write the pages of the runs that are finished, and run nothing.")
    ] = False,
    add: Annotated[
        list[Path] | None,
        typer.Option(metavar="FILE.json", help="Show a submission beside the others; may be repeated."),
    ] = None,
) -> None:
    """Put everybody to the leaderboard's suites and write README.md and report.html; a long run that can be resumed.

    DIR gets sets/ and runs/ as well, which are taken up again where an earlier command left them; a finished data set
    stays as it is, whatever version made it. Without MAPS there are no real pairs.

    Submissions, which `rectbench submit` writes, get lines in the tables of README.md, with a dash for what they lack,
    and whether they are self-reported or verified. They must be of the same data sets, and of all pairs.
    """
    from rectmerge.errors import InputError
    from rectmerge.io.atomic_file import replace_file
    from scenarios.bench.resume import SUMMARY
    from scenarios.dataset.writer import finished_info
    from scenarios.leaderboard.additions import data_set_ids, with_submissions
    from scenarios.leaderboard.page import page
    from scenarios.leaderboard.plans import RUNS, SUITES, stages
    from scenarios.leaderboard.submission import read_submission
    from scenarios.report.page import write_report
    from scenarios.report.reading import Runs

    submissions = {path: read_submission(path) for path in add or []}  # a bad one is said before the long run
    require_extras(*SIMULATOR, "tomli_w", "jinja2", "matplotlib")
    folders = []
    for stage in stages(output, maps, suite or SUITES):
        folder = output / RUNS / stage.run_name
        if finished:
            folders += [folder] if (folder / SUMMARY).is_file() else []
            continue
        if stage.is_simulated and not finished_info(stage.folder):
            console.say(f"{stage.folder}: the data set")
            _generate(stage.name, stage.folder, workers=workers)
        console.say(f"{folder}: all entrants on it")
        command = f"rectbench leaderboard, {stage.run_name}"
        _run(stage.plan(), folder, workers=workers, command=command)
        folders.append(folder)
    if not folders:
        raise InputError(f"{output / RUNS}: no run of the leaderboard is finished; leave out --finished to run it")
    own = Runs.read(folders)
    data_sets = data_set_ids(folders, own)
    shown, reported = with_submissions(own, submissions, data_sets)
    replace_file(output / "README.md", page(shown, reported, data_sets).encode())
    write_report(folders, output / "report.html", force=True)
    typer.echo(f"written: {output}")


def growth(
    measured: Annotated[Path, typer.Argument(metavar="BENCH.json", help="What bench_growth.py measured.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the page and the plot.")],
    force: Annotated[bool, typer.Option("--force", help="Replace an earlier page in the folder.")] = False,
) -> None:
    """Lay out how the cost of methods grows with the size of the maps, from a run of tests/bench/bench_growth.py."""
    from scenarios.leaderboard.growth import write_growth

    write_growth(measured, output, force=force)
    typer.echo(f"written: {output}")


def _generate(suite: str, output: Path, *, workers: int) -> None:
    """Make the data set of a suite, with progress."""
    from scenarios.dataset.generate import generate, plan
    from scenarios.execution.executors import workplace
    from scenarios.suites.suite import load_suite

    made = load_suite(suite)
    total = sum(job.count for job in plan(made))
    with workplace(workers, None) as (executor, in_flight), progress(total) as advance:
        on_done = functools.partial(advance, word="pairs")
        generate(made, output, executor=executor, in_flight=in_flight, on_done=on_done)


def _run(plan: RunPlan, output: Path, *, workers: int, force: bool = False, command: str = "") -> None:
    """Run a plan, with progress."""
    from scenarios.bench.run import Execution, RunCallbacks, run
    from scenarios.execution.executors import workplace

    with progress(plan.row_count) as advance, workplace(workers, None) as (executor, in_flight):
        run(
            plan,
            output,
            execution=Execution(executor=executor, in_flight=in_flight),
            callbacks=RunCallbacks(on_start=resume_callback(advance, plan.row_count), on_rows=row_callback(advance)),
            force=force,
            command=command,
        )
