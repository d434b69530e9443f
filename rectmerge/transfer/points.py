"""Points and headings of map B carried to map A: CSV, GeoJSON and nav2's waypoints."""

from __future__ import annotations

import csv
import json
import logging
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from rectmerge.elastic.transform import BentTransform
from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from rectmerge.transfer.carrier import STD_NAME, Carrier
from rectmerge.transfer.csv_points import carry_table
from rectmerge.transfer.poses import CARRIED, TURN, abbreviate, turn_headings, unknown_headings
from rectmerge.transfer.waypoints import carry_waypoints

LOGGER = logging.getLogger("rectmerge")

GEOMETRIES = ("Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon")
CONTENT_KEYS = {  # the member of each type of object that leads to its places
    "FeatureCollection": "features",
    "Feature": "geometry",
    "GeometryCollection": "geometries",
    **dict.fromkeys(GEOMETRIES, "coordinates"),
}


def carry_points(text: str, name: str, b_to_a: Similarity | BentTransform) -> str:
    """Carry the points and headings of a file from B's map frame to A's; keep everything else.

    Parameters
    ----------
    text
        GeoJSON; nav2's waypoints, see `rectmerge.transfer.waypoints`; or CSV, see `rectmerge.transfer.csv_points`.
    name
        The file's name: its suffix selects the format, and messages contain it.
    b_to_a
        The placement; where it bends, headings turn by the turn at their place, and each row of a CSV with a header,
        and each Point of a GeoJSON, gets its standard deviation, ``bend_std``; empty where the bend was not fitted.

    Raises
    ------
    InputError
        If the file is not valid, or a CSV holds no points. A GeoJSON may hold none.

    Notes
    -----
    The names of headings are those of `rectmerge.transfer.poses.turn_headings`: columns of a CSV, properties of a Point
    in GeoJSON. Where another name looks like a heading's, or a bend was not fitted at a place, the logger `rectmerge`
    warns.
    """
    if not text.strip():
        raise InputError(f"{name}: the file is empty")
    file_format, carry = _format_for(Path(name).suffix.lower())
    try:
        carrier = Carrier(b_to_a)
        carried = carry(text, carrier)
    except (ValueError, TypeError, OverflowError, RecursionError, csv.Error) as error:
        raise InputError(f"{name}: not {file_format}: {error}") from None
    if carrier.outside:
        LOGGER.warning("%d points lie outside the bend: they are carried as the nearest edge of it is", carrier.outside)
    return carried


def _format_for(suffix: str) -> tuple[str, Callable[[str, Carrier], str]]:
    if suffix in (".json", ".geojson"):
        return "GeoJSON", _carry_geojson
    if suffix in (".yaml", ".yml"):
        return "nav2's waypoints", carry_waypoints
    return "CSV with columns x and y", carry_table


def _carry_geojson(text: str, carrier: Carrier) -> str:
    document = json.loads(text)
    carried = _carry_object(document, carrier)
    for name in dict.fromkeys(_headings_left(document)):
        LOGGER.warning("property %s stays as it is; of a Point those named %s are turned", name, ", ".join(TURN))
    return json.dumps(carried, indent=2) + "\n"


def _carry_object(item: Any, carrier: Carrier) -> dict[str, Any]:
    """Carry an object of GeoJSON (RFC 7946), with its bounding box if it has one."""
    if not isinstance(item, dict):
        raise ValueError(f"an object must stand where there is {abbreviate(item)}")
    if item.get("type") not in CONTENT_KEYS:
        raise ValueError(f"there is no type {abbreviate(item.get('type'))}")
    key = CONTENT_KEYS[item["type"]]
    if key not in item:
        raise ValueError(f"a {item['type']} has no {key}")
    carried = item | {key: _carry_content(key, item[key], carrier)}
    if _is_point(item) and isinstance(item.get("properties"), dict):
        carried["properties"] = item["properties"] | _carry_properties(item, carrier)
    if "bbox" in item:
        del carried["bbox"]
        if columns := list(zip(*_positions(carried), strict=False)):  # as many as the shortest position has
            carried["bbox"] = [*map(min, columns), *map(max, columns)]
    return carried


def _carry_properties(item: Mapping[str, Any], carrier: Carrier) -> dict[str, Any]:
    """Return the turned headings of a Point, and where the placement bends its standard deviation."""
    place = item["geometry"]["coordinates"][:2]
    if not place:
        return {}
    turned: dict[str, Any] = dict(turn_headings(item["properties"], carrier.turn_at(place)))
    return turned | ({STD_NAME: carrier.std_at(place)} if carrier.is_bent else {})


def _is_point(item: Mapping[str, Any]) -> bool:
    """Return if a heading among its properties is that of one place."""
    return item["type"] == "Feature" and item["geometry"] is not None and item["geometry"]["type"] == "Point"


def _headings_left(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield the names of features' properties that look like headings and are not carried."""
    for feature in document["features"] if document["type"] == "FeatureCollection" else [document]:
        if feature["type"] == "Feature" and isinstance(feature.get("properties"), dict):
            names = [name for name, value in feature["properties"].items() if value is not None]
            yield from unknown_headings(names)
            yield from () if _is_point(feature) else (name for name in names if name.strip().lower() in CARRIED)


def _carry_content(key: str, content: Any, carrier: Carrier) -> Any:
    if key == "coordinates":
        return _carry_coordinates(content, carrier)
    if key == "geometry":
        return None if content is None else _carry_object(content, carrier)
    if not isinstance(content, list):
        raise ValueError(f"{key} must be a list, got {abbreviate(content)}")
    return [_carry_object(item, carrier) for item in content]


def _carry_coordinates(coordinates: Any, carrier: Carrier) -> Any:
    """Carry one position [x, y, ...], or lists of them at any depth; an empty list is legal and has no place."""
    if not isinstance(coordinates, list):
        raise ValueError(f"coordinates must be lists of numbers, got {abbreviate(coordinates)}")
    if not coordinates or isinstance(coordinates[0], list):
        return [_carry_coordinates(inner, carrier) for inner in coordinates]
    if len(coordinates) < 2 or not all(isinstance(x, int | float) and not isinstance(x, bool) for x in coordinates):
        raise ValueError(f"a position must be two numbers or more, got {abbreviate(coordinates)}")
    return [*carrier.carry([coordinates[:2]])[0].tolist(), *coordinates[2:]]


def _positions(content: Any) -> Iterator[list[float]]:
    """Yield every position in an object, or in lists at any depth."""
    if isinstance(content, Mapping):
        yield from _positions(content[CONTENT_KEYS[content["type"]]])
    elif isinstance(content, list) and content and not isinstance(content[0], list | Mapping):
        yield content
    else:
        for inner in content or ():
            yield from _positions(inner)
