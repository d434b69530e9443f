"""Record of a merge of many maps, ``fleet.json``, and its transforms, as they are written and read."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from rectmerge.analysis.overlap import cells_of
from rectmerge.analysis.shared_area import SAMPLED_CELLS, SharedArea
from rectmerge.elastic.bend import Bend
from rectmerge.elastic.transform import BentTransform
from rectmerge.errors import InputError
from rectmerge.fleet.graph import SCHEMA, AlignmentGraph
from rectmerge.grid import OccupancyGrid
from rectmerge.io.atomic_file import resolve_links
from rectmerge.results.alignment_json import FLEET_NAME, explain_errors
from rectmerge.results.folder import BEND_NAME, note_interrupted
from rectmerge.results.inputs import saved_input
from rectmerge.results.saved_bend import bend_of
from rectmerge.similarity import Similarity
from rectmerge.transfer.transform import Transform


def to_json_dict(
    graph: AlignmentGraph,
    maps: Mapping[str, OccupancyGrid],
    inputs: Mapping[str, Mapping[str, Any]],
    merged: Sequence[str | None],
    bends: Mapping[str, Bend],
    settings: Mapping[str, Any],
) -> dict[str, Any]:
    """Return the content of ``fleet.json``.

    Parameters
    ----------
    graph
        The graph.
    maps
        The maps by name.
    inputs
        The files of the maps, as `rectmerge.results.inputs.input_json_dict` names them.
    merged
        File of the merged map of each component; None where none was written.
    bends
        Bends that were tried, by the name of the bent map.
    settings
        Settings of the method, without which the answers of the pairs say nothing.
    """
    record = graph.as_dict() | {"merged": list(merged), "inputs": dict(inputs), "settings": dict(settings)}
    for name, entry in record["placements"].items():
        entry["shared"] = _free_area(maps[name]).as_dict()
        if name in bends:
            entry["unbent"] = dict(bends[name].as_dict())
    return record


def transforms_yaml(graph: AlignmentGraph, merged: Sequence[str | None]) -> bytes:
    """Return the content of ``transforms.yaml``: each map's frame in that of its component's reference."""
    components = [
        {
            "reference": names[0],
            "merged": file,
            "transforms": [
                {
                    "map": name,
                    "x": place.to_reference.tx,
                    "y": place.to_reference.ty,
                    "yaw": place.to_reference.angle,
                    "scale": place.to_reference.scale,
                    "unit": place.unit,
                    "confidence": place.confidence,
                }
                for name, place in ((name, graph.placements[name]) for name in names)
            ],
        }
        for names, file in zip(graph.components, merged, strict=True)
    ]
    about = "# p_reference = scale R(yaw) p_map + (x, y); yaw in radians, counter-clockwise\n"
    data = {"components": components, "left_out": dict(graph.left_out)}
    return (about + yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=240)).encode()


@dataclass(frozen=True, slots=True)
class SavedPlacement:
    """Placement of a map read from ``fleet.json``.

    Parameters
    ----------
    name, reference
        Names of the map and of the reference of its component.
    transform
        From the map's frame to the reference's.
    frames
        Names of the reference's and the map's own frame; None where the maps have none.
    largest_move
        Greatest move of the map's walls by its bend, in cells; 0 where it was not bent.
    """

    name: str
    reference: str
    transform: Transform
    frames: tuple[str | None, str | None]
    largest_move: float = 0.0

    def frame_names(self, parent: str | None = None) -> tuple[str, str]:
        """Return the names of the frames: the maps' own where they differ, else the names of the maps."""
        a, b = self.frames
        names = (a, b) if a and b and a != b else (self.reference, self.name)
        return (names[0] if parent is None else parent), names[1]


@dataclass(frozen=True, slots=True)
class FleetFile:
    """The ``fleet.json`` of an earlier merge: its placements, the reasons of the maps left out, and the record."""

    path: Path
    placements: tuple[SavedPlacement, ...]
    left_out: Mapping[str, str]
    record: Mapping[str, Any]

    @staticmethod
    def find(path: Path) -> Path | None:
        """Return the ``fleet.json`` that a path names, itself or its folder; None where there is none."""
        for file in (path, path / FLEET_NAME):
            try:
                if file.name == FLEET_NAME:
                    note_interrupted(file.parent)
                if file.name == FLEET_NAME and file.is_file():
                    return file
            except OSError:  # a name too long
                continue
        return None

    def placement(self, name: str) -> SavedPlacement:
        """Return the placement of a map.

        Raises
        ------
        InputError
            If the map is a reference, was left out, or is none of the merge.
        """
        by_name = {placement.name: placement for placement in self.placements}
        if name in by_name:
            return by_name[name]
        why = self.left_out.get(name, "it is the reference" if name in self.record["inputs"] else "")
        fault = f"{name} has no placement: {why}" if why else f"{name} is no map of this merge"
        raise InputError(f"{self.path}: {fault}; placed are {', '.join(by_name)}")

    def bend(self, name: str) -> BentTransform | None:
        """Read the bend of a placed map; None where it was not bent.

        Raises
        ------
        InputError
            If it was bent, but the file beside the record is missing, or not of this merge.
        """
        if not self.placement(name).largest_move:
            return None
        path = self.path.parent / BEND_NAME
        with explain_errors(path):
            content = json.loads(path.read_text(encoding="utf-8"))["maps"][name]
            return bend_of(content, self.record["placements"][name]["to_reference"])

    @classmethod
    def read(cls, path: Path) -> FleetFile:
        """Read the record of a merge of many maps.

        Raises
        ------
        InputError
            If the file cannot be read, or `rectmerge merge` did not write it.
        """
        with explain_errors(path):
            record = json.loads(path.read_text(encoding="utf-8"))
            if record["schema"] != SCHEMA:
                raise ValueError(f"its schema is {record['schema']!r:.60}, not {SCHEMA!r}")
            placements = tuple(
                _placement(record, name, names[0]) for names in record["components"] for name in names[1:]
            )
            left_out = {str(name): str(reason) for name, reason in record["left_out"].items()}
        return cls(path, placements, left_out, record)


def read_inputs(file: FleetFile) -> dict[str, OccupancyGrid]:
    """Read the maps of a merge by name.

    Raises
    ------
    InputError
        If the record does not name them, or one cannot be read.
    """
    folder = resolve_links(file.path).parent
    try:
        inputs = {str(name): saved_input(entry, folder) for name, entry in file.record["inputs"].items()}
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(f"{file.path}: does not say where the maps lie; merge again") from None
    return {name: map_input.read() for name, map_input in inputs.items()}


def _placement(record: Mapping[str, Any], name: str, reference: str) -> SavedPlacement:
    entry, inputs = record["placements"][name], record["inputs"]
    place, shared = entry["to_reference"], entry["shared"]
    x, y = shared["centre"]
    resolutions = [inputs[one]["metres_per_cell"] for one in (reference, name)]
    transform = Transform(
        Similarity(place["scale"], place["angle_rad"], *place["translation"]),
        SharedArea((x, y), shared["radius"], shared["unit"]),
        place["unit"],
        None if None in resolutions else (float(resolutions[0]), float(resolutions[1])),
    )
    unbent = entry.get("unbent", {})
    moved = float(unbent["largest_move"]) if unbent.get("accepted") else 0.0
    return SavedPlacement(name, reference, transform, (inputs[reference]["frame"], inputs[name]["frame"]), moved)


def _free_area(grid: OccupancyGrid) -> SharedArea:
    """Measure the free area of a map: to it a transform without scale is fitted."""
    points = grid.pixel_to_map(cells_of(grid.free, SAMPLED_CELLS)[:, ::-1])
    centre = points.mean(axis=0)
    radius = float(np.sqrt(((points - centre) ** 2).sum(axis=1).mean()))
    return SharedArea((float(centre[0]), float(centre[1])), radius, grid.unit)
