"""Map of a nav_msgs/OccupancyGrid message, and the updates of its parts."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError, MapFileError
from rectmerge.grid import LONGEST_SIDE_CELLS, MOST_CELLS, OCCUPIED, UNKNOWN, OccupancyGrid, unusable

TILT = 1e-3  # largest sine of half the angle between a level map's plane and the floor


def grid_of_message(message: Any, name: str) -> OccupancyGrid:
    """Turn a nav_msgs/OccupancyGrid, whose first row is the bottom one, into a grid.

    Parameters
    ----------
    message
        Message of ROS 1 or ROS 2, as rosbags or rclpy read it.
    name
        Name of the map in errors.

    Raises
    ------
    MapFileError
        If the map is unusable or has no free cell; the message gives the remedy.
    """
    info, cells = message.info, np.asarray(message.data, dtype=np.int8)
    width, height = int(info.width), int(info.height)
    if min(width, height) < 2:
        raise MapFileError(f"{name}: {width} x {height} cells are no map; record a whole one")
    if width * height > MOST_CELLS or max(width, height) > LONGEST_SIDE_CELLS:
        limit = f"{MOST_CELLS // 10**6} million, {LONGEST_SIDE_CELLS} on a side"
        raise MapFileError(f"{name}: {width} x {height} cells; there may be {limit}: crop it to its known cells")
    if cells.size != width * height:
        raise MapFileError(f"{name}: {cells.size} cells are not the stated {width} x {height}; record another")
    position = info.origin.position
    try:
        yaw = _to_yaw(info.origin.orientation)
        resolution = float(str(np.float32(info.resolution)))
        frame = str(message.header.frame_id).lstrip("/") or None  # tf2 knows no leading slash, though ROS 1 wrote it
        grid = OccupancyGrid(_picture(cells, height, width), resolution, (position.x, position.y, yaw), frame)
    except InputError as error:
        raise MapFileError(f"{name}: {error}; its publisher must mend that") from None
    if why := unusable(grid):
        raise MapFileError(f"{name}: {why}; is it the right topic, and a finished map?")
    return grid


def updated(grid: OccupancyGrid, message: Any, name: str) -> OccupancyGrid:
    """Write a map_msgs/OccupancyGridUpdate into the map that it belongs to.

    Parameters
    ----------
    grid
        The map.
    message
        Update: `data`, rows from the bottom up, of `width` x `height` cells whose lower-left one is (`x`, `y`), counted
        from the map's lower-left cell.
    name
        Name of the update in errors.

    Raises
    ------
    MapFileError
        If the update does not lie on the map, or leaves no cell free.
    """
    cells = np.asarray(message.data, dtype=np.int8)
    x, y, width, height = (int(part) for part in (message.x, message.y, message.width, message.height))
    if cells.size != width * height:
        raise MapFileError(f"{name}: {cells.size} cells are not the stated {width} x {height}")
    rows, columns = grid.shape
    if min(x, y) < 0 or x + width > columns or y + height > rows:
        part = f"{width} x {height} cells at ({x}, {y})"
        raise MapFileError(f"{name}: {part} reach outside the map of {columns} x {rows}: send the whole map")
    occupancy = grid.occupancy.copy()
    occupancy[rows - y - height : rows - y, x : x + width] = _picture(cells, height, width)
    whole = replace(grid, occupancy=occupancy)
    if why := unusable(whole):
        raise MapFileError(f"{name}: {why} after it")
    return whole


def _picture(cells: NDArray[np.int8], height: int, width: int) -> NDArray[np.int8]:
    """Return a message's cells with the top row first; values that mean nothing are unknown."""
    known = np.where((cells < UNKNOWN) | (cells > OCCUPIED), np.int8(UNKNOWN), cells)
    return known.reshape(height, width)[::-1]


def _to_yaw(quaternion: Any) -> float:
    """Return the yaw of a quaternion, radians in -pi..pi."""
    x, y, z, w = (float(part) for part in (quaternion.x, quaternion.y, quaternion.z, quaternion.w))
    length = math.hypot(x, y, z, w)
    if length == 0.0:
        return 0.0
    if not math.isfinite(length):
        raise InputError(f"the origin's orientation must be finite numbers, got {x}, {y}, {z}, {w}")
    if math.hypot(x, y) > TILT * length:
        raise InputError(f"the map must lie level, but its origin's orientation is {x:g}, {y:g}, {z:g}, {w:g}")
    return math.remainder(2.0 * math.atan2(z, w), math.tau)
