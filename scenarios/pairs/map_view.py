"""One robot's map, built from its log, corrupted, cropped and turned, and the world's position in it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.corruption import CorruptedMap, NoiseLevel, check_corruptions, corrupt, find_noise
from scenarios.corruption.geometry import Size, turn_image
from scenarios.corruption.noise_levels import Noise
from scenarios.pairs.cropping import crop_to_known
from sim.missions.mission_log import RobotLog
from sim.sensors.lidar import Lidar
from sim.slam.mapping import HIT, LIMIT, MISS, build_map
from sim.slam.odometry import simulate_odometry
from sim.slam.pose_sources import PoseSource, Slam, estimate_poses


@dataclass(frozen=True, slots=True, kw_only=True)
class MapSpec:
    """Settings of a map that is built from a log.

    Parameters
    ----------
    resolution
        Metres per cell.
    turn_deg
        Turn of the building in the image, degrees, counter-clockwise to the eye; "random" draws it.
    turn
        "frame": the map frame is turned before mapping, so every cell is as sharp as in an upright map.
        "image": the finished image is turned by nearest neighbour, as the paper does.
    extent_cells
        (width, height) of the upright map: the window with the most known cells, padded with unknown. Only with
        "image".
    canvas
        (width, height) of the turned image, about the same centre; by default as large as it needs to be. Only with
        "image".
    hide_resolution
        Whether the resolution is hidden from methods.
    poses
        Source of the scan poses: the true ones, wheel odometry, or the robot's own scan matching.
    loop_closure
        Whether the robot closes loops. Only with poses = "slam".
    slam
        Settings of pose estimation, and the error of the wheels; unused with poses = "truth".
    corruption
        Corruptions on top of the noise, as (name, strength) in order: see `scenarios.corruption.corrupt`.
        The truth follows the points that they move.
    hit, miss
        Log-odds added to a cell by a hit, and subtracted from each cell that a ray passes.

    Raises
    ------
    InputError
        If a value cannot be used.
    """

    resolution: float = 0.05
    turn_deg: float | Literal["random"] = 0.0
    turn: Literal["frame", "image"] = "frame"
    extent_cells: Size | None = None
    canvas: Size | None = None
    hide_resolution: bool = True
    poses: PoseSource = "truth"
    loop_closure: bool = False
    slam: Slam = field(default_factory=Slam)
    corruption: tuple[tuple[str, float], ...] = ()
    hit: float = HIT
    miss: float = MISS

    def __post_init__(self) -> None:
        if not 0.005 <= self.resolution <= 1.0:
            raise InputError(f"resolution must be 0.005 to 1 metres per cell, got {self.resolution}")
        if self.turn_deg != "random" and not (isinstance(self.turn_deg, int | float) and math.isfinite(self.turn_deg)):
            raise InputError(f'turn_deg must be a number of degrees or "random", got {self.turn_deg!r}')
        if self.turn not in ("frame", "image"):
            raise InputError(f'turn must be "frame" or "image", got {self.turn!r}')
        if self.poses not in get_args(PoseSource):
            raise InputError(f"poses must be one of {', '.join(get_args(PoseSource))}, got {self.poses!r}")
        check_corruptions(self.corruption)
        if self.loop_closure and self.poses != "slam":
            raise InputError(f'loop_closure needs poses = "slam", got {self.poses!r}')
        for name, odds in (("hit", self.hit), ("miss", self.miss)):
            if not 0 < odds <= LIMIT:
                raise InputError(f"{name} must be log-odds > 0 and <= {LIMIT:g}, got {odds}")
        for name, size in (("extent_cells", self.extent_cells), ("canvas", self.canvas)):
            if size is not None and (self.turn != "image" or min(size) < 1):
                raise InputError(f'{name} needs turn = "image" and two positive numbers, got {list(size)}')


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlacedMap:
    """Map and the position of the world in it.

    Parameters
    ----------
    grid
        The map as a method sees it.
    turn_deg
        Turn of the building in it, degrees counter-clockwise to the eye.
    poses, true_poses
        Scanner poses that the map was built from, and the true ones: (x, y, yaw) in the world, shape (S, 3).
    """

    grid: OccupancyGrid
    turn_deg: float
    poses: NDArray[np.float64]
    true_poses: NDArray[np.float64]
    _built: OccupancyGrid
    _corrupted: CorruptedMap
    _upright: OccupancyGrid  # corrupted and cropped
    _frame: Similarity  # from the map frame to the world
    _turned: Similarity  # from the upright map's pixels to the grid's

    def world_to_pixel(self, points: ArrayLike) -> NDArray[np.float64]:
        """Take world points (x, y), shape (..., 2), metres, to pixels (u, v) of the map, ignoring pose errors."""
        at = self._frame.inverse().apply(points)
        if self._corrupted.motions:
            at = self._corrupted.grid.pixel_to_map(self._corrupted.map_points(self._built.map_to_pixel(at)))
        return self._turned.apply(self._upright.map_to_pixel(at))

    def shown_at(self, points: NDArray[np.float64], scans: NDArray[np.int64]) -> NDArray[np.float64]:
        """Take world points, shape (N, 2), metres, to the pixels where given scans, shape (N,), place them.

        The points of a scan move with its pose error: by the rigid motion from the true pose to the estimated one.
        """
        true, estimated = self.true_poses[scans], self.poses[scans]  # (N, 3)
        turn, arm = estimated[:, 2] - true[:, 2], points - true[:, :2]
        cos_1, sin = np.cos(turn) - 1.0, np.sin(turn)  # the turn less identity, so that true poses move nothing at all
        swing = np.stack([cos_1 * arm[:, 0] - sin * arm[:, 1], sin * arm[:, 0] + cos_1 * arm[:, 1]], axis=-1)  # (N, 2)
        return self.world_to_pixel(points + (estimated[:, :2] - true[:, :2]) + swing)

    @property
    def origin(self) -> tuple[float, float, float]:
        """Pose of the grid's lower-left corner in the world, as a ROS map's origin: (x, y, yaw)."""
        height = self.grid.shape[0]
        corners = self._turned.inverse().apply([[-0.5, height - 0.5], [0.5, height - 0.5]])
        corner, right = self._frame.apply(self._uncorrupted.apply(self._upright.pixel_to_map(corners)))
        return float(corner[0]), float(corner[1]), math.atan2(right[1] - corner[1], right[0] - corner[0])

    @property
    def resolution(self) -> float:
        """Metres per cell of the grid, even where it is hidden from methods."""
        return float(self._upright.cell_size)

    @property
    def _uncorrupted(self) -> Similarity:
        """The similarity that best takes the map frame of the corrupted map to that of the built map."""
        if not self._corrupted.motions:
            return Similarity()
        height, width = self._built.shape
        pixels = np.stack(np.meshgrid(np.linspace(0, width, 9), np.linspace(0, height, 9)), axis=-1).reshape(-1, 2)
        moved = self._corrupted.grid.pixel_to_map(self._corrupted.map_points(pixels))
        return Similarity.fit(moved, self._built.pixel_to_map(pixels))

    @property
    def ate_m(self) -> float:
        """Absolute trajectory error, metres: RMSE of the positions after the best rigid alignment to the true ones."""
        estimated, true = (poses[:, :2] - poses[:, :2].mean(axis=0) for poses in (self.poses, self.true_poses))
        along, across = (
            float((estimated * true).sum()),
            float((estimated[:, 0] * true[:, 1] - estimated[:, 1] * true[:, 0]).sum()),
        )
        off = Similarity(1.0, math.atan2(across, along)).apply(estimated) - true
        return float(np.sqrt((off**2).sum(axis=1).mean()))


def place_map(
    log: RobotLog,
    lidar: Lidar,
    spec: MapSpec,
    *,
    noise: NoiseLevel | Noise,
    seed: np.random.SeedSequence,
    scan_poses: NDArray[np.float64] | None = None,
) -> PlacedMap:
    """Build, corrupt, crop and turn one robot's map.

    Parameters
    ----------
    log, lidar
        The true ranges, and the scanner that read them.
    spec
        Settings of the map.
    noise
        Noise level, of the scanner, the mapper and the cells.
    seed
        Seed of the turn, the grid's phase and the wheels, which do not depend on the noise level, and of the noise.
    scan_poses
        Poses (S, 3) of the scans, of a robot with real odometry; None estimates them as the spec asks.
    """
    of_frame, of_scans, of_cells, of_poses, of_more, of_noise = _streams(seed)
    random_deg, phase = of_frame.uniform(-180.0, 180.0), of_frame.uniform(0.0, spec.resolution, 2)
    turn_deg = random_deg if spec.turn_deg == "random" else float(spec.turn_deg)
    yaw = -math.radians(turn_deg) if spec.turn == "frame" else 0.0
    frame = (float(log.poses[0, 0] + phase[0]), float(log.poses[0, 1] + phase[1]), yaw)  # about where the robot started
    own_noise = find_noise(noise).of_one_map(of_noise)
    ranges = own_noise.read_out(log, lidar, of_scans)
    if scan_poses is None:
        scan_poses = _estimate(log, lidar, spec, ranges, of_poses)
    built = _build(lidar, spec, ranges, frame, scan_poses, own_noise.least_evidence(spec.hit, spec.miss))
    corrupted = corrupt(own_noise.add(built, of_cells), spec.corruption, seed=int(of_more.integers(1 << 62)))
    upright = corrupted.grid
    if spec.extent_cells is not None:
        upright = crop_to_known(upright, spec.extent_cells)
    grid, turned = upright, Similarity()
    if spec.turn == "image":
        grid, turned = turn_image(upright, turn_deg, spec.canvas)
    if spec.hide_resolution:
        grid = OccupancyGrid(grid.occupancy)
    return PlacedMap(
        grid=grid,
        turn_deg=turn_deg,
        poses=scan_poses,
        true_poses=log.poses,
        _built=built,
        _corrupted=corrupted,
        _upright=upright,
        _frame=Similarity(1.0, frame[2], frame[0], frame[1]),
        _turned=turned,
    )


def recorded_data(
    log: RobotLog, lidar: Lidar, spec: MapSpec, *, noise: NoiseLevel, seed: np.random.SeedSequence
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Return the data that a robot built its map from, for the arguments of `place_map`.

    Returns
    -------
    ranges
        Reported ranges, shape (S, B), metres: inf where nothing is in reach, nan where a beam was lost.
    wheels
        Wheel odometry, shape (S, 3): the mapper's input, or the log's where the mapper had the truth.
    least_evidence
        Log-odds up to which the mapper leaves a cell unknown.
    """
    _, of_scans, _, of_poses, _, of_noise = _streams(seed)
    wheels = (
        log.odometry if spec.poses == "truth" else simulate_odometry(log.poses, of_poses, level=spec.slam.wheel_level)
    )
    own_noise = find_noise(noise).of_one_map(of_noise)
    return own_noise.read_out(log, lidar, of_scans), wheels, own_noise.least_evidence(spec.hit, spec.miss)


def _streams(seed: np.random.SeedSequence) -> list[np.random.Generator]:
    """Return generators for frame, scans, cells, poses, corruptions and strengths of noise; the same on each call."""
    own = np.random.SeedSequence(seed.entropy, spawn_key=seed.spawn_key)  # spawning from the other would change it
    return [np.random.default_rng(child) for child in own.spawn(6)]


def _estimate(
    log: RobotLog, lidar: Lidar, spec: MapSpec, ranges: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float64]:
    """Estimate the poses (S, 3) of the scans that were read."""
    return estimate_poses(
        spec.poses,
        poses=log.poses,
        angles=lidar.angles,
        ranges=ranges,
        max_range_m=lidar.max_range_m,
        rng=rng,
        loop_closure=spec.loop_closure,
        slam=spec.slam,
    )


def _build(
    lidar: Lidar,
    spec: MapSpec,
    ranges: NDArray[np.float64],
    frame: tuple[float, float, float],
    poses: NDArray[np.float64],
    least_evidence: float,
) -> OccupancyGrid:
    return build_map(
        poses,
        lidar.angles,
        ranges,
        resolution=spec.resolution,
        max_range_m=lidar.max_range_m,
        frame=frame,
        hit=spec.hit,
        miss=spec.miss,
        least_evidence=least_evidence,
    )
