"""An answer put to use: as a transform that robots take, and on points that belong to map B."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Verdict
from rectmerge.answerfile import AnswerFile
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.overlap import cells_of
from rectmerge.similarity import Similarity

Form = Literal["ros1", "ros2", "matrix", "pose"]
FORMS: tuple[Form, ...] = get_args(Form)
SAMPLED_CELLS = 20_000


@dataclass(frozen=True, slots=True)
class SharedArea:
    """What both maps show, in B's map frame: its centre (x, y), the RMS distance of its cells from it, the unit."""

    centre: tuple[float, float]
    radius: float
    unit: str = "m"

    @classmethod
    def of(cls, a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity) -> SharedArea:
        """Find it under a placement of B's pixels on A's; all of B's free space where they share none."""
        cells = cells_of(b.free, SAMPLED_CELLS)[:, ::-1]
        at = np.rint(pixels.apply(cells)).astype(np.intp)
        inside = ((at >= 0) & (at < a.shape[::-1])).all(axis=1)
        u, v = at.clip(0, np.array(a.shape[::-1]) - 1).T
        shared = cells[inside & a.free[v, u]]
        points = b.pixel_to_map(shared if len(shared) else cells)
        centre = points.mean(axis=0)
        radius = float(np.sqrt(((points - centre) ** 2).sum(axis=1).mean()))
        return cls((float(centre[0]), float(centre[1])), radius, b.unit)

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {"centre": list(self.centre), "radius": self.radius, "unit": self.unit}


@dataclass(frozen=True, slots=True)
class Placed:
    """A placement as ``alignment.json`` tells it: from B's map frame to A's, the area both show, and A's unit."""

    b_to_a: Similarity
    shared: SharedArea
    unit: str

    @property
    def rigid(self) -> Similarity:
        """The same without scale, for TF carries none: fitted anew to the area that both maps show."""
        centre = np.asarray(self.shared.centre)
        turn = Similarity(1.0, self.b_to_a.angle)
        tx, ty = self.b_to_a.apply(centre) - turn.apply(centre)
        return Similarity(1.0, self.b_to_a.angle, float(tx), float(ty))

    @property
    def misfit(self) -> float:
        """RMS distance in A's map frame between the placement and `rigid` over the area that both maps show."""
        return abs(self.b_to_a.scale - 1) * self.shared.radius

    @property
    def in_cells(self) -> str:
        """Which maps are in cells, for want of a resolution, and the remedy; empty where both are in metres."""
        names = [name for name, unit in (("A", self.unit), ("B", self.shared.unit)) if unit != "m"]
        if not names:
            return ""
        maps = f"maps {' and '.join(names)} are" if len(names) > 1 else f"map {names[0]} is"
        options = " and ".join(f"--resolution-{name.lower()} METRES" for name in names)
        return f"{maps} in cells, not in metres; merge again with {options}"

    def line(self, form: Form, *, parent: str = "map_a", child: str = "map_b") -> str:
        """Tell the placement in a form that programs take: all but "matrix" without scale.

        Raises
        ------
        InputError
            If it is to be a line for TF, which is in metres, and a map is in cells.
        """
        if form in ("ros1", "ros2") and self.in_cells:
            raise InputError(f"TF is in metres: {self.in_cells}")
        rigid = self.rigid
        yaw = math.remainder(rigid.angle, math.tau)
        if form == "ros1":
            numbers = f"{rigid.tx:.6f} {rigid.ty:.6f} 0 {yaw:.8f} 0 0"
            return f"rosrun tf2_ros static_transform_publisher {numbers} {parent} {child}"
        if form == "ros2":
            return (
                f"ros2 run tf2_ros static_transform_publisher --x {rigid.tx:.6f} --y {rigid.ty:.6f} --z 0 "
                f"--yaw {yaw:.8f} --pitch 0 --roll 0 --frame-id {parent} --child-frame-id {child}"
            )
        if form == "pose":
            return f"{rigid.tx:.6f} {rigid.ty:.6f} {yaw:.8f}"
        return "\n".join(
            " ".join(f"{number:.9g}" for number in row) for row in [*self.b_to_a.matrix.tolist(), [0, 0, 1]]
        )


@dataclass(frozen=True, slots=True)
class Answer:
    """What a merge's folder tells: the verdict, its reason, and the candidates, best first."""

    verdict: Verdict
    reason: str
    candidates: tuple[Placed, ...]

    @classmethod
    def of(cls, file: AnswerFile) -> Answer:
        """Take what an answer tells.

        Raises
        ------
        InputError
            If it lacks a candidate's numbers.
        """
        with file.refusing():
            return cls(file.verdict, file.reason, tuple(map(_placed, file.told["candidates"])))

    def candidate(self, number: int) -> Placed:
        """Return a candidate, 1 being the best; refuses a number that there is not."""
        if not 1 <= number <= len(self.candidates):
            raise InputError(f"there is no candidate {number}; the answer holds {len(self.candidates)}")
        return self.candidates[number - 1]


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
        If the file holds no points.
    """
    is_geojson = Path(name).suffix.lower() in (".json", ".geojson")
    try:
        return _carry_geojson(text, b_to_a) if is_geojson else _carry_csv(text, b_to_a)
    except (ValueError, IndexError, TypeError, RecursionError, csv.Error) as error:
        kind = "GeoJSON" if is_geojson else "CSV with columns x and y"
        raise InputError(f"{name}: not {kind}: {error}") from None


def _placed(told: Mapping[str, Any]) -> Placed:
    placed, shared = told["b_to_a"], told["shared"]
    x, y = shared["centre"]
    b_to_a = Similarity(placed["scale"], placed["angle_rad"], *placed["translation"])
    area = SharedArea((x, y), shared["radius"], shared.get("unit", placed["unit"]))
    return Placed(b_to_a, area, placed["unit"])


def _carry_geojson(text: str, b_to_a: Similarity) -> str:
    found = json.loads(text)
    carried = _with_coordinates(found, b_to_a)
    if carried == found and "coordinates" not in text:
        raise ValueError("it holds no coordinates")
    return json.dumps(carried, indent=2) + "\n"


def _with_coordinates(value: Any, b_to_a: Similarity) -> Any:
    if isinstance(value, Mapping):
        return {
            key: _carried(inner, b_to_a) if key == "coordinates" else _with_coordinates(inner, b_to_a)
            for key, inner in value.items()
        }
    return [_with_coordinates(inner, b_to_a) for inner in value] if isinstance(value, list) else value


def _carried(coordinates: Any, b_to_a: Similarity) -> Any:
    """Carry one position [x, y, ...], or lists of them however deep."""
    if not isinstance(coordinates, list) or not coordinates:
        raise ValueError(f"coordinates must be lists of numbers, got {coordinates!r:.40}")
    if isinstance(coordinates[0], list):
        return [_carried(inner, b_to_a) for inner in coordinates]
    return [*_moved([coordinates[:2]], b_to_a)[0].tolist(), *coordinates[2:]]


def _carry_csv(text: str, b_to_a: Similarity) -> str:
    rows = [row for row in csv.reader(io.StringIO(text)) if row]
    heads = [cell.strip().lower() for cell in rows[0]]
    has_heads = "x" in heads and "y" in heads
    at_x, at_y = (heads.index("x"), heads.index("y")) if has_heads else (0, 1)
    points = rows[1:] if has_heads else rows
    moved = _moved([[float(row[at_x]), float(row[at_y])] for row in points], b_to_a)
    for row, (x, y) in zip(points, moved, strict=True):
        row[at_x], row[at_y] = f"{x:.6f}", f"{y:.6f}"
    written = io.StringIO()
    csv.writer(written, lineterminator="\n").writerows(rows)
    return written.getvalue()


def _moved(points: list[list[float]], b_to_a: Similarity) -> NDArray[np.float64]:
    array = np.asarray(points, np.float64).reshape(-1, 2)
    if not np.isfinite(array).all():
        raise ValueError("a coordinate is not a finite number")
    return b_to_a.apply(array).round(9)
