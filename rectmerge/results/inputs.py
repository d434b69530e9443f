"""Input maps of a merge, as its ``alignment.json`` names them, so that later commands find and read them again."""

from __future__ import annotations

import contextlib
import json
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
    """Input map of a command, with the options on how it is read.

    Parameters
    ----------
    given
        The name as it was given.
    path
        A file, or a topic of a bag.
    greys
        The grey levels of a plain image, by name; None where guessed.
    dialect
        The rules by which a YAML's image is read; None for those of the file.
    strict
        Whether the thresholds of a YAML are obeyed to the letter.
    resolution
        Metres per cell, instead of those of the file; None keeps them.
    """

    given: str
    path: Path
    greys: Mapping[str, int | None]
    dialect: Dialect | None = None
    strict: bool = False
    resolution: float | None = None

    @property
    def is_plain(self) -> bool:
        """Whether the map is a plain image."""
        return not (is_yaml(self.path) or is_bag(self.path))

    def read(self) -> OccupancyGrid:
        """Read the map.

        Raises
        ------
        MapFileError
            If the file is no map.
        """
        return self.read_with_notes()[0]

    def read_with_notes(self) -> tuple[OccupancyGrid, list[str]]:
        """Read the map, with notes for the user on everything that was guessed about it."""
        notes = []
        if self.is_plain:
            grid, guess = read_image(self.path, **self.greys)
            size = "resolution not known" if self.resolution is None else f"resolution {self.resolution:g} m as given"
            notes.append(f"{self.given}: read with {guess} (--free, --occupied, --unknown say otherwise); {size}")
            if sidecars := [p for s in (".yaml", ".yml") if (p := self.path.with_suffix(s)).exists()]:
                notes.append(f"{self.given}: {sidecars[0].name} beside it is not read; give it to use its values")
        else:
            grid = read_map(self.path, dialect=self.dialect, strict_thresholds=self.strict)
        return (grid if self.resolution is None else replace(grid, resolution=self.resolution)), notes


def inputs_json_dict(
    folder: str | Path, a: Input, b: Input, *, grids: Sequence[OccupancyGrid | None] = (None, None)
) -> dict[str, Any]:
    """Return the entry ``inputs`` of ``alignment.json`` for the maps of a merge.

    Parameters
    ----------
    folder
        The folder of the merge; the maps' paths are relative to it, so that all may move together.
    a, b
        The maps.
    grids
        The grids that were read from them, where known.

    Returns
    -------
    dict
        By "a" and "b": ``given``, ``path`` from the folder, the options on how it was read, and the resolution and
        frame of the grid.
    """
    return {
        name: input_json_dict(folder, map_input, grid)
        for name, map_input, grid in zip("ab", (a, b), grids, strict=True)
    }


def input_json_dict(folder: str | Path, map_input: Input, grid: OccupancyGrid | None) -> dict[str, Any]:
    """Return the entry of one map of a merge, as `inputs_json_dict` does for two."""
    return {
        "given": map_input.given,
        "path": os.path.relpath(_resolved(map_input.path), resolve_links(Path(folder))),
        **{grey: map_input.greys.get(grey) if map_input.is_plain else None for grey in GREYS},
        "dialect": map_input.dialect,
        "strict_thresholds": map_input.strict,
        "resolution": map_input.resolution,
        "metres_per_cell": None if grid is None else grid.resolution,
        "frame": None if grid is None else grid.frame,
    }


def saved_inputs(file: AlignmentFile, *, a: Path | None = None, b: Path | None = None) -> tuple[Input, Input]:
    """Return the input maps of a merge, or the files named instead.

    Raises
    ------
    InputError
        If the record does not name its maps, or one is no longer there.
    """
    return _input(file, "a", a), _input(file, "b", b)


def saved_input(entry: Mapping[str, Any], folder: Path) -> Input:
    """Return the input map that an entry of a record in a folder names.

    Raises
    ------
    KeyError, TypeError, ValueError
        If the entry is not whole.
    """
    return Input(
        given=str(entry["given"]),
        path=Path(os.path.normpath(folder / str(entry["path"]))),
        greys={grey: None if entry[grey] is None else int(entry[grey]) for grey in GREYS},
        dialect=entry["dialect"] if entry["dialect"] in DIALECTS else None,
        strict=bool(entry["strict_thresholds"]),
        resolution=None if entry["resolution"] is None else float(entry["resolution"]),
    )


def recorded_inputs(record: Path) -> list[Input]:
    """List the input maps that the record of a merge names, of two maps or many; none where it is not whole."""
    with contextlib.suppress(OSError, LookupError, TypeError, ValueError, AttributeError, RecursionError):
        entries = json.loads(record.read_text(encoding="utf-8"))["inputs"].values()
        return [saved_input(entry, resolve_links(record).parent) for entry in entries]
    return []


def _input(file: AlignmentFile, name: str, instead: Path | None) -> Input:
    try:
        map_input = saved_input(file.record["inputs"][name], resolve_links(file.path).parent)
    except (KeyError, TypeError, ValueError):
        if instead is None:
            raise InputError(f"{file.path}: does not say where map {name.upper()} lies; {REMEDY}") from None
        return Input(given=str(instead), path=instead, greys=dict.fromkeys(GREYS))
    if instead is not None:
        return replace(map_input, given=str(instead), path=instead)
    bag = split_bag(map_input.path)
    if not (map_input.path if bag is None else bag.file).exists():
        raise InputError(f"{map_input.path}: map {name.upper()} of {file.folder} is no longer there; {REMEDY}")
    return map_input


def _resolved(path: Path) -> Path:
    """Resolve a file's folder but not its own name, as a link is read by its given name."""
    return resolve_links(path.parent) / path.name
