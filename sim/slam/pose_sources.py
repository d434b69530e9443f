"""Sources of the poses of scans: the truth, wheel odometry, or SLAM."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from sim.slam.loop_closure import RECENT, KeyScans, propagate_corrections
from sim.slam.odometry import simulate_odometry
from sim.slam.poses import compose_poses, relative_poses
from sim.slam.scan_matching import scan_hits

PoseSource = Literal["truth", "odometry", "slam"]

FEWEST_POINTS = 12  # a scan with fewer is not matched
STILL_M, STILL_RAD = 0.01, math.radians(0.3)  # a smaller step is taken from the wheels
PRIOR_WEIGHTS = (5.0, 4.0)  # of odometry: score that a match must gain per m^2 and per rad^2 of departure


@dataclass(frozen=True, slots=True, kw_only=True)
class Slam:
    """Settings of a mapper.

    Parameters
    ----------
    resolution_m
        Cells of the map that scans are matched against, metres.
    key_distance_m, key_turn_deg
        A scan enters the map when the robot has moved or turned by more since the last that did.
    beams
        At most so many readings of a scan are matched, spread evenly over it.
    window_m, window_deg
        Largest departure of a scan from odometry, each way.
    fewest_share
        Score of a match below which the pose is taken from odometry, 0..1.
    wheel_level
        Multiplies the noise of odometry; 1 is `sim.slam.odometry.WheelNoise()`.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    resolution_m: float = 0.05
    key_distance_m: float = 0.3
    key_turn_deg: float = 15.0
    beams: int = 180
    window_m: float = 0.15
    window_deg: float = 5.0
    fewest_share: float = 0.25
    wheel_level: float = 1.0

    def __post_init__(self) -> None:
        bounds = {
            "resolution_m": (0.01, 0.5),
            "key_distance_m": (0.0, 5.0),
            "key_turn_deg": (0.0, 180.0),
            "beams": (FEWEST_POINTS, 3600),
            "window_m": (0.0, 2.0),
            "window_deg": (0.0, 45.0),
            "fewest_share": (0.0, 1.0),
            "wheel_level": (0.0, 100.0),
        }
        for name, (low, high) in bounds.items():
            if not low <= getattr(self, name) <= high:
                raise InputError(f"{name} must be {low} to {high}, got {getattr(self, name)}")


def estimate_poses(
    source: PoseSource,
    *,
    poses: NDArray[np.float64],
    angles: NDArray[np.float64],
    ranges: NDArray[np.float64],
    max_range_m: float,
    rng: np.random.Generator,
    loop_closure: bool = False,
    slam: Slam | None = None,
) -> NDArray[np.float64]:
    """Estimate the poses of the scans of one robot from its own data.

    Parameters
    ----------
    source
        ``"truth"``: the true poses, as from a motion capture system; its maps are rigid.
        ``"odometry"``: the wheels alone (`sim.slam.odometry.simulate_odometry`). Errors grow without bound.
        ``"slam"``: each scan is matched with the map made so far, starting from odometry
        (`sim.slam.scan_matching`). Walls are sharp; rooms and corridors are bent against each other by a degree or so,
        corridors without features get shorter or longer, and now and then a map tears.
    poses
        True poses (x, y, yaw) at the scans, shape (S, 3), S >= 1, metres and radians.
    angles
        Beam directions from the heading, shape (B,), radians.
    ranges
        Readings of the scanner, shape (S, B), metres: inf where nothing is in reach, nan where there is no reading.
    max_range_m
        Range up to which a beam without a hit shows free space.
    rng
        Source of the noise of odometry; the same state gives the same bytes.
    loop_closure
        Whether the mapper closes loops (`sim.slam.loop_closure`); only for ``"slam"``.
    slam
        Settings of the mapper and level of the noise of odometry; `Slam()` where nothing is given.

    Returns
    -------
    NDArray
        Shape (S, 3), yaw in -pi..pi but for the truth; the first pose is the true one, for a map's frame is free.

    Raises
    ------
    InputError
        If the source is unknown, or shapes or numbers cannot be used.

    Notes
    -----
    The mapper knows the true poses through odometry only; a scan without readings, or one that matches nowhere, is
    placed by odometry.
    """
    if source not in get_args(PoseSource):
        raise InputError(f"source must be one of {', '.join(get_args(PoseSource))}, got {source!r}")
    _check(poses, angles, ranges, max_range_m)
    if source == "truth":
        return poses.copy()
    slam = slam or Slam()
    blind = simulate_odometry(poses, rng, level=slam.wheel_level)
    if source == "odometry":
        return blind
    return match_scans(blind, angles, ranges, max_range_m=max_range_m, loop_closure=loop_closure, slam=slam)


def match_scans(
    odometry: NDArray[np.float64],
    angles: NDArray[np.float64],
    ranges: NDArray[np.float64],
    *,
    max_range_m: float,
    loop_closure: bool = False,
    slam: Slam | None = None,
    on_scan: Callable[[], None] = lambda: None,
) -> NDArray[np.float64]:
    """Estimate the poses of the scans of one robot from odometry and readings.

    Parameters
    ----------
    odometry
        Poses of the scanner by the wheels, (x, y, yaw), shape (S, 3), S >= 1, metres and radians.
    angles, ranges, max_range_m, loop_closure
        As `estimate_poses` has them.
    slam
        Settings of the mapper; `wheel_level` has no effect here. `Slam()` where nothing is given.
    on_scan
        Called after every scan but the first.

    Returns
    -------
    NDArray
        Shape (S, 3), yaw in -pi..pi; the first pose is the first of `odometry`.

    Raises
    ------
    InputError
        If shapes or numbers cannot be used.
    """
    _check(odometry, angles, ranges, max_range_m)
    mapper = _Mapper(slam or Slam(), angles, max_range_m, odometry[0], ranges[0], loop_closure)
    for step, scan in zip(relative_poses(odometry[:-1], odometry[1:]), ranges[1:], strict=True):
        mapper.add(step, scan)
        on_scan()
    return mapper.poses()


def _check(
    poses: NDArray[np.float64], angles: NDArray[np.float64], ranges: NDArray[np.float64], max_range_m: float
) -> None:
    if poses.ndim != 2 or poses.shape[1] != 3 or not len(poses) or ranges.shape != (len(poses), angles.size):
        raise InputError(f"poses (S, 3), angles (B,) and ranges (S, B) disagree: {poses.shape}, {ranges.shape}")
    if not np.isfinite(poses).all():
        raise InputError("poses must be finite numbers")
    if not (math.isfinite(max_range_m) and max_range_m > 0):
        raise InputError(f"max_range_m must be a positive number of metres, got {max_range_m}")


class _Mapper:
    """Mapper of one robot: its pose, its map, and its key scans."""

    def __init__(
        self,
        slam: Slam,
        angles: NDArray[np.float64],
        max_range_m: float,
        start: NDArray[np.float64],
        ranges: NDArray[np.float64],
        loop_closure: bool,
    ) -> None:
        self.slam, self.angles, self.closes = slam, angles, loop_closure
        self.pose, self.trail, self.kept = start, [start], [0]
        self.keys = KeyScans(angles, max_range_m, slam.resolution_m, slam.beams)
        self.keys.add(start, ranges)
        self.map, self.map_from = self.keys.make_map(np.array([0])), 0

    def add(self, step: NDArray[np.float64], ranges: NDArray[np.float64]) -> None:
        """Move by odometry, match the scan, and keep it where the robot has moved enough."""
        before, self.pose = self.pose, self._located(step, ranges)
        self.trail.append(compose_poses(self.trail[-1], relative_poses(before, self.pose)))
        moved = relative_poses(self.keys.poses[-1], self.pose)
        far = math.hypot(moved[0], moved[1]) > self.slam.key_distance_m
        if far or abs(moved[2]) > math.radians(self.slam.key_turn_deg):
            self.kept.append(len(self.trail) - 1)
            self.keys.add(self.pose, ranges)
            self._renew_map()

    def poses(self) -> NDArray[np.float64]:
        """Return the present estimate of all poses, shape (S, 3)."""
        return propagate_corrections(np.array(self.trail), np.array(self.kept), self.keys.poses)

    def _located(self, step: NDArray[np.float64], ranges: NDArray[np.float64]) -> NDArray[np.float64]:
        guess = compose_poses(self.pose, step)
        points = scan_hits(self.angles, ranges, self.slam.beams)
        is_still = math.hypot(step[0], step[1]) < STILL_M and abs(step[2]) < STILL_RAD
        if is_still or len(points) < FEWEST_POINTS:
            return guess
        window_rad = math.radians(self.slam.window_deg)
        match = self.map.match(
            points, guess, window_m=self.slam.window_m, window_rad=window_rad, prior_weights=PRIOR_WEIGHTS
        )
        return match.pose if match.score >= self.slam.fewest_share else guess

    def _renew_map(self) -> None:
        """Add the newest key scan to the map; after a closed loop, begin a new map with the recent ones."""
        count = len(self.keys.poses)
        if self.closes and (self.keys.close_loop() or count - self.map_from > 2 * RECENT):
            self.pose = self.keys.poses[-1]
            self.map_from = max(0, count - RECENT)
            self.map = self.keys.make_map(np.arange(self.map_from, count))
        else:
            self.keys.add_to_map(self.map, np.array([count - 1]))
