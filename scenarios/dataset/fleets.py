"""Fleets of a data set: ``fleets.jsonl`` beside ``metadata.jsonl``, a line with the maps and the pairs of each."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rectmerge.errors import DatasetError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import read_map
from scenarios.dataset.metadata import METADATA, CheckedRow, check_row, metadata_lines, parse_row
from scenarios.dataset.reader import dataset_name, split_folders

FLEETS = "fleets.jsonl"
KEYS = ("fleet", "map_a", "map_b", "place_a", "place_b")  # columns of a row that is of a fleet


@dataclass(frozen=True, slots=True, kw_only=True)
class Fleet:
    """Maps that are merged together, and the pairs of them whose truth is known.

    Parameters
    ----------
    folder
        The split's folder, which file names are relative to.
    suite
        The data set's name.
    fleet_id
        Unique in its split.
    maps
        File of each map, by its name in the fleet, in order.
    places
        The building of each.
    pairs
        Ids of the pairs.
    is_growing
        Whether the maps come one after the other.
    """

    folder: Path
    suite: str
    fleet_id: str
    maps: Mapping[str, str]
    places: Mapping[str, str]
    pairs: tuple[str, ...]
    is_growing: bool = False

    def grids(self) -> dict[str, OccupancyGrid]:
        """Read the maps by name; a resolution is hidden unless the map's file is a YAML."""
        return {name: read_map(self.folder / file) for name, file in self.maps.items()}

    def rows(self) -> dict[tuple[str, str], CheckedRow]:
        """Read the rows of the pairs, by the names of both maps.

        Raises
        ------
        DatasetError
            If a pair has no row in ``metadata.jsonl``, or its row is of another fleet's maps.
        """
        wanted, found = set(self.pairs), {}
        for line in metadata_lines(self.folder):
            row = parse_row(line)
            if row.get("pair_id") in wanted:
                names = str(row.get("map_a")), str(row.get("map_b"))
                if not self.maps.keys() >= set(names):
                    raise DatasetError(f"{line.place}: map_a and map_b name no maps of the fleet {self.fleet_id}")
                found[names] = check_row(row, self.folder, self.suite, line.place)
        if len(found) < len(wanted):
            raise DatasetError(f"{self.folder / FLEETS}: {self.fleet_id}: some pairs have no row in {METADATA}")
        return found


@dataclass(slots=True)
class FleetLines:
    """Lines of ``fleets.jsonl``, gathered from the rows of pairs."""

    _lines: dict[tuple[str, str], dict[str, Any]] = field(default_factory=dict)

    def note(self, row: Mapping[str, Any]) -> None:
        """Learn from a row; one of no fleet says nothing."""
        if not all(row.get(key) for key in KEYS):
            return
        line = self._lines.setdefault(
            (row["split"], row["fleet"]),
            {"fleet_id": row["fleet"], "maps": {}, "places": {}, "pairs": [], "is_growing": bool(row["is_growing"])},
        )
        for side in "ab":
            name = row[f"map_{side}"]
            line["maps"][name] = row.get(f"map_{side}_yaml") or row[f"map_{side}_file_name"]
            line["places"][name] = row[f"place_{side}"]
        line["pairs"].append(row["pair_id"])

    def of_split(self, split: str) -> list[dict[str, Any]]:
        """Return the lines of a split, by fleet."""
        return [_ordered(line) for (own, _), line in sorted(self._lines.items()) if own == split]


def _ordered(line: Mapping[str, Any]) -> dict[str, Any]:
    names = sorted(line["maps"])
    by_name = {key: {name: line[key][name] for name in names} for key in ("maps", "places")}
    return {**line, **by_name, "pairs": sorted(line["pairs"])}


def read_fleets(path: str | Path) -> list[Fleet]:
    """Read the fleets of a data set, of all its splits.

    Raises
    ------
    DatasetError
        If it has none, or a line does not keep the layout; the message names file and line.
    """
    folders = [folder for folder in split_folders(Path(path)) if (folder / FLEETS).is_file()]
    if not folders:
        raise DatasetError(f"{path}: no data set of fleets: there is no {FLEETS} beside a {METADATA}")
    return [fleet for folder in folders for fleet in _fleets_in(folder, dataset_name(path))]


def _fleets_in(folder: Path, suite: str) -> Iterator[Fleet]:
    file = folder / FLEETS
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DatasetError(f"{file}: cannot be read: {error}") from error
    for number, text in enumerate(lines, start=1):
        try:
            line = json.loads(text)
            fleet = Fleet(
                folder=folder,
                suite=suite,
                fleet_id=str(line["fleet_id"]),
                maps={str(name): str(map_file) for name, map_file in line["maps"].items()},
                places={str(name): str(place) for name, place in line["places"].items()},
                pairs=tuple(map(str, line["pairs"])),
                is_growing=bool(line.get("is_growing", False)),
            )
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            raise DatasetError(f"{file}:{number}: not a fleet of the layout: {error!r}") from error
        if len(fleet.maps) < 2 or fleet.maps.keys() != fleet.places.keys():
            raise DatasetError(f"{file}:{number}: a fleet has two maps or more, and the place of each")
        for map_file in fleet.maps.values():
            if not (folder / map_file).resolve().is_relative_to(folder.resolve()):
                raise DatasetError(f"{file}:{number}: {map_file} leads out of the data set")
        yield fleet
