"""Commands of `rectbench` that make and check data sets."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import typer

from rectmerge.cli import console
from rectmerge.errors import InputError
from rectmerge.extras import SIMULATOR, require_extras
from scenarios.execution.terminal import progress

if TYPE_CHECKING:
    from scenarios.dataset.generate import Form


def generate(
    name: Annotated[str, typer.Argument(metavar="SUITE", help="A suite's name or file.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DATASET", help="Folder for the data set.")],
    pairs: Annotated[int | None, typer.Option(min=1, help="The first so many pairs; further seeds beyond all.")] = None,
    seed: Annotated[int, typer.Option(min=0, help="Another seed makes other buildings.")] = 0,
    secret: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Mix a secret, 32 hexadecimal digits or more, into every seed of the suite."),
    ] = None,
    cell_noise: Annotated[
        bool, typer.Option("--cell-noise", help="Even noise of the cells, as version 1 of the suites has it.")
    ] = False,
    form: Annotated[
        str,
        typer.Option(
            "--format",
            metavar="files|mcap|rosbag1",
            help="mcap, rosbag1: each pair's mission as a bag of ROS 2 or ROS 1, too.",
        ),
    ] = "files",
    workers: Annotated[int | None, typer.Option(min=1, help="Worker processes; 1 works in this process.")] = None,
    cluster: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Work on this dask cluster, as in tcp://host:8786.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Clear another data set in the folder first.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print dataset_info.json without its checksums.")] = False,
) -> None:
    """Make a data set of a suite: maps, truth, buildings, checksums and a card.

    Interrupted and called again with the same words it goes on where it was; the files are the same as if it had not
    been interrupted, whatever the number of workers. A pair that cannot be made is named in dataset_info.json.

    With --secret nobody makes the same pairs without FILE: the same secret makes the same bytes, another one other
    buildings. Its SHA-256 stands in dataset_info.json, so that it can be published at once and the secret later.
    """
    from scenarios.dataset.generate import generate as generate_suite
    from scenarios.dataset.generate import plan, summary_text
    from scenarios.dataset.suite_seeds import Secret
    from scenarios.execution.executors import workplace
    from scenarios.suites.suite import load_suite, with_cell_noise

    if workers and cluster:
        raise InputError("--workers and --cluster exclude each other")
    suite = with_cell_noise(load_suite(name)) if cell_noise else load_suite(name)
    require_extras(*SIMULATOR)
    total = pairs or sum(job.count for job in plan(suite, seed=seed))
    making = functools.partial(
        generate_suite,
        suite,
        output,
        pairs=pairs,
        seed=seed,
        form=cast("Form", form),
        secret=None if secret is None else Secret.from_file(secret),
        force=force,
    )
    try:
        with workplace(workers or 1, cluster) as (executor, in_flight), progress(total) as advance:
            info = making(executor=executor, in_flight=in_flight, on_done=lambda count: advance(count, "pairs"))
    except KeyboardInterrupt:
        console.say(f"{output}: what was made is kept; the same command (without --force) goes on")
        raise
    typer.echo(summary_text(info, as_json=as_json))
    typer.echo(f"written: {output}", err=as_json)


def verify(
    target: Annotated[Path, typer.Argument(metavar="DATASET|FILE.json", help="A data set's folder, or a submission.")],
    dataset: Annotated[
        Path | None, typer.Option("--data-set", metavar="DATASET", help="The data set of a submission.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="FILE.json", help="The submission as verified.")
    ] = None,
    every: Annotated[int, typer.Option(min=1, help="Of a submission, every so many-th pair only.")] = 1,
    method_command: Annotated[
        list[str] | None,
        typer.Option(metavar="LABEL='PROG {a} {b}'", help="A program of a submission; may be repeated."),
    ] = None,
    workers: Annotated[int, typer.Option(min=1, help="Worker processes for a submission.")] = 1,
    force: Annotated[bool, typer.Option("--force", help="Replace an earlier file.")] = False,
) -> None:
    """Recompute a data set's checksums, id, truth and overlaps, and say what is wrong with file and line.

    Ends with status 0 when nothing is wrong, 1 when something is. Works on anybody's data set in the
    layout; without dataset_info.json there are no checksums to compare.

    A submission, the file of `rectbench submit`, is run again: its methods, with their fields and its seed, on its
    pairs. Rows whose outcome, verdict, error or confidence differ are named, with status 1; without any, -o takes the
    submission as verified. Programs are run only as --method-command says, never by the word of the file.
    """
    if target.is_file():
        from scenarios.cli.submissions import verify_submission

        verify_submission(
            target, dataset, output, commands=method_command or [], every=every, workers=workers, force=force
        )
        return
    given = {"--data-set": dataset, "-o": output, "--method-command": method_command, "--force": force}
    _refuse_submission_options(target, {**given, "--every": every > 1, "--workers": workers > 1})
    from scenarios.dataset.verify import row_count
    from scenarios.dataset.verify import verify as check

    with progress(row_count(target)) as advance:
        verdict = check(target, on_pair=lambda: advance(1, "pairs"))
    for note in verdict.notes:
        console.say(note)
    for fault in verdict.faults:
        typer.echo(fault)
    typer.echo(f"{verdict.pairs} pairs, {verdict.files} checksums: {len(verdict.faults) or 'nothing'} wrong")
    typer.echo(f"id: {verdict.dataset_id}")
    if verdict.faults:
        raise typer.Exit(console.NO)


def _refuse_submission_options(target: Path, given: Mapping[str, object]) -> None:
    """Refuse an option of `verify` that only means something for a submission."""
    if option := next((name for name, value in given.items() if value), None):
        found = "is a folder" if target.is_dir() else "is no file"
        raise InputError(f"{target}: {found}; {option} goes with the file of a submission: leave it out")


def certify(
    dataset: Annotated[Path, typer.Argument(metavar="DATASET", help="A data set's folder.")],
    seconds: Annotated[float, typer.Option(min=0.1, metavar="S", help="Time for each certificate.")] = 10.0,
    every: Annotated[int, typer.Option(min=1, help="Take every so many-th pair only.")] = 1,
) -> None:
    """Tell which of the pairs that the default method accepts it can certify, as `rectmerge merge --certify` does."""
    from scenarios.dataset.certify import certificate_table, certify_dataset
    from scenarios.dataset.verify import row_count

    with progress(-(-row_count(dataset) // every)) as advance:
        found = certify_dataset(dataset, every=every, seconds=seconds, on_pair=lambda: advance(1, "pairs"))
    typer.echo(certificate_table(found))
