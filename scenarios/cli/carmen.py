"""Command of `rectbench` that makes maps and pairs of real logs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.cli import console
from rectmerge.errors import InputError
from scenarios.execution.terminal import progress

if TYPE_CHECKING:
    from scenarios.dataset.from_carmen import CarmenSuite
    from sim.importers.survey import Survey

MAP = ("map.yaml", "map.pgm")


def carmen(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="A CARMEN log, plain or .gz.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the map or the data set.")],
    resolution: Annotated[float, typer.Option(metavar="M", help="Metres per cell.")] = 0.05,
    pairs: Annotated[int | None, typer.Option(min=1, help="Cut the log in two so many times: a data set.")] = None,
    cut: Annotated[float | None, typer.Option(metavar="SHARE", help="Where to cut; 0.5 unless given.")] = None,
    shared: Annotated[float | None, typer.Option(metavar="SHARE", help="Of the scans, that both parts have.")] = None,
    resolution_b: Annotated[float | None, typer.Option(metavar="M", help="Of map B; as A unless given.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Of the maps' turns; 0 unless given.")] = None,
    poses: Annotated[
        str,
        typer.Option(
            metavar="auto|log|match", help="Corrected ones where there are, else matched; as they stand; matched."
        ),
    ] = "auto",
    every: Annotated[int, typer.Option(min=1, metavar="N", help="Keep every N-th scan only.")] = 1,
    force: Annotated[bool, typer.Option("--force", help="Clear an earlier result in the folder first.")] = False,
) -> None:
    """Make a map of a CARMEN log (FLASER, ROBOTLASER1, ODOM), or with --pairs a data set of pairs with their truth.

    Without --pairs DIR gets map.yaml and map.pgm, in the frame of the log's poses. With it the log is cut in two, each
    part is mapped alone and turned at random, and the poses of the whole log say how the maps relate; several cuts are
    spread over 0.2 of the log to either side of --cut. `rectbench verify DIR` checks it, `rectbench run DIR` scores
    methods on it.

    Scans are laid down by the log's corrected poses, or where it has none by matching them from its odometry. A log
    whose odometry was itself corrected is laid down as it is with --poses log.
    """
    from sim.importers import read_carmen
    from sim.importers.survey import parse_pose_choice, survey

    asked = {"--cut": cut, "--shared": shared, "--resolution-b": resolution_b, "--seed": seed}
    given = {name: value for name, value in asked.items() if value is not None}
    if pairs is None and given:
        raise InputError(f"{next(iter(given))} says how pairs are made: give --pairs N too")
    choice = parse_pose_choice(poses)
    read = read_carmen(log, every=every)
    with progress(len(read.times)) as advance:
        seen = survey(read, poses=choice, on_scan=lambda scans: advance(scans, "scans"))
    if pairs is None:
        _write_map(seen, output, resolution=resolution, force=force)
        return
    values = {"--pairs": pairs, "--resolution": resolution, **given, "--every": every}
    options = " ".join(f"{name} {value}" for name, value in values.items())
    command = f"rectbench carmen {log.name} -o DATASET {options} --poses {poses}"
    suite = _suite(log, seen, pairs=pairs, cut=cut, shared=shared, resolution=(resolution, resolution_b), seed=seed)
    _write_pairs(suite, output, force=force, command=command)


def _write_map(seen: Survey, output: Path, *, resolution: float, force: bool) -> None:
    from rectmerge.io.map_file import write_map
    from scenarios.execution.files import clear_folder

    grid = seen.map(resolution)
    write_map(grid, clear_folder(output, MAP, force=force) / MAP[0])
    how = "our scan matching" if seen.is_matched else "the log's poses"
    height, width = grid.shape
    typer.echo(f"{len(seen.robot.times)} scans with movement, by {how}: {width} x {height} cells of {resolution:g} m")
    typer.echo(f"written: {output / MAP[0]}")


def _suite(
    log: Path,
    seen: Survey,
    *,
    pairs: int,
    cut: float | None,
    shared: float | None,
    resolution: tuple[float, float | None],
    seed: int | None,
) -> CarmenSuite:
    from scenarios.dataset.from_carmen import CarmenSuite

    return CarmenSuite(
        name=re.sub(r"[^\w-]+", "-", log.name.removesuffix(".gz").rpartition(".")[0] or log.name).strip("-") or "log",
        survey=seen,
        pairs=pairs,
        cut=0.5 if cut is None else cut,
        shared=shared or 0.0,
        resolution_a=resolution[0],
        resolution_b=resolution[0] if resolution[1] is None else resolution[1],
        seed=seed or 0,
    )


def _write_pairs(suite: CarmenSuite, output: Path, *, force: bool, command: str) -> None:
    from scenarios.dataset.generate import generate, summary_text

    try:
        with progress(suite.pairs) as advance:
            info = generate(
                suite,
                output,
                seed=suite.seed,
                force=force,
                command=command,
                on_done=lambda count: advance(count, "pairs"),
            )
    except KeyboardInterrupt:
        console.say(f"{output}: what was made is kept; the same command (without --force) goes on")
        raise
    typer.echo(summary_text(info))
    typer.echo(f"written: {output}")
