"""Worlds from occupancy grids: occupied cells are walls, free cells are floor, and unknown cells are walled off."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.specks import remove_specks
from rectmerge.errors import InputError, SimulationError
from rectmerge.grid import FREE, OCCUPIED, OccupancyGrid
from rectmerge.paper.rmap import rmap
from sim.motion.driving import find_standing_spot, make_drive_field
from sim.world import Prism, Room, World

HEIGHT_M = 2.5
NARROWEST_M = 0.25  # a robot is wider; narrower free space in a map comes from single beams
SHORTEST_SIDE_M, LONGEST_SIDE_M = 1.0, 300.0
MOST_WALLS = 16_000  # PyBullet takes no larger mesh
ROOM_SIDE_M, ROOM_AREA_M2, MOST_ROOMS = 1.0, 2.0, 40
Mask = NDArray[np.bool_]


def world_from_grid(
    grid: OccupancyGrid, name: str, *, narrowest_m: float = NARROWEST_M, max_speck_cells: int = 0
) -> World:
    """Make a world from a map by its walls.

    Parameters
    ----------
    grid
        A map with a resolution; its origin is ignored.
    name
        Family of the world.
    narrowest_m
        Free strips narrower than this between unknown cells are no floor; 0 keeps them all.
    max_speck_cells
        Patches of at most so many cells that stand alone in free space are no walls; 0 keeps them all.

    Raises
    ------
    InputError
        If a value is out of range, no floor is left, or the world would be absurdly large, small or ragged.

    Notes
    -----
    Walls are the R-map (Algorithm 2) of the occupied cells, so the world's raster at the map's resolution shows them
    cell by cell. It departs from the map in three things: free strips that are too narrow are unknown; an unknown cell
    that touches floor, also at a corner, is wall, as is a cell beyond the map's border; and it is cropped to the walls.
    Rooms are the large rectangles of the R-map of the floor in which a robot can stand.
    """
    if not (math.isfinite(narrowest_m) and narrowest_m >= 0):
        raise InputError(f"narrowest_m must be >= 0 metres, got {narrowest_m}")
    if (resolution := grid.resolution) is None:
        raise InputError("the map has no resolution, so its size in metres is not known")
    tidy = remove_specks(grid, max_speck_cells=max_speck_cells)
    floor, walls = _floor_and_walls(tidy, 1 + 2 * math.floor(narrowest_m / resolution / 2 + 1e-9))
    if not floor.any():
        raise InputError(f"there is no free space wider than {narrowest_m:g} m at a resolution of {resolution:g}")
    size = walls.shape[1] * resolution, walls.shape[0] * resolution
    require_size(size, f"is the resolution {resolution:g} right?")
    boxes = rmap(walls).boxes
    if len(boxes) > MOST_WALLS:
        raise InputError(
            f"its walls are {len(boxes)} rectangles, more than {MOST_WALLS}: clean the map or make it coarser"
        )
    outlines = _outlines(boxes, walls.shape[0], resolution)
    ground = _outlines(rmap(floor | walls).boxes, walls.shape[0], resolution)  # walls hide what lies below them
    world = World(size=size, walls=tuple(Prism(o, HEIGHT_M) for o in outlines), floor=tuple(ground), family=name)
    return replace(world, rooms=large_rooms(world, floor, resolution))


def require_size(size: tuple[float, float], doubt: str) -> None:
    """Raise InputError unless a world of this size in metres can be simulated; `doubt` names a likely cause."""
    if not (min(size) >= SHORTEST_SIDE_M and max(size) <= LONGEST_SIDE_M):
        allowed = f"{SHORTEST_SIDE_M:g} to {LONGEST_SIDE_M:g} m"
        raise InputError(f"the world would be {size[0]:.3g} x {size[1]:.3g} m; {allowed} a side are allowed; {doubt}")


def large_rooms(world: World, floor: Mask, resolution: float) -> tuple[Room, ...]:
    """Make rooms of the large rectangles of a floor mask, shape (H, W); the largest is room 1."""
    plain = remove_specks(OccupancyGrid(np.where(floor, FREE, OCCUPIED).astype(np.int8))).free
    least = math.ceil(ROOM_AREA_M2 / resolution**2)
    boxes = rmap(plain, max_rectangles=MOST_ROOMS, min_area_cells=least).boxes
    wide = boxes[boxes[:, 2:].min(axis=1) * resolution >= ROOM_SIDE_M]
    rooms = reachable_rooms(world, (("room", outline) for outline in _outlines(wide, floor.shape[0], resolution)))
    return tuple(replace(room, name=f"room {k}") for k, room in enumerate(rooms, start=1))


def reachable_rooms(world: World, outlines: Iterable[tuple[str, NDArray[np.float64]]]) -> tuple[Room, ...]:
    """Return the rooms in which a robot can stand and from which it can drive to all others."""
    try:
        field = make_drive_field(world)
    except SimulationError:  # a robot fits nowhere: such a world can be drawn and rastered, but not toured
        return ()
    rooms = [Room(name, outline, outline.mean(axis=0)) for name, outline in outlines]
    spots = [find_standing_spot(field, room) for room in rooms]
    return tuple(replace(room, spot=spot) for room, spot in zip(rooms, spots, strict=True) if spot is not None)


def _floor_and_walls(grid: OccupancyGrid, narrowest_cells: int) -> tuple[Mask, Mask]:
    """Return floor and walls, cut to the walls; the floor touches nothing but walls."""
    free, occupied = np.pad(grid.free, 1), np.pad(grid.occupied, 1)
    narrowest_cells = min(narrowest_cells, 1 + max(free.shape))  # nothing on the map is wider
    brush = np.ones((narrowest_cells, narrowest_cells), np.uint8)
    floor = free & (cv2.morphologyEx((free | occupied).view(np.uint8), cv2.MORPH_OPEN, brush) > 0)
    around = cv2.dilate(floor.view(np.uint8), np.ones((3, 3), np.uint8)) > 0
    walls = occupied | (around & ~floor)
    rows, cols = (np.flatnonzero(walls.any(axis=axis)) for axis in (1, 0))
    part = np.s_[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1] if len(rows) else np.s_[:, :]
    return floor[part], walls[part]


def _outlines(boxes: NDArray[np.int32], height: int, resolution: float) -> list[NDArray[np.float64]]:
    """Turn rectangles (x, y, w, h) of a grid of `height` rows into outlines in metres."""
    x, y, w, h = boxes.T.astype(np.float64)
    left, right, low, high = x, x + w, height - y - h, height - y
    corners = np.stack([left, low, right, low, right, high, left, high], axis=-1).reshape(-1, 4, 2)
    return list(corners * resolution)
