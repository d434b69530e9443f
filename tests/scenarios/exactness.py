"""How exact the maps and the truth of any mission are, in cells: for tests, and for a look at new buildings."""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from scenarios.pairs.pair import MapPair
from sim.missions.mission_log import MissionLog, RobotLog
from sim.sensors.lidar import Lidar
from sim.slam.mapping import build_map

MOST_POINTS = 1500
FINER = 5


def raster_shift_cells(log: MissionLog, visit: int, resolution: float = 0.05) -> NDArray[np.float64]:
    """Measure how far a robot's map by true poses lies beside the world's raster, (x, y), in cells of the map.

    Every wall cell of the map has its nearest surface in a raster five times as fine; the shift is what explains the
    distances across those surfaces best. A wall is at most half a cell beside the cells that it fills, so a map that
    lies where it should is never further off.
    """
    robot, lidar = _robot(log, visit)
    grid = build_map(
        robot.poses, lidar.angles, lidar.limit(robot.ranges), resolution=resolution, max_range_m=lidar.max_range_m
    )
    plan = replace(log.world.at_visit(visit), glass=()).raster(resolution / FINER, height_m=lidar.height_m)
    cells = plan.map_to_pixel(grid.pixel_to_map(np.argwhere(grid.occupied)[:, ::-1]))
    off = (cells - _nearest(surface_of(plan), cells)) / FINER * [1, -1]  # (N, 2), y up
    off = off[np.hypot(*off.T) > 0]
    normals = off / np.hypot(*off.T)[:, None]
    shift: NDArray[np.float64] = np.linalg.solve(normals.T @ normals, (normals.T @ np.hypot(*off.T)))
    return shift


def surface_of(grid: OccupancyGrid) -> NDArray[np.bool_]:
    """Mask of the occupied cells that touch a cell that is not, by a side."""
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    inside = cv2.erode(grid.occupied.view(np.uint8), cross, borderValue=0)
    surface: NDArray[np.bool_] = grid.occupied & ~inside.astype(np.bool_)
    return surface


def wall_offset_px(pair: MapPair) -> float:
    """Measure the median distance of B's walls, under the truth, to the nearest wall cell of A, in the larger cells.

    Walls of B that A has not mapped, with no wall of A within three cells, are left out.
    """
    assert pair.pixels is not None
    cells_a, cells_b = (np.argwhere(grid.occupied)[:, ::-1].astype(np.float64) for grid in (pair.a, pair.b))
    mapped = pair.pixels.apply(cells_b[:: math.ceil(len(cells_b) / MOST_POINTS)])
    larger = max(1.0, pair.pixels.scale)
    away = np.array([np.hypot(*(cells_a - at).T).min() for at in mapped]) / larger
    common = away < 3.0
    assert common.mean() > 0.1, "the maps have hardly a wall in common"
    return float(np.median(away[common]))


def _robot(log: MissionLog, visit: int) -> tuple[RobotLog, Lidar]:
    return ((log.a, log.spec.a.lidar), (log.b, log.spec.b.lidar))[visit]


def _nearest(mask: NDArray[np.bool_], pixels: NDArray[np.float64]) -> NDArray[np.int64]:
    """The cells (u, v) of a mask that are nearest to pixels (N, 2), to about a cell."""
    _, labels = cv2.distanceTransformWithLabels(
        (~mask).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    cells = np.zeros((labels.max() + 1, 2), dtype=np.int64)
    cells[labels[mask]] = np.argwhere(mask)[:, ::-1]
    u, v = np.rint(pixels).astype(np.int64).clip(0, np.array(mask.shape[::-1]) - 1).T
    return cells[labels[v, u]]
