"""Options on maps and on how they are read, and the reading of maps by them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
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
        help="The rules by which a YAML's image is read.",
        autocompletion=DIALECT_NAMES.split("|").copy,
    ),
]
Strict = Annotated[
    bool, typer.Option("--strict-thresholds", help="Obey a YAML whose free_thresh turns unknown space free.")
]
Resolution = Annotated[float | None, typer.Option(metavar="M", help="Metres per cell, whatever the file says.")]


@dataclass(frozen=True, kw_only=True)
class MapOptions:
    """Options on how maps are read."""

    free: Grey = None
    occupied: Grey = None
    unknown: Grey = None
    dialect: DialectName = None
    strict_thresholds: Strict = False

    def inputs(self, *maps: Path, resolutions: Sequence[float | None] = (None, None)) -> list[Input]:
        """Return the maps with the way each is read, and its resolution where that is given.

        Raises
        ------
        InputError
            If grey levels are given but no map is a plain image.
        """
        from rectmerge.results.inputs import GREYS, Input

        greys = (self.free, self.occupied, self.unknown)
        dialect = _known_dialect(self.dialect)
        for name, resolution in zip("ab", resolutions, strict=False):
            if resolution is not None and not 0 < resolution < float("inf"):
                raise InputError(f"--resolution-{name}: {resolution} is not a positive number of metres per cell")
        inputs = [
            Input(
                given=str(path),
                path=path,
                greys=dict(zip(GREYS, greys, strict=True)),
                dialect=dialect,
                strict=self.strict_thresholds,
                resolution=resolution,
            )
            for path, resolution in zip(maps, resolutions, strict=False)
        ]
        if any(level is not None for level in greys) and not any(map_input.is_plain for map_input in inputs):
            raise InputError("--free, --occupied and --unknown are for plain images; a YAML has thresholds instead")
        return inputs


@dataclass(frozen=True, kw_only=True)
class PairOptions(MapOptions):
    """Options on how two maps are read."""

    resolution_a: Resolution = None
    resolution_b: Resolution = None

    def pair(self, a: Path, b: Path) -> list[Input]:
        """Return both maps with the way each is read."""
        return self.inputs(a, b, resolutions=(self.resolution_a, self.resolution_b))


def input_files(inputs: Sequence[Input]) -> list[Path]:
    """Return all files that maps are read from."""
    from rectmerge.io.map_file import map_files

    return [file for map_input in inputs for file in map_files(map_input.path)]


def read_maps(inputs: Sequence[Input]) -> list[OccupancyGrid]:
    """Read the maps; note on stderr what was guessed about them, once all are read: bad input gives one line."""
    maps = [map_input.read_with_notes() for map_input in inputs]
    for _, notes in maps:
        for note in notes:
            console.note(note)
    return [grid for grid, _ in maps]


def _known_dialect(name: str | None) -> Dialect | None:
    from rectmerge.io.dialects import DIALECTS

    if name is None:
        return None
    known = {dialect: dialect for dialect in DIALECTS}
    if name not in known:
        raise InputError(f"--dialect: {name!r} is not one of {', '.join(DIALECTS)}")
    return known[name]
