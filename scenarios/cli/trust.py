"""The commands `rectbench calibrate` and `rectbench trust`: what the confidence is fitted to, and what it is worth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rectmerge.cli.console import Debug, Quiet


def calibrate(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="Runs of `robust` with --set robust.candidates=20.")
    ],
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Fit the confidence of `robust` to the split train and print the numbers for rectmerge/robust/confidence_model.py.

    Pairs of buildings whose rooms are all alike are left out of the fit: their wrong placements look like right ones.
    """
    from scenarios.bench.run import read_rows
    from scenarios.studies.calibration import report

    typer.echo(report([row for run in runs for row in read_rows(run)]))


def trust(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN...", help="Finished runs of the suites trust, repetitive, standard.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.md", help="Where the page goes.")],
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Write what the verdict of `robust` is worth on the split test of finished runs: rates, calibration, failures."""
    from scenarios.studies.trust import write_page

    write_page(runs, output)
    typer.echo(f"written: {output}")
