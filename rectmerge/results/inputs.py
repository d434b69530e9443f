"""The maps that a merge was given, as its ``alignment.json`` names them, so that they are found and read again."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.atomic_file import resolve_links
from rectmerge.io.bag_file import is_bag, split_bag
from rectmerge.io.dialects import DIALECTS, Dialect
from rectmerge.io.map_file import is_yaml, read_image, read_map
from rectmerge.results.alignment_json import AlignmentFile

GREYS = ("free", "occupied", "unknown")
REMEDY = "name the maps with --a FILE and --b FILE"


@dataclass(frozen=True, slots=True, kw_only=True)
class Input:
    """A map that a command was given, and how it is read.

    Parameters
    ----------
    given
        The name as it was given.
    path
        Where it lies: a file, or a topic of a bag.
    greys
        The grey levels that were named for plain images, by name; None where guessed.
    dialect
        By whose rules a YAML's image is read; None where the file tells.
    strict
        Whether a YAML is taken at its word.
    resolution
        Metres per cell, instead of what the file tells; None where it stands.
    """

    given: str
    path: Path
    greys: Mapping[str, int | None]
    dialect: Dialect | None = None
    strict: bool = False
    resolution: float | None = None

    @property
    def is_plain(self) -> bool:
        """Whether it is a plain image."""
        return not (is_yaml(self.path) or is_bag(self.path))

    def read(self) -> OccupancyGrid:
        """Read the map.

        Raises
        ------
        MapFileError
            If the file is no map.
        """
        return self.read_noted()[0]

    def read_noted(self) -> tuple[OccupancyGrid, list[str]]:
        """Read the map, and tell what was guessed about it, in lines for people."""
        notes = []
        if self.is_plain:
            grid, guess = read_image(self.path, **self.greys)
            told = "resolution not known" if self.resolution is None else f"resolution {self.resolution:g} m as given"
            notes.append(f"{self.given}: read with {guess} (--free, --occupied, --unknown say otherwise); {told}")
            if beside := [p for s in (".yaml", ".yml") if (p := self.path.with_suffix(s)).exists()]:
                notes.append(f"{self.given}: {beside[0].name} beside it is not read; give it to use what it tells")
        else:
            grid = read_map(self.path, dialect=self.dialect, strict_thresholds=self.strict)
        return (grid if self.resolution is None else replace(grid, resolution=self.resolution)), notes


def told_inputs(
    folder: str | Path, a: Input, b: Input, *, grids: Sequence[OccupancyGrid | None] = (None, None)
) -> dict[str, Any]:
    """Lay the maps of a merge out for the ``inputs`` of ``alignment.json``.

    Parameters
    ----------
    folder
        The merge's; the maps' paths are told from there, so that all may move together.
    a, b
        The maps.
    grids
        What was read of them, where it is at hand.

    Returns
    -------
    dict
        By "a" and "b": ``given``, ``path`` from the folder, how it was read, and the resolution and frame that came
        of it.
    """
    return {
        name: {
            "given": one.given,
            "path": os.path.relpath(_resolved(one.path), resolve_links(Path(folder))),
            **{grey: one.greys.get(grey) if one.is_plain else None for grey in GREYS},
            "dialect": one.dialect,
            "strict_thresholds": one.strict,
            "resolution": one.resolution,
            "metres_per_cell": None if grid is None else grid.resolution,
            "frame": None if grid is None else grid.frame,
        }
        for name, one, grid in zip("ab", (a, b), grids, strict=True)
    }


def inputs_of(file: AlignmentFile, *, a: Path | None = None, b: Path | None = None) -> tuple[Input, Input]:
    """Return the maps of an answer, or files named instead.

    Raises
    ------
    InputError
        If the answer does not name its maps, or one is no longer there.
    """
    return _input(file, "a", a), _input(file, "b", b)


def _input(file: AlignmentFile, name: str, instead: Path | None) -> Input:
    try:
        entry = file.record["inputs"][name]
        found = Input(
            given=str(entry["given"]),
            path=Path(os.path.normpath(resolve_links(file.path).parent / str(entry["path"]))),
            greys={grey: None if entry[grey] is None else int(entry[grey]) for grey in GREYS},
            dialect=entry["dialect"] if entry["dialect"] in DIALECTS else None,
            strict=bool(entry["strict_thresholds"]),
            resolution=None if entry["resolution"] is None else float(entry["resolution"]),
        )
    except (KeyError, TypeError, ValueError):
        if instead is None:
            raise InputError(f"{file.path}: does not say where map {name.upper()} lies; {REMEDY}") from None
        return Input(given=str(instead), path=instead, greys=dict.fromkeys(GREYS))
    if instead is not None:
        return replace(found, given=str(instead), path=instead)
    bag = split_bag(found.path)
    if not (found.path if bag is None else bag.file).exists():
        raise InputError(f"{found.path}: map {name.upper()} of {file.folder} is no longer there; {REMEDY}")
    return found


def _resolved(path: Path) -> Path:
    """Resolve a file's folder but not its own name: a link is read by the name it was given."""
    return resolve_links(path.parent) / path.name
