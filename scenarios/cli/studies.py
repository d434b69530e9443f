"""Commands of `rectbench` that study methods: calibration, trust, the paper's experiment, accuracy, realism."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.extras import SIMULATOR, require_extras
from scenarios.execution.terminal import progress, row_callback


def calibrate(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="Runs of `robust` with --set robust.max_candidates=20.")
    ],
) -> None:
    """Fit the confidence of `robust` to the split train and to real maps, and print the numbers for its params.py.

    Below them stand the verdicts on places that took no part in a fit. Pairs of buildings whose rooms are all alike are
    left out: their wrong placements look like right ones.
    """
    from scenarios.bench.run import read_rows
    from scenarios.studies.held_out import report

    typer.echo(report([row for run in runs for row in read_rows(run)]))


def trust(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="Finished runs of the suites trust, repetitive, standard.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.md", help="Where the page goes.")],
) -> None:
    """Write what the verdict of `robust` is worth on the split test of finished runs: rates, calibration, failures."""
    from scenarios.studies.trust import write_page

    write_page(runs, output)
    typer.echo(f"written: {output}")


def storeys(
    run_folder: Annotated[Path, typer.Argument(metavar="RUN", help="A finished run of storeys.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.md", help="Where the page goes.")],
) -> None:
    """Write how often two storeys that look alike are joined, and how often one storey is after changes."""
    from scenarios.studies.storeys import write_page

    write_page(run_folder, output)
    typer.echo(f"written: {output}")


def headline(
    run_folder: Annotated[Path, typer.Argument(metavar="RUN", help="A finished run of headline or headline-test.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.md", help="Where the report goes.")],
) -> None:
    """Write the five marks of the paper's experiment, rebuilt, and its trace."""
    from scenarios.studies.headline import write_report

    write_report(run_folder, output)
    typer.echo(f"written: {output}")


def results(
    maps: Annotated[
        Path, typer.Argument(metavar="MAPS", help="The folder that holds the data sets real_maps and real_lasers.")
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the page and the baseline.")
    ],
    force: Annotated[bool, typer.Option("--force", help="Replace earlier results in the folder.")] = False,
) -> None:
    """Run the default method on real and simulated pairs and write what it reached, and what each stage earns.

    DIR gets README.md and baseline.json, which the accuracy tests hold later versions to; the rows go into DIR/run.
    """
    from scenarios.studies.default_method import StudyPlan, write_results

    require_extras(*SIMULATOR, "tomli_w")
    plan = StudyPlan.from_folder(maps)
    with progress(plan.row_count) as advance:
        write_results(plan, output, force=force, on_rows=row_callback(advance))
    typer.echo(f"written: {output}")


def realism(
    maps: Annotated[
        Path,
        typer.Argument(metavar="MAPS", help="The folder that holds the data sets real_maps, real_lasers, real_places."),
    ],
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the pages and the contact sheets.")
    ],
    missions: Annotated[int, typer.Option(min=0, help="Missions whose maps are compared; 0 leaves their page.")] = 60,
    pairs: Annotated[int, typer.Option(min=0, help="Missions to run, one pair each; 0 leaves their page.")] = 200,
    workers: Annotated[int, typer.Option(min=1, help="Worker processes.")] = 1,
    force: Annotated[bool, typer.Option("--force", help="Replace earlier pages in the folder.")] = False,
) -> None:
    """Compare simulated maps with those of robots, and simulated pairs with real ones.

    maps.md and maps.png: descriptors of maps at each noise level, and a classifier that must tell simulated from real
    ones. README.md and sheet.png: pairs of every kind.
    """
    from scenarios.execution.executors import local_workers
    from scenarios.studies.realism import write_realism

    require_extras(*SIMULATOR, *(["sklearn"] if missions else []))
    with local_workers(workers) as executor, progress(missions + pairs) as advance:
        write_realism(
            maps,
            output,
            missions=missions,
            pairs=pairs,
            executor=executor,
            force=force,
            on_done=lambda origin: advance(1, origin),
        )
    typer.echo(f"written: {output}")


def fit_noise(
    maps: Annotated[
        Path, typer.Argument(metavar="MAPS", help="The folder that holds the data sets real_places and real_lasers.")
    ],
    missions: Annotated[int, typer.Option(min=8, help="Missions of the suite standard, split train, to map.")] = 40,
) -> None:
    """Fit noise levels 1 and 2 to real maps and print their strengths, for noise_levels.py in scenarios/corruption.

    Of every mission map A is made anew under each trial, and its descriptors are compared with those of real maps.
    """
    from scenarios.corruption.noise_levels import GOOD, POOR
    from scenarios.studies.map_population import real_population, run_missions
    from scenarios.studies.noise_fit import fit_levels

    require_extras(*SIMULATOR)
    real = real_population(maps)
    with progress(missions) as advance:
        mapped = run_missions(missions, split="train", on_done=lambda source_id: advance(1, source_id))
    for level, noise in fit_levels(real, mapped, {1: GOOD, 2: POOR}, on_step=console.note).items():
        typer.echo(f"{level}: {noise}")


def unbending(
    maps: Annotated[
        Path, typer.Argument(metavar="MAPS", help="The folder that holds the data sets real_maps and real_lasers.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.md", help="Where the page goes.")],
) -> None:
    """Bend real and simulated pairs that no similarity fits, and write their errors before and after."""
    from scenarios.studies.unbending import pair_sources, write_unbending

    require_extras(*SIMULATOR)
    with progress(len(pair_sources(maps))) as advance:

        def on_done(pair_id: str) -> None:
            advance(1, pair_id)

        write_unbending(maps, output, on_done=on_done)
    typer.echo(f"written: {output}")


def live(
    dataset: Annotated[Path, typer.Argument(metavar="DATASET", help="A data set.")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.md", help="Where the page goes.")],
) -> None:
    """Replay pairs of robots to the live merger, and write when each pair merged, and if rightly.

    Maps grow as they do in the bags of rectbench generate --format mcap; a pair without a bag is shown from a drawn
    place outwards, along its free space.
    """
    from scenarios.dataset.reader import open_dataset
    from scenarios.studies.live import LiveMission, write_live

    require_extras("rosbags")
    with progress(len(open_dataset(dataset))) as advance:

        def on_done(mission: LiveMission) -> None:
            advance(1, mission.pair_id)

        write_live(dataset, output, on_done=on_done)
    typer.echo(f"written: {output}")
