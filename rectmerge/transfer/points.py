"""Points that belong to map B, carried to map A with their headings: CSV, GeoJSON and nav2's waypoints."""

from __future__ import annotations

import csv
import json
import logging
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from rectmerge.transfer.csv_points import carry_table
from rectmerge.transfer.poses import CARRIED, TURN, left_alone, moved, short, turned
from rectmerge.transfer.waypoints import carry_waypoints

LOGGER = logging.getLogger("rectmerge")

GEOMETRIES = ("Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon")
HOLDS = {  # where objects of each type have their places; whatever stands elsewhere is not ours
    "FeatureCollection": "features",
    "Feature": "geometry",
    "GeometryCollection": "geometries",
    **dict.fromkeys(GEOMETRIES, "coordinates"),
}


def carry_points(text: str, name: str, b_to_a: Similarity) -> str:
    """Take the points of a file from B's map frame to A's, and their headings with them; all else in it stays.

    Parameters
    ----------
    text
        GeoJSON; nav2's waypoints, see `rectmerge.transfer.waypoints`; or CSV, see `rectmerge.transfer.csv_points`.
    name
        The file's name: it tells which of them, and stands in messages.
    b_to_a
        The placement.

    Raises
    ------
    InputError
        If it is none of them, or a CSV holds no points. A GeoJSON may hold none.

    Notes
    -----
    The names of headings are those of `rectmerge.transfer.poses.turned`: columns of a CSV, properties of a Point in
    GeoJSON. Where another name looks like a heading's, the logger `rectmerge` warns.
    """
    if not text.strip():
        raise InputError(f"{name}: the file is empty")
    kind, carry = _reader(Path(name).suffix.lower())
    try:
        return carry(text, b_to_a)
    except (ValueError, TypeError, OverflowError, RecursionError, csv.Error) as error:
        raise InputError(f"{name}: not {kind}: {error}") from None


def _reader(suffix: str) -> tuple[str, Callable[[str, Similarity], str]]:
    if suffix in (".json", ".geojson"):
        return "GeoJSON", _carry_geojson
    if suffix in (".yaml", ".yml"):
        return "nav2's waypoints", carry_waypoints
    return "CSV with columns x and y", carry_table


def _carry_geojson(text: str, b_to_a: Similarity) -> str:
    told = json.loads(text)
    carried = _carried_object(told, b_to_a)
    for name in dict.fromkeys(_headings_left(told)):
        LOGGER.warning("property %s stays as it is; of a Point those named %s are turned", name, ", ".join(TURN))
    return json.dumps(carried, indent=2) + "\n"


def _carried_object(told: Any, b_to_a: Similarity) -> dict[str, Any]:
    """Carry an object of GeoJSON (RFC 7946), with the box that it may tell around its places."""
    if not isinstance(told, dict):
        raise ValueError(f"an object must stand where there is {short(told)}")
    if told.get("type") not in HOLDS:
        raise ValueError(f"there is no type {short(told.get('type'))}")
    key = HOLDS[told["type"]]
    if key not in told:
        raise ValueError(f"a {told['type']} has no {key}")
    carried = told | {key: _carried_part(key, told[key], b_to_a)}
    if _is_point(told) and isinstance(told.get("properties"), dict):
        carried["properties"] = told["properties"] | turned(told["properties"], b_to_a.angle)
    if "bbox" in told:
        del carried["bbox"]
        if columns := list(zip(*_positions(carried), strict=False)):  # as many as the shortest position has
            carried["bbox"] = [*map(min, columns), *map(max, columns)]
    return carried


def _is_point(told: Mapping[str, Any]) -> bool:
    """Whether a heading among its properties is that of one place."""
    return told["type"] == "Feature" and told["geometry"] is not None and told["geometry"]["type"] == "Point"


def _headings_left(told: Mapping[str, Any]) -> Iterator[str]:
    """Name the properties of features that look like headings and are not carried."""
    for one in told["features"] if told["type"] == "FeatureCollection" else [told]:
        if one["type"] == "Feature" and isinstance(one.get("properties"), dict):
            names = [name for name in one["properties"] if one["properties"][name] is not None]
            yield from left_alone(names)
            yield from () if _is_point(one) else (name for name in names if name.strip().lower() in CARRIED)


def _carried_part(key: str, part: Any, b_to_a: Similarity) -> Any:
    if key == "coordinates":
        return _carried(part, b_to_a)
    if key == "geometry":
        return None if part is None else _carried_object(part, b_to_a)
    if not isinstance(part, list):
        raise ValueError(f"{key} must be a list, got {short(part)}")
    return [_carried_object(one, b_to_a) for one in part]


def _carried(coordinates: Any, b_to_a: Similarity) -> Any:
    """Carry one position [x, y, ...], or lists of them however deep; an empty list is no place, and legal."""
    if not isinstance(coordinates, list):
        raise ValueError(f"coordinates must be lists of numbers, got {short(coordinates)}")
    if not coordinates or isinstance(coordinates[0], list):
        return [_carried(inner, b_to_a) for inner in coordinates]
    if len(coordinates) < 2 or any(isinstance(one, bool) or not isinstance(one, int | float) for one in coordinates):
        raise ValueError(f"a position must be two numbers or more, got {short(coordinates)}")
    return [*moved([coordinates[:2]], b_to_a)[0].tolist(), *coordinates[2:]]


def _positions(part: Any) -> Iterator[list[float]]:
    """Every position in an object, or in lists however deep."""
    if isinstance(part, Mapping):
        yield from _positions(part[HOLDS[part["type"]]])
    elif isinstance(part, list) and part and not isinstance(part[0], list | Mapping):
        yield part
    else:
        for inner in part or ():
            yield from _positions(inner)
