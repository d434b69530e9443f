"""World as pure data: walls, furniture, rooms and doors of one building, and its exact raster."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

SCAN_HEIGHT_M = 0.25  # height of the laser plane: the raster shows what this plane cuts


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """Prism: a convex outline extruded from `bottom` to `top`.

    Parameters
    ----------
    outline
        Corners counter-clockwise, shape (N, 2), N >= 3, metres.
    top, bottom
        Heights above the floor, metres.

    Raises
    ------
    InputError
        If the outline is not convex and counter-clockwise, or the heights are not ordered.
    """

    outline: NDArray[np.float64]
    top: float
    bottom: float = 0.0

    def __post_init__(self) -> None:
        corners = _read_only(self.outline)
        if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
            raise InputError(f"an outline has shape (N, 2) with N >= 3, got {corners.shape}")
        edges = np.roll(corners, -1, axis=0) - corners
        after = np.roll(edges, -1, axis=0)
        if not (edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0] > -1e-9).all():
            raise InputError("an outline must be convex and counter-clockwise")
        if not 0 <= self.bottom < self.top:
            raise InputError(f"heights must satisfy 0 <= bottom < top, got {self.bottom} and {self.top}")
        object.__setattr__(self, "outline", corners)

    def covers(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return the mask of the points, shape (..., 2), that lie inside the outline or on its rim."""
        return covers(self.outline, points)


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """Room: its name, its outline (N, 2) convex and counter-clockwise, and a spot (2,) where a robot can stand."""

    name: str
    outline: NDArray[np.float64]
    spot: NDArray[np.float64]

    @property
    def area_m2(self) -> float:
        """Area of the outline, square metres."""
        x, y = self.outline.T
        return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


@dataclass(frozen=True, slots=True, eq=False)
class Door:
    """Opening in a wall: the two ends of its gap, shape (2, 2), and the names of the two rooms that it joins.

    The leaf of a shut door is among the walls, or among the objects of a single visit.
    """

    ends: NDArray[np.float64]
    joins: tuple[str, str]
    is_open: bool = True

    @property
    def centre(self) -> NDArray[np.float64]:
        """Centre of the gap, shape (2,)."""
        middle: NDArray[np.float64] = self.ends.mean(axis=0)
        return middle

    @property
    def width_m(self) -> float:
        """Length of the gap, metres."""
        return float(np.hypot(*(self.ends[1] - self.ends[0])))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class World:
    """Building: its obstacles, rooms, doors and floor.

    Parameters
    ----------
    size
        (x, y) in metres; everything lies in 0..x, 0..y.
    walls, furniture
        Obstacles for robots and rays.
    glass
        Obstacles for robots that let most rays pass.
    visits
        Obstacles present only while robot A maps, and only while B does: moved furniture, shut doors.
    rooms, doors
        The corridor is a room like the others.
    floor
        Outlines (N, 2), convex and counter-clockwise, of floor that belongs to no room.
    family, seed
        Origin of the building.
    """

    size: tuple[float, float]
    walls: tuple[Prism, ...]
    furniture: tuple[Prism, ...] = ()
    glass: tuple[Prism, ...] = ()
    visits: tuple[tuple[Prism, ...], tuple[Prism, ...]] = ((), ())
    rooms: tuple[Room, ...] = ()
    doors: tuple[Door, ...] = ()
    floor: tuple[NDArray[np.float64], ...] = ()
    family: str = ""
    seed: int = 0

    @property
    def obstacles(self) -> tuple[Prism, ...]:
        """Walls, furniture and glass: the obstacles of both visits."""
        return self.walls + self.furniture + self.glass

    @property
    def ground(self) -> tuple[NDArray[np.float64], ...]:
        """Outlines of all floor: outside rooms, in rooms, and in the gaps of doors; walls may stand on it."""
        return (*self.floor, *(room.outline for room in self.rooms), *(_gap(door) for door in self.doors))

    def at_visit(self, visit: int) -> World:
        """Return the world during the visit of robot A (0) or robot B (1), without objects of single visits."""
        return replace(self, furniture=self.furniture + self.visits[visit], visits=((), ()))

    def turned(self, yaw: float) -> World:
        """Turn everything by `yaw` radians counter-clockwise, and shift it so that it lies in 0..x, 0..y again."""
        every = [p.outline for p in (*self.obstacles, *self.visits[0], *self.visits[1])]
        every += [*self.floor, *(room.outline for room in self.rooms)]
        cos, sin = math.cos(yaw), math.sin(yaw)
        turn = np.array([[cos, sin], [-sin, cos]])  # for rows
        corners = np.concatenate(every) @ turn
        low, high = corners.min(axis=0), corners.max(axis=0)

        def moved(points: NDArray[np.float64]) -> NDArray[np.float64]:
            return _read_only(points @ turn - low)

        def prisms(group: tuple[Prism, ...]) -> tuple[Prism, ...]:
            return tuple(replace(p, outline=moved(p.outline)) for p in group)

        return replace(
            self,
            size=(float(high[0] - low[0]), float(high[1] - low[1])),
            walls=prisms(self.walls),
            furniture=prisms(self.furniture),
            glass=prisms(self.glass),
            visits=(prisms(self.visits[0]), prisms(self.visits[1])),
            rooms=tuple(Room(r.name, moved(r.outline), moved(r.spot)) for r in self.rooms),
            doors=tuple(replace(d, ends=moved(d.ends)) for d in self.doors),
            floor=tuple(moved(outline) for outline in self.floor),
        )

    def raster(self, resolution: float, *, height_m: float = SCAN_HEIGHT_M) -> OccupancyGrid:
        """Draw the exact plan at the height of a laser, without the objects of single visits.

        Parameters
        ----------
        resolution
            Metres per cell.
        height_m
            Height of the laser plane above the floor.

        Returns
        -------
        OccupancyGrid
            Occupied where a cell's centre lies in an obstacle, free where it lies in a room or on other floor, unknown
            elsewhere; origin (0, 0, 0).

        Raises
        ------
        InputError
            If the resolution is not positive.
        """
        if not (math.isfinite(resolution) and resolution > 0):
            raise InputError(f"resolution must be a positive number of metres per cell, got {resolution}")
        shape = (math.ceil(self.size[1] / resolution - 1e-9), math.ceil(self.size[0] / resolution - 1e-9))
        cells = np.full(shape, UNKNOWN, dtype=np.int8)
        _fill(cells, self.ground, FREE, resolution)
        seen = (p.outline for p in self.obstacles if p.bottom <= height_m < p.top)
        _fill(cells, seen, OCCUPIED, resolution)
        return OccupancyGrid(cells[::-1], resolution)

    def to_json_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; `from_json_dict` reads it back exactly."""
        return {
            "size": list(self.size),
            "walls": [_prism_dict(p) for p in self.walls],
            "furniture": [_prism_dict(p) for p in self.furniture],
            "glass": [_prism_dict(p) for p in self.glass],
            "visits": [[_prism_dict(p) for p in visit] for visit in self.visits],
            "rooms": [{"name": r.name, "outline": r.outline.tolist(), "spot": r.spot.tolist()} for r in self.rooms],
            "doors": [{"ends": d.ends.tolist(), "joins": list(d.joins), "is_open": d.is_open} for d in self.doors],
            "floor": [outline.tolist() for outline in self.floor],
            "family": self.family,
            "seed": self.seed,
        }

    @classmethod
    def from_json_dict(cls, data: Mapping[str, Any]) -> World:
        """Read the data that `to_json_dict` returned."""
        return cls(
            size=(float(data["size"][0]), float(data["size"][1])),
            walls=_prisms(data["walls"]),
            furniture=_prisms(data["furniture"]),
            glass=_prisms(data["glass"]),
            visits=(_prisms(data["visits"][0]), _prisms(data["visits"][1])),
            rooms=tuple(Room(r["name"], _read_only(r["outline"]), _read_only(r["spot"])) for r in data["rooms"]),
            doors=tuple(
                Door(_read_only(d["ends"]), (d["joins"][0], d["joins"][1]), d["is_open"]) for d in data["doors"]
            ),
            floor=tuple(_read_only(outline) for outline in data["floor"]),
            family=str(data["family"]),
            seed=int(data["seed"]),
        )


def bar(
    start: NDArray[np.float64], end: NDArray[np.float64], thickness: float, extra: float = 0.0
) -> NDArray[np.float64]:
    """Return the rectangle around a line, counter-clockwise, shape (4, 2), `extra` metres longer at both ends."""
    along = (end - start) / np.hypot(*(end - start))
    aside = np.array([-along[1], along[0]]) * thickness / 2
    first, last = start - along * extra, end + along * extra
    return np.stack([first - aside, last - aside, last + aside, first + aside])


def covers(outline: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the mask of the points, shape (..., 2), in a convex counter-clockwise outline (N, 2) or on its rim."""
    edges = np.roll(outline, -1, axis=0) - outline
    inside = np.ones(points.shape[:-1], dtype=np.bool_)
    for corner, edge in zip(outline, edges, strict=True):
        inside &= edge[0] * (points[..., 1] - corner[1]) - edge[1] * (points[..., 0] - corner[0]) >= -1e-9
    return inside


def _gap(door: Door) -> NDArray[np.float64]:
    return bar(door.ends[0], door.ends[1], 0.5)


def _fill(cells: NDArray[np.int8], outlines: Iterable[NDArray[np.float64]], value: int, resolution: float) -> None:
    """Set the cells (row 0 at the bottom) whose centres an outline covers."""
    for outline in outlines:
        lo = np.maximum(np.floor(outline.min(axis=0) / resolution).astype(int) - 1, 0)
        hi = np.minimum(np.ceil(outline.max(axis=0) / resolution).astype(int) + 1, cells.shape[::-1])
        x, y = (np.arange(lo[k], hi[k]) + 0.5 for k in (0, 1))
        centres = np.stack(np.meshgrid(x, y), axis=-1) * resolution  # (rows, cols, 2)
        cells[lo[1] : hi[1], lo[0] : hi[0]][covers(outline, centres)] = value


def _read_only(values: Any) -> NDArray[np.float64]:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def _prism_dict(prism: Prism) -> dict[str, Any]:
    return {"outline": prism.outline.tolist(), "top": prism.top, "bottom": prism.bottom}


def _prisms(data: Iterable[Mapping[str, Any]]) -> tuple[Prism, ...]:
    return tuple(Prism(**p) for p in data)
