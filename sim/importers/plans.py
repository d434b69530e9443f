"""Plans in the JSON schema of HouseExpo (T. Li et al., arXiv:1903.09845): the outline of a floor, and room boxes."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import Polygon, box
from shapely.geometry.base import BaseGeometry

from rectmerge.errors import InputError
from rectmerge.rectangles import largest_rectangle
from sim.importers.grids import HEIGHT_M, large_rooms, reachable_rooms, require_size
from sim.world import Prism, Room, World

THINNEST_M, THICKEST_M = 0.05, 1.0
MITRE_LIMIT = 2.0  # walls that meet at a sharp angle are cut off so far out, in thicknesses
LEAST_AREA_M2 = 1e-9
FARTHEST_M = 1e6
CELL_M = 0.05  # of the search for a rectangle in a box that is not convex within the outline
Points = NDArray[np.float64]


def world_from_plan(plan: Any, name: str, *, wall_m: float) -> World:
    """Make a world from the JSON data of a plan.

    Parameters
    ----------
    plan
        ``verts``: the corners [x, y] of the floor's outline in metres, interior walls being folds of it;
        ``room_category``: for each category a list of boxes [x0, y0, x1, y1]. Other keys are ignored.
    name
        Family of the world.
    wall_m
        Thickness of the walls, which stand outside the outline; two that meet in a narrow fold fill it.

    Raises
    ------
    InputError
        If it is of another schema, a number cannot be used, or the house would be absurdly large or small.

    Notes
    -----
    Walls and floor are cut into triangles (constrained Delaunay). A room is the intersection of its box and the
    floor where that is convex, else the largest rectangle in it; where the plan names no room, the large rectangles of
    the floor are rooms.
    """
    if not THINNEST_M <= wall_m <= THICKEST_M:
        raise InputError(f"wall_m must be {THINNEST_M} to {THICKEST_M} metres, got {wall_m}")
    corners, boxes = _corners(plan), _boxes(plan)
    low, high = corners.min(axis=0) - wall_m, corners.max(axis=0) + wall_m
    size = float(high[0] - low[0]), float(high[1] - low[1])
    require_size(size, "are its vertices in metres?")
    floor = shapely.make_valid(Polygon(corners - low))
    if not floor.area > LEAST_AREA_M2:
        raise InputError("verts enclose no area")
    walls = floor.buffer(wall_m, join_style="mitre", mitre_limit=MITRE_LIMIT).difference(floor)
    prisms = tuple(Prism(triangle, HEIGHT_M) for triangle in _triangles(walls))
    world = World(size=size, walls=prisms, floor=tuple(_triangles(floor)), family=name)
    return replace(world, rooms=_rooms(world, floor, [(kind, corners - [*low, *low]) for kind, corners in boxes]))


def _corners(plan: Any) -> Points:
    """Return the corners of the outline, shape (N, 2)."""
    verts = _numbers(_value(plan, "verts"), "verts must be a list of corners [x, y]")
    if verts.ndim != 2 or verts.shape[1] != 2 or len(verts) < 3:
        raise InputError(f"verts must be three or more corners [x, y], got shape {verts.shape}")
    return verts


def _boxes(plan: Any) -> list[tuple[str, Points]]:
    """Return the categories and boxes (4,) of the rooms, each box once."""
    categories = _value(plan, "room_category")
    if not isinstance(categories, dict):
        raise InputError(f"room_category must name boxes by category, got {type(categories).__name__}")
    categories_by_box: dict[tuple[float, ...], str] = {}
    for category, listed in categories.items():
        complaint = f"room_category.{category} must be a list of boxes [x0, y0, x1, y1]"
        boxes = _numbers(listed, complaint) if listed else np.empty((0, 4))
        if boxes.ndim != 2 or boxes.shape[1] != 4:
            raise InputError(f"{complaint}, got shape {boxes.shape}")
        for corners in boxes.tolist():
            categories_by_box.setdefault(tuple(corners), category.replace("_", " ").lower())
    return [(category, np.array(corners)) for corners, category in categories_by_box.items()]


def _value(plan: Any, key: str) -> Any:
    if not isinstance(plan, dict) or key not in plan:
        raise InputError(f"the key {key} is missing, which a HouseExpo plan must have")
    return plan[key]


def _numbers(values: Any, complaint: str) -> Points:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(complaint) from None
    if not (array.size and (np.abs(array) < FARTHEST_M).all()):
        raise InputError(f"{complaint}, in metres, none beyond {FARTHEST_M:g}")
    return array


def _triangles(shape: BaseGeometry) -> Iterator[Points]:
    """Cut an area into triangles (3, 2), counter-clockwise."""
    for part in _polygons(shape):
        for triangle in shapely.constrained_delaunay_triangles(part).geoms:
            if triangle.area > LEAST_AREA_M2:
                yield _outline(triangle)


def _polygons(shape: BaseGeometry) -> list[Polygon]:
    parts = shapely.get_parts(shapely.get_parts(shape))  # a collection may hold what has parts of its own
    return [part for part in parts if isinstance(part, Polygon) and part.area > LEAST_AREA_M2]


def _outline(polygon: Polygon) -> Points:
    return np.array(polygon.exterior.coords[:-1] if polygon.exterior.is_ccw else polygon.exterior.coords[:0:-1])


def _rooms(world: World, floor: BaseGeometry, boxes: list[tuple[str, Points]]) -> tuple[Room, ...]:
    """Make the rooms of the plan, numbered in a category that has several."""
    outlines = [(kind, outline) for kind, corners in boxes if (outline := _room_outline(floor, corners)) is not None]
    if not outlines:
        return large_rooms(world, world.raster(CELL_M).free, CELL_M)
    of_kind = Counter(kind for kind, _ in outlines)
    seen: Counter[str] = Counter()
    named = []
    for kind, outline in outlines:
        seen[kind] += 1
        named.append((f"{kind} {seen[kind]}" if of_kind[kind] > 1 else kind, outline))
    return reachable_rooms(world, named)


def _room_outline(floor: BaseGeometry, corners: Points) -> Points | None:
    """Return a convex outline within the intersection of a box and the floor; None where that is empty."""
    x0, y0, x1, y1 = corners
    parts = _polygons(floor.intersection(box(min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1))))
    if not parts:
        return None
    part = max(parts, key=lambda polygon: polygon.area)
    hull = part.convex_hull
    if hull.area - part.area < 1e-6 * part.area:
        return _outline(hull)
    return _largest_rectangle(part)


def _largest_rectangle(part: Polygon) -> Points | None:
    """Return the outline (4, 2) of the largest upright rectangle in an area, to a cell; None where it has none."""
    left, low, right, high = part.bounds
    columns, rows = (max(1, math.ceil(span / CELL_M)) for span in (right - left, high - low))
    x, y = (start + (np.arange(count) + 0.5) * CELL_M for start, count in ((left, columns), (low, rows)))
    rectangle = largest_rectangle(shapely.contains_xy(part, *np.meshgrid(x, y)))
    if rectangle is None:
        return None
    first, last = (
        np.array(at) for at in ((rectangle.x, rectangle.y), (rectangle.x + rectangle.w, rectangle.y + rectangle.h))
    )
    return _outline(box(*(first * CELL_M + [left, low]), *(last * CELL_M + [left, low])))
