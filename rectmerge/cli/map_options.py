"""The options by which commands are given maps, or the answer about them, and how maps are read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rectmerge.cli import console
from rectmerge.errors import InputError

if TYPE_CHECKING:
    from rectmerge.grid import OccupancyGrid
    from rectmerge.io.dialects import Dialect
    from rectmerge.results.inputs import Input

KINDS = "A ROS map's .yaml, a plain image, or a topic of a bag (run.mcap:/map)"
DIALECT_NAMES = "nav2|nav2-2024|ros1|cartographer"

MapA = Annotated[Path, typer.Argument(metavar="A", help=f"{KINDS}; its frame is kept.")]
MapB = Annotated[Path, typer.Argument(metavar="B", help="The map that is placed on A.")]
MergeFolder = Annotated[
    Path, typer.Argument(metavar="DIR", help="The folder that a merge wrote, or the alignment.json in it.")
]
OneMap = Annotated[Path, typer.Argument(metavar="MAP", help=f"{KINDS}.")]
Grey = Annotated[int | None, typer.Option(min=0, max=255, help="Grey level in plain images; guessed unless given.")]
DialectName = Annotated[
    str | None,
    typer.Option(
        "--dialect",
        metavar=DIALECT_NAMES,
        help="By whose rules a YAML's image is read.",
        autocompletion=DIALECT_NAMES.split("|").copy,
    ),
]
Strict = Annotated[
    bool, typer.Option("--strict-thresholds", help="Obey a YAML whose free_thresh turns unknown space free.")
]
Resolution = Annotated[float | None, typer.Option(metavar="M", help="Metres per cell, whatever the file tells.")]


def name_maps(
    maps: Sequence[tuple[Path, float | None]],
    *,
    greys: tuple[int | None, int | None, int | None],
    dialect: str | None,
    strict: bool,
) -> list[Input]:
    """Gather how maps are to be read: each with the resolution it was given, all with the greys of `inputs.GREYS`."""
    from rectmerge.results.inputs import GREYS, Input

    levels, known = dict(zip(GREYS, greys, strict=True)), _known_dialect(dialect)
    for name, (_, resolution) in zip("ab", maps, strict=False):  # of a single map none is told
        if resolution is not None and not 0 < resolution < float("inf"):
            raise typer.BadParameter(f"{resolution} is no positive number of metres per cell: --resolution-{name}")
    inputs = [
        Input(given=str(path), path=path, greys=levels, dialect=known, strict=strict, resolution=resolution)
        for path, resolution in maps
    ]
    if any(level is not None for level in greys) and not any(one.is_plain for one in inputs):
        raise InputError("--free, --occupied and --unknown are for plain images; a YAML tells them by its thresholds")
    return inputs


def files_of(inputs: Sequence[Input]) -> list[Path]:
    """Return all files that maps are read from."""
    from rectmerge.io.map_file import map_files

    return [file for one in inputs for file in map_files(one.path)]


def read_maps(inputs: Sequence[Input], *, quiet: bool) -> list[OccupancyGrid]:
    """Read the maps; say on stderr what was guessed about them, once all are read: of bad input there is one line."""
    read = [one.read_noted() for one in inputs]
    for note in () if quiet else [note for _, notes in read for note in notes]:
        console.say(note)
    return [grid for grid, _ in read]


def _known_dialect(name: str | None) -> Dialect | None:
    from rectmerge.io.dialects import DIALECTS

    if name is None:
        return None
    known = {dialect: dialect for dialect in DIALECTS}
    if name not in known:
        raise typer.BadParameter(f"{name!r} is not one of {', '.join(DIALECTS)}: --dialect")
    return known[name]
