"""Identifiability of a pair: the score of the true placement against all others, on exact maps.

In a ward of rooms that are all alike the maps fit as well one room further on: no method can know which placement is
true, and "ambiguous" is the right answer. In simulation the building is known, so this is measured.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from scenarios.pairs.pair import MapPair
from sim.missions.mission_log import MissionLog, RobotLog
from sim.sensors.lidar import Lidar
from sim.slam.mapping import build_map
from sim.world import World

CELL_M, SCREEN_M = 0.1, 0.2  # cells, and those in which turns that are no quarter turns are screened
DRAWN_FINER = 2  # the building is drawn in cells so much finer: no wall falls between their centres
RIM_M = 0.5  # around a map's image
AWAY_M, STEP_DEG = 1.0, 5  # distance from the truth of another placement
LEAST_MARGIN = 0.25
MARGIN_DIGITS = 3  # more depend on the machine
QUARTER_TURNS, MAX_OTHER_TURNS = (
    (0, 90, 180, 270),
    4,
)  # scored in fine cells: all, and the best others
OPEN_CELLS = 2  # floor with no wall so near contradicts a wall
Image = NDArray[np.float32]


def identifiable_margin(log: MissionLog, pair: MapPair) -> float:
    """Return the margin by which the true placement of a pair beats every other one.

    Parameters
    ----------
    log
        The mission as the pair was made from it, cut where that was.
    pair
        A related pair; its `info` holds the positions of the maps in the world.

    Returns
    -------
    float
        ``(truth - elsewhere) / truth``, at least -1: 1 where no other placement explains any wall, 0 where one is as
        good as the truth, negative where one is better. The pair counts as identifiable from `LEAST_MARGIN` on.

    Notes
    -----
    Each map is replaced by an exact one in the world's frame: the building's own raster, where the robot's beams, laid
    down by the true poses and without noise, show it, and within the map's image where that may have been cut. So
    neither noise nor wrong poses count, nor what only one visit finds. A wall cell is a floor cell beside a wall, with
    the direction away from the wall; open floor has no wall within two cells.

    The score of a rigid placement (scale 1), in wall cells: the cosine between the directions of each two that meet
    within a cell of 0.1 m, less one for each wall cell of either map on open floor of the other. What the other has not
    seen says nothing. All shifts are scored, by correlation, at turns in steps of 5 degrees; other turns than quarter
    turns are screened in cells of 0.2 m, and the best four of them scored as the rest. The truth's score is the best
    within 1 m and 5 degrees of it, `elsewhere` the best of all others. A rival whose turn is between the steps scores
    less than it could.

    `LEAST_MARGIN` was chosen on the suite `repetitive` and the training part of `standard`: wards of identical rooms
    that share 0.6 have margins of -0.7 to -0.2, wards whose rooms stand off their places by up to 0.15 m -0.34 to 0.20,
    by up to 0.5 m 0.40 to 0.77; other families 0.62 to 1, but for one loop of -0.47 at an overlap of 0.26.
    """
    building = _Building.from_world(log.world, log.spec.a.lidar.height_m)
    a, b = (
        _seen(building, robot, spec.lidar, _Window.from_pair(pair, name))
        for name, robot, spec in (("a", log.a, log.spec.a), ("b", log.b, log.spec.b))
    )
    if not (len(a.walls) and len(b.walls)):
        return -1.0
    others = [turn for turn in range(0, 360, STEP_DEG) if turn not in QUARTER_TURNS]
    screened = {turn: float(scores.max()) for turn, scores, _ in _correlations(a, b, others, SCREEN_M)}
    promising = sorted(others, key=lambda turn: -screened[turn])[:MAX_OTHER_TURNS]
    truth, elsewhere = 0.0, 0.0
    for turn, scores, at in _correlations(a, b, (*QUARTER_TURNS, *promising), CELL_M):
        if turn == 0:
            is_true = _within(scores.shape, at, AWAY_M / CELL_M)
            truth = float(scores[is_true].max())
            scores[is_true] = 0.0
        elsewhere = max(elsewhere, float(scores.max()))
    return round(max(-1.0, 1.0 - elsewhere / truth), MARGIN_DIGITS) if truth > 0 else -1.0


@dataclass(frozen=True, slots=True, eq=False)
class _Building:
    """Building as cells of 0.1 m, (row, col), row 0 at the bottom.

    Parameters
    ----------
    is_wall, is_open
        Floor beside a wall, and floor with no wall near, shape (h, w).
    facing
        Unit vectors away from the wall, shape (h, w, 2).
    """

    is_wall: NDArray[np.bool_]
    is_open: NDArray[np.bool_]
    facing: Image

    @classmethod
    def from_world(cls, world: World, height_m: float) -> _Building:
        """Draw a building at a laser's height."""
        raster = world.raster(CELL_M / DRAWN_FINER, height_m=height_m)
        solid = _pooled(raster.occupied[::-1])
        floor = _pooled(raster.free[::-1]) & ~solid
        soft = cv2.GaussianBlur(solid.astype(np.float32), (5, 5), 0)
        uphill = [np.asarray(cv2.Sobel(soft, cv2.CV_32F, *axis), np.float32) for axis in ((1, 0), (0, 1))]
        facing = -np.stack(uphill, axis=-1) / np.maximum(np.hypot(*uphill), 1e-6)[..., None]
        touches_wall = _dilated(solid, np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8))
        near = _dilated(solid, np.ones((2 * OPEN_CELLS + 1, 2 * OPEN_CELLS + 1), np.uint8))
        return cls(touches_wall & floor, floor & ~near, facing.astype(np.float32))


@dataclass(frozen=True, slots=True)
class _Window:
    """Part of the world in a map's image: lower-left corner and yaw, and sides, metres."""

    origin: tuple[float, float, float]
    sides: tuple[float, float]

    @classmethod
    def from_pair(cls, pair: MapPair, name: str) -> _Window | None:
        """Return the window of a map that may have been cut to a size; None for a map of all that was seen."""
        if pair.info[f"turn_{name}"] != "image":
            return None
        height, width = (pair.a if name == "a" else pair.b).shape
        cell_m = pair.info[f"resolution_{name}"]
        return cls(tuple(pair.info[f"origin_{name}"]), (width * cell_m, height * cell_m))

    def holds(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which points (N, 2) of the world lie in the window or its rim, shape (N,)."""
        at = _turned(points - self.origin[:2], -self.origin[2])
        return np.asarray(((at >= -RIM_M) & (at <= np.array(self.sides) + RIM_M)).all(axis=1))


@dataclass(frozen=True, slots=True, eq=False)
class _SeenCells:
    """Surfaces that one robot saw: wall cells (N, 2), their normals (N, 2), and open floor (M, 2); metres."""

    walls: NDArray[np.float64]
    facing: NDArray[np.float64]
    floor: NDArray[np.float64]

    def turned(self, turn_deg: float) -> _SeenCells:
        """Turn everything about the world's origin, counter-clockwise."""
        return _SeenCells(
            *(_turned(points, math.radians(turn_deg)) for points in (self.walls, self.facing, self.floor))
        )

    def images(self, cell_m: float) -> tuple[Image, NDArray[np.int64]]:
        """Draw normals (x and y), walls and open floor, shape (4, h, w), and return the first cell (x, y)."""
        all_cells = np.floor(np.concatenate([self.walls, self.floor]) / cell_m).astype(np.int64)
        first = all_cells.min(axis=0)
        width, height = all_cells.max(axis=0) - first + 1
        flat = (all_cells - first) @ [1, width]
        walls, floor = flat[: len(self.walls)], flat[len(self.walls) :]
        weights = ((walls, self.facing[:, 0]), (walls, self.facing[:, 1]), (walls, None), (floor, None))
        images = np.stack([np.bincount(cells, weight, minlength=width * height) for cells, weight in weights])
        per_cell = cell_m / CELL_M  # a line of walls has so many in a cell
        scaled = images / np.array([per_cell, per_cell, per_cell, per_cell**2])[:, None]
        return scaled.reshape(4, height, width).astype(np.float32), first


def _seen(building: _Building, robot: RobotLog, lidar: Lidar, window: _Window | None) -> _SeenCells:
    """Return the surfaces of a building that a robot's beams show, by its true poses, within a window if any."""
    ranges = lidar.limit(robot.ranges)
    grid = build_map(robot.poses, lidar.angles, ranges, resolution=CELL_M, max_range_m=lidar.max_range_m)
    rows, cols = np.nonzero(~grid.unknown[::-1])
    cells = np.stack([cols, rows], axis=1) + np.rint(np.array(grid.origin[:2]) / CELL_M).astype(np.int64)
    cells = cells[((cells >= 0) & (cells < building.is_wall.shape[::-1])).all(axis=1)]
    centres: NDArray[np.float64] = (cells.astype(np.float64) + 0.5) * CELL_M
    if window is not None:
        is_inside = window.holds(centres)
        centres, cells = centres[is_inside], cells[is_inside]
    x, y = cells.T
    is_wall, is_open = building.is_wall[y, x], building.is_open[y, x]
    return _SeenCells(centres[is_wall], building.facing[y, x][is_wall].astype(np.float64), centres[is_open])


def _correlations(
    a: _SeenCells, b: _SeenCells, turns_deg: Iterable[int], cell_m: float
) -> Iterator[tuple[int, Image, NDArray[np.int64]]]:
    """Yield the scores of all shifts of B on A: a turn, scores by shift (y, x), and the cell (x, y) of no shift."""
    drawn_b = {turn: b.turned(turn).images(cell_m) for turn in turns_deg}
    drawn_a, first_a = a.images(cell_m)
    reach = np.max([images.shape[1:] for images, _ in drawn_b.values()], axis=0)
    shape = [cv2.getOptimalDFTSize(int(side)) for side in reach + drawn_a.shape[1:]]
    for facing in drawn_a[:2]:  # within a cell counts as a match
        facing[:] = cv2.boxFilter(facing, -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT) / 3
    spectra_a = _spectra(drawn_a, shape)
    for turn, (images, first_b) in drawn_b.items():
        spectra_b = _spectra(images, shape)
        x, y, on_floor, under_wall = (
            cv2.mulSpectrums(spectra_a[k], spectra_b[m], 0, conjB=True) for k, m in ((0, 0), (1, 1), (3, 2), (2, 3))
        )
        back = cv2.DFT_INVERSE | cv2.DFT_SCALE | cv2.DFT_REAL_OUTPUT
        yield turn, np.asarray(cv2.dft(x + y - on_floor - under_wall, flags=back), np.float32), first_b - first_a


def _spectra(images: Image, shape: list[int]) -> list[Image]:
    """Transform images, each filled up to a shape."""
    spectra = []
    for image in images:
        full = np.zeros(shape, np.float32)
        full[: image.shape[0], : image.shape[1]] = image
        spectra.append(np.asarray(cv2.dft(full), np.float32))
    return spectra


def _within(shape: tuple[int, ...], at: NDArray[np.int64], radius: float) -> NDArray[np.bool_]:
    """Return which cells of a torus are nearer than a radius to a cell (x, y), shape (h, w)."""
    y, x = (np.abs(np.arange(n) - k % n) for n, k in zip(shape, at[::-1], strict=True))
    away = np.hypot(np.minimum(y, shape[0] - y)[:, None], np.minimum(x, shape[1] - x)[None])
    near: NDArray[np.bool_] = away < radius
    return near


def _pooled(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return coarser cells, true where any finer one is."""
    height, width = (-(-side // DRAWN_FINER) for side in mask.shape)
    full = np.zeros((height * DRAWN_FINER, width * DRAWN_FINER), np.bool_)
    full[: mask.shape[0], : mask.shape[1]] = mask
    return np.asarray(full.reshape(height, DRAWN_FINER, width, DRAWN_FINER).any(axis=(1, 3)))


def _dilated(mask: NDArray[np.bool_], kernel: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return np.asarray(cv2.dilate(mask.view(np.uint8), kernel)).astype(np.bool_)


def _turned(points: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """Turn points or vectors (N, 2) about the origin, counter-clockwise."""
    cos, sin = math.cos(angle), math.sin(angle)
    turned: NDArray[np.float64] = points @ np.array([[cos, sin], [-sin, cos]])
    return turned
