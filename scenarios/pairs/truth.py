"""Truth of a pair: common surface points of both maps, the residual of one similarity, and A's extent."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from scenarios.pairs.map_view import PlacedMap
from sim.missions.mission_log import MissionLog, RobotLog
from sim.sensors.lidar import Lidar
from sim.slam.mapping import scan_points
from sim.world import World

MOST_CONTROL_POINTS, FEWEST_CONTROL_POINTS = 400, 20
SURFACE_CELL_M = 0.05  # hits of two robots in one cell of this size are of the same surface
SURFACE_WITHIN_M = 0.1  # of a wall or furniture of both visits; other hits are of what moved
BENT_ABOVE = 0.015  # residual over L


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ScannedSurface:
    """Surface points that one robot hit, and its map.

    Parameters
    ----------
    points
        True positions in the world, shape (N, 2), metres.
    scans
        Index of the scan that hit each, shape (N,).
    placed
        The map.
    """

    points: NDArray[np.float64]
    scans: NDArray[np.int64]
    placed: PlacedMap

    @classmethod
    def from_log(cls, robot: RobotLog, lidar: Lidar, placed: PlacedMap) -> ScannedSurface:
        """Collect the points that a robot's scanner hit."""
        ranges = lidar.limit(robot.ranges)
        hit = np.isfinite(ranges)
        points = scan_points(robot.poses, lidar.angles, np.where(hit, ranges, 0.0))[hit]
        return cls(points=points, scans=np.nonzero(hit)[0], placed=placed)


def control_points(log: MissionLog, a: PlacedMap, b: PlacedMap, rng: np.random.Generator) -> NDArray[np.float64] | None:
    """Choose surface points of a mission's building that both robots hit and both maps show.

    Parameters
    ----------
    log
        The mission.
    a, b
        Its maps.
    rng
        Randomness of the choice.

    Returns
    -------
    NDArray or None
        As from `common_points`.
    """
    seen_a, seen_b = (
        ScannedSurface.from_log(log.a, log.spec.a.lidar, a),
        ScannedSurface.from_log(log.b, log.spec.b.lidar, b),
    )

    def is_surface(points: NDArray[np.float64]) -> NDArray[np.bool_]:
        mask = np.ones(len(points), dtype=np.bool_)
        for height_m in {robot.lidar.height_m for robot in (log.spec.a, log.spec.b)}:
            mask &= is_on_wall(log.world, points, height_m)
        return mask

    return common_points(seen_a, seen_b, rng, is_surface=is_surface)


def common_points(
    a: ScannedSurface,
    b: ScannedSurface,
    rng: np.random.Generator,
    *,
    is_surface: Callable[[NDArray[np.float64]], NDArray[np.bool_]] | None = None,
) -> NDArray[np.float64] | None:
    """Choose surface points that two robots hit and both maps show.

    Parameters
    ----------
    a, b
        The points they hit, in one world.
    rng
        Randomness of the choice.
    is_surface
        Mask of the points (M, 2) that may be chosen, where the world is known; without it all may.

    Returns
    -------
    NDArray or None
        Shape (N, 4), rows (ua, va, ub, vb), 20 <= N <= 400; None where there are fewer.

    Notes
    -----
    The point is the true position of A's first reading of a surface cell. Each map places it by its own pose of one of
    its scans that hit the cell, drawn from all of them, because the map's wall lies where most readings lie.
    """
    keys_a, keys_b = _keys(a.points), _keys(b.points)
    common, first, _ = np.intersect1d(keys_a, keys_b, return_indices=True)
    if not len(common):
        return None
    world = a.points[first]  # (M, 2)
    of_a, of_b = rng.spawn(2)
    in_a = a.placed.shown_at(world, a.scans[_any_of(common, keys_a, of_a)])
    in_b = b.placed.shown_at(world, b.scans[_any_of(common, keys_b, of_b)])
    is_seen = _is_shown(a.placed.grid, in_a) & _is_shown(b.placed.grid, in_b)
    seen = np.flatnonzero(is_seen if is_surface is None else is_seen & is_surface(world))
    if len(seen) < FEWEST_CONTROL_POINTS:
        return None
    chosen = np.sort(rng.permutation(seen)[:MOST_CONTROL_POINTS])
    return np.hstack([in_a[chosen], in_b[chosen]])


def known_extent(grid: OccupancyGrid) -> float:
    """Measure L: the diagonal of the bounding box of a map's known (free or occupied) cells, in cells.

    Raises
    ------
    InputError
        If no cell is known.
    """
    known = ~grid.unknown
    rows, cols = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if not len(rows):
        raise InputError("map A has no known cell: errors cannot be measured against its extent")
    return math.hypot(rows[-1] - rows[0] + 1, cols[-1] - cols[0] + 1)


def control_point_rmse(matrix: ArrayLike, control_points: NDArray[np.float64]) -> float:
    """Measure the RMSE of ``|T p_b - p_a|`` in A's pixels.

    Parameters
    ----------
    matrix
        Shape (2, 3), from B's pixels to A's.
    control_points
        Shape (N, 4), rows (ua, va, ub, vb).
    """
    m = np.asarray(matrix, dtype=np.float64)
    return rms(control_points[:, 2:] @ m[:, :2].T + m[:, 2] - control_points[:, :2])


def rms(offsets: NDArray[np.float64]) -> float:
    """Return the root mean square length of offsets, (N, 2)."""
    return float(np.sqrt((offsets**2).sum(axis=1).mean()))


def is_bent(residual_over_l: float | None) -> bool:
    """Return whether a pair is in the stratum "bent": no single similarity fits it within 1.5 % of L."""
    return residual_over_l is not None and residual_over_l > BENT_ABOVE


def _keys(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the keys of the surface cells of points (N, 2)."""
    col, row = np.floor(points / SURFACE_CELL_M).astype(np.int64).T
    keys: NDArray[np.int64] = (col << 20) + row
    return keys


def _any_of(common: NDArray[np.int64], keys: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.int64]:
    """Return, for each of the common keys, ascending, a random position (M,) of it in `keys`."""
    order = rng.permutation(len(keys))
    order = order[np.argsort(keys[order], kind="stable")]
    return order[np.searchsorted(keys[order], common)]


def is_on_wall(world: World, points: NDArray[np.float64], height_m: float) -> NDArray[np.bool_]:
    """Return whether points (N, 2) lie in or near a wall or furniture of both visits, at a laser's height."""
    mask = np.zeros(len(points), dtype=np.bool_)
    for prism in world.walls + world.furniture:
        if prism.bottom <= height_m < prism.top:
            low, high = prism.outline.min(axis=0) - SURFACE_WITHIN_M, prism.outline.max(axis=0) + SURFACE_WITHIN_M
            around = np.flatnonzero(((points > low) & (points < high)).all(axis=1))
            edges = np.roll(prism.outline, -1, axis=0) - prism.outline  # (C, 2), counter-clockwise
            outward = np.stack([edges[:, 1], -edges[:, 0]], axis=-1) / np.hypot(*edges.T)[:, None]
            distance = points[around] @ outward.T - (prism.outline * outward).sum(axis=1)  # (M, C), beyond each side
            mask[around] |= distance.max(axis=1) < SURFACE_WITHIN_M
    return mask


def _is_shown(grid: OccupancyGrid, pixels: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether pixels (N, 2) lie on a wall of the map or touch one."""
    near_wall = cv2.dilate(grid.occupied.view(np.uint8), np.ones((3, 3), np.uint8)).astype(np.bool_)
    u, v = np.rint(pixels).astype(np.int64).T
    inside = (u >= 0) & (v >= 0) & (u < grid.shape[1]) & (v < grid.shape[0])
    shown: NDArray[np.bool_] = inside & near_wall[np.where(inside, v, 0), np.where(inside, u, 0)]
    return shown
