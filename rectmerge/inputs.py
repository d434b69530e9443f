"""The maps that a merge was given, as its ``alignment.json`` names them, so that they are found and read again."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.mapfile import is_yaml, read_image, read_map

GREYS = ("free", "occupied", "unknown")
REMEDY = "name the maps with --a FILE and --b FILE"


@dataclass(frozen=True, slots=True, kw_only=True)
class Input:
    """A map file of a merge, and how it was read.

    Parameters
    ----------
    given
        The path as the merge was given it.
    path
        Where it lies.
    greys
        The grey levels that were named for it, by name; None where guessed.
    strict
        Whether a YAML was taken at its word.
    """

    given: str
    path: Path
    greys: Mapping[str, int | None]
    strict: bool = False

    def read(self) -> OccupancyGrid:
        """Read the map as the merge did.

        Raises
        ------
        MapFileError
            If the file is no map.
        """
        if is_yaml(self.path):
            return read_map(self.path, strict_thresholds=self.strict)
        return read_image(self.path, **self.greys).grid


def told_inputs(
    folder: str | Path,
    a: str | Path,
    b: str | Path,
    *,
    levels: Mapping[str, int | None] | None = None,
    strict: bool = False,
) -> dict[str, Any]:
    """Lay the maps of a merge out for the ``inputs`` of ``alignment.json``.

    Parameters
    ----------
    folder
        The merge's; the maps' paths are told from there, so that all may move together.
    a, b
        The map files as they were given.
    levels
        The grey levels named for plain images.
    strict
        Whether YAMLs are taken at their word.

    Returns
    -------
    dict
        By "a" and "b": ``given``, ``path`` from the folder, the grey levels, and ``strict_thresholds``.
    """
    greys = {name: (levels or {}).get(name) for name in GREYS}
    return {
        name: {
            "given": str(path),
            "path": os.path.relpath(_resolved(Path(path)), Path(folder).resolve()),
            **(dict.fromkeys(GREYS) if is_yaml(path) else greys),
            "strict_thresholds": strict,
        }
        for name, path in (("a", a), ("b", b))
    }


def read_inputs(folder: str | Path) -> tuple[Path, Path]:
    """Return where the maps of a merge lie.

    Raises
    ------
    InputError
        If the folder holds no readable answer, or a map is no longer there.
    """
    a, b = inputs_of(read_told(folder), folder)
    return a.path, b.path


def inputs_of(
    told: Mapping[str, Any], folder: str | Path, *, a: Path | None = None, b: Path | None = None
) -> tuple[Input, Input]:
    """Return the maps of an answer that `read_told` read, or of files named instead.

    Raises
    ------
    InputError
        If the answer does not name its maps, or one is no longer there.
    """
    found = {name: _input(told, name, Path(folder), instead) for name, instead in (("a", a), ("b", b))}
    return found["a"], found["b"]


def read_told(folder: str | Path) -> dict[str, Any]:
    """Read the ``alignment.json`` of a merge.

    Raises
    ------
    InputError
        If the folder holds none, or what it holds is no JSON object.
    """
    path = Path(folder) / "alignment.json"
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; name the folder of a merge") from None
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not an answer of rectmerge merge: {error}; merge again") from None
    if not isinstance(told, dict):
        raise InputError(f"{path}: not an answer of rectmerge merge: no JSON object; merge again")
    return told


def _input(told: Mapping[str, Any], name: str, folder: Path, instead: Path | None) -> Input:
    try:
        entry = told["inputs"][name]
        greys = {grey: None if entry[grey] is None else int(entry[grey]) for grey in GREYS}
        given, path, strict = str(entry["given"]), str(entry["path"]), bool(entry["strict_thresholds"])
    except (KeyError, TypeError, ValueError):
        if instead is not None:
            return Input(given=str(instead), path=instead, greys=dict.fromkeys(GREYS))
        raise InputError(f"{folder / 'alignment.json'}: does not say where map {name.upper()} lies; {REMEDY}") from None
    if instead is not None:
        return Input(given=str(instead), path=instead, greys=greys, strict=strict)
    lies = Path(os.path.normpath(folder.resolve() / path))
    if not lies.is_file():
        raise InputError(f"{lies}: map {name.upper()} of {folder} is no longer there; {REMEDY}")
    return Input(given=given, path=lies, greys=greys, strict=strict)


def _resolved(path: Path) -> Path:
    """Resolve a file's folder but not its own name: a link is read by the name it was given."""
    return path.parent.resolve() / path.name
