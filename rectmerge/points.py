"""Points that belong to map B, carried to map A: CSV and GeoJSON, in which all else stays as it is."""

from __future__ import annotations

import contextlib
import csv
import io
import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity

GEOMETRIES = ("Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon")
HOLDS = {  # where objects of each type have their places; whatever stands elsewhere is not ours
    "FeatureCollection": "features",
    "Feature": "geometry",
    "GeometryCollection": "geometries",
    **dict.fromkeys(GEOMETRIES, "coordinates"),
}


def carry_points(text: str, name: str, b_to_a: Similarity) -> str:
    """Take the points of a file from B's map frame to A's; all else in it stays.

    Parameters
    ----------
    text
        GeoJSON, or CSV with columns x and y, or without a heading and the first two columns x and y.
    name
        The file's name: it tells which of the two, and stands in messages.
    b_to_a
        The placement.

    Raises
    ------
    InputError
        If it is neither, or a CSV holds no points. A GeoJSON may hold none.
    """
    if not text.strip():
        raise InputError(f"{name}: the file is empty")
    is_geojson = Path(name).suffix.lower() in (".json", ".geojson")
    try:
        return _carry_geojson(text, b_to_a) if is_geojson else _carry_csv(text, b_to_a)
    except (ValueError, TypeError, OverflowError, RecursionError, csv.Error) as error:
        kind = "GeoJSON" if is_geojson else "CSV with columns x and y"
        raise InputError(f"{name}: not {kind}: {error}") from None


def _carry_geojson(text: str, b_to_a: Similarity) -> str:
    return json.dumps(_carried_object(json.loads(text), b_to_a), indent=2) + "\n"


def _carried_object(told: Any, b_to_a: Similarity) -> dict[str, Any]:
    """Carry an object of GeoJSON (RFC 7946), with the box that it may tell around its places."""
    if not isinstance(told, dict):
        raise ValueError(f"an object must stand where there is {_short(told)}")
    if told.get("type") not in HOLDS:
        raise ValueError(f"there is no type {_short(told.get('type'))}")
    key = HOLDS[told["type"]]
    if key not in told:
        raise ValueError(f"a {told['type']} has no {key}")
    carried = told | {key: _carried_part(key, told[key], b_to_a)}
    if "bbox" in told:
        del carried["bbox"]
        if columns := list(zip(*_positions(carried), strict=False)):  # as many as the shortest position has
            carried["bbox"] = [*map(min, columns), *map(max, columns)]
    return carried


def _carried_part(key: str, part: Any, b_to_a: Similarity) -> Any:
    if key == "coordinates":
        return _carried(part, b_to_a)
    if key == "geometry":
        return None if part is None else _carried_object(part, b_to_a)
    if not isinstance(part, list):
        raise ValueError(f"{key} must be a list, got {_short(part)}")
    return [_carried_object(one, b_to_a) for one in part]


def _carried(coordinates: Any, b_to_a: Similarity) -> Any:
    """Carry one position [x, y, ...], or lists of them however deep; an empty list is no place, and legal."""
    if not isinstance(coordinates, list):
        raise ValueError(f"coordinates must be lists of numbers, got {_short(coordinates)}")
    if not coordinates or isinstance(coordinates[0], list):
        return [_carried(inner, b_to_a) for inner in coordinates]
    if len(coordinates) < 2 or any(isinstance(one, bool) or not isinstance(one, int | float) for one in coordinates):
        raise ValueError(f"a position must be two numbers or more, got {_short(coordinates)}")
    return [*_moved([coordinates[:2]], b_to_a)[0].tolist(), *coordinates[2:]]


def _positions(part: Any) -> Iterator[list[float]]:
    """Every position in an object, or in lists however deep."""
    if isinstance(part, Mapping):
        yield from _positions(part[HOLDS[part["type"]]])
    elif isinstance(part, list) and part and not isinstance(part[0], list | Mapping):
        yield part
    else:
        for inner in part or ():
            yield from _positions(inner)


def _carry_csv(text: str, b_to_a: Similarity) -> str:
    lines = csv.reader(io.StringIO(text))
    rows = [(lines.line_num, row) for row in lines if row]
    heads = [cell.strip().lower() for cell in rows[0][1]]
    has_heads = "x" in heads and "y" in heads
    at = (heads.index("x"), heads.index("y")) if has_heads else (0, 1)
    points = rows[1:] if has_heads else rows
    if not points:
        raise ValueError("it holds no points")
    moved = _moved([[_number(line, row, column) for column in at] for line, row in points], b_to_a)
    for (_, row), place in zip(points, moved, strict=True):
        for column, number in zip(at, place, strict=True):
            row[column] = f"{number:.6f}"
    written = io.StringIO()
    csv.writer(written, lineterminator="\n").writerows(row for _, row in rows)
    return written.getvalue()


def _number(line: int, row: list[str], column: int) -> float:
    if column >= len(row):
        raise ValueError(f"line {line} has too few columns: {_short(','.join(row))}")
    with contextlib.suppress(ValueError):
        if math.isfinite(number := float(row[column])):
            return number
    raise ValueError(f"line {line}: {_short(row[column])} is not a finite number")


def _moved(points: list[list[float]], b_to_a: Similarity) -> NDArray[np.float64]:
    with np.errstate(over="ignore", invalid="ignore"):
        moved = b_to_a.apply(np.asarray(points, np.float64).reshape(-1, 2)).round(9)
    if not np.isfinite(moved).all():
        raise ValueError("a coordinate is not a finite number, or too large to be carried")
    return moved


def _short(value: object) -> str:
    return f"{value!r:.40}"
