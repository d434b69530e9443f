"""Commands `rectbench suites` and `rectbench worlds`: lists of what can be simulated."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from rectmerge.errors import InputError
from scenarios.execution.terminal import table


def suites() -> None:
    """List the suites that come with the package."""
    from scenarios.suites.suite import load_suite, suite_names

    rows = []
    for name in suite_names():
        suite = load_suite(name)
        pairs = sum(len(source.pair_ids) for source in suite.sources())
        rows.append([name, str(pairs), _first_labels([entry.label for entry in suite.methods]), suite.title])
    typer.echo(table(["suite", "pairs", "methods", "what"], rows))


def _first_labels(labels: Sequence[str], shown: int = 3) -> str:
    more = f" and {len(labels) - shown} more" if len(labels) > shown else ""
    return (", ".join(labels[:shown]) or "-") + more


def worlds(
    what: Annotated[str | None, typer.Argument(metavar="FAMILY|FILE", help="A family, a map, or a plan.")] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", metavar="PICTURE.png", help="The picture.")] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Which building of a family; 0 unless given.")] = None,
    resolution: Annotated[float | None, typer.Option(metavar="M_PER_PIXEL", help="Where a file tells none.")] = None,
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
