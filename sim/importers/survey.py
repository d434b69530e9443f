"""Surveys of a place from CARMEN logs: the scans of a moving robot, and the poses for its map."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, cast, get_args

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from sim.importers.carmen import CarmenLog
from sim.missions.mission_log import FEWEST_SCANS, RobotLog
from sim.sensors.lidar import Lidar
from sim.slam.mapping import build_map
from sim.slam.pose_sources import Slam, match_scans
from sim.slam.poses import compose_poses, relative_poses

PoseChoice = Literal["auto", "log", "match"]
STILL_M, STILL_RAD = 0.05, math.radians(2.0)  # a scan that moved less since the last one shows nothing new
MOST_KEYS = 1000  # key scans of a graph that is solved with dense matrices; more would take minutes
WHOLE = 1e-3  # of a beam; numbers in logs are rounded
WINDOW_M, WINDOW_DEG = 0.3, 10.0  # real wheels slip, and scans may lie far apart


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Survey:
    """Survey of a place by one robot.

    Parameters
    ----------
    robot
        Its scans; `poses` are those of its map, the best truth there is, and `odometry` those of the wheels.
    lidar
        Its laser, with its heading in the middle of the beams: the poses are turned accordingly.
    is_matched
        Whether the poses come from scan matching, not from the log.
    """

    robot: RobotLog
    lidar: Lidar
    is_matched: bool

    def map(self, resolution: float) -> OccupancyGrid:
        """Make a map of all scans, at a resolution in metres per cell, in the frame of the poses."""
        return build_map(
            self.robot.poses,
            self.lidar.angles,
            self.lidar.limit(self.robot.ranges),
            resolution=resolution,
            max_range_m=self.lidar.max_range_m,
        )

    def part(self, first: int, end: int) -> RobotLog:
        """Return the log of the scans from `first` to `end`, exclusive.

        Raises
        ------
        InputError
            If there are fewer than 10 scans.
        """
        if min(end, len(self.robot.times)) - max(first, 0) < FEWEST_SCANS:
            raise InputError(
                f"scans {first} to {end} of {len(self.robot.times)} with movement are too few for a map: "
                f"a part needs {FEWEST_SCANS}"
            )
        part = slice(max(first, 0), end)
        arrays = {name: getattr(self.robot, name)[part] for name in ("times", "poses", "odometry", "ranges")}
        return replace(self.robot, **arrays)

    def map_poses(self, part: RobotLog) -> NDArray[np.float64]:
        """Return the poses (S, 3) of the map of a part alone; the first is that of the whole survey.

        Matched poses are matched anew, so that a part is independent of the others.
        """
        if not self.is_matched:
            return part.poses
        odometry = compose_poses(part.poses[0], relative_poses(part.odometry[0], part.odometry))
        return _match_poses(odometry, self.lidar, part.ranges)


def survey(
    log: CarmenLog, *, poses: PoseChoice = "auto", on_scan: Callable[[int], None] = lambda scans: None
) -> Survey:
    """Choose the scans of a log with movement, and their poses.

    Parameters
    ----------
    log
        The log.
    poses
        "auto": the corrected poses where the log has them, else scan matching. "log": the poses of the log, corrected
        or not, for logs with corrected odometry. "match": scan matching in any case.
    on_scan
        Called with the number of further scans that are done, of all in the log.

    Raises
    ------
    InputError
        If fewer than 10 scans have movement.

    Notes
    -----
    A scan is kept where the robot moved by 5 cm or 2 degrees since the last that was. Scans are matched as
    `sim.slam.pose_sources.match_scans` does, with loop closure, from the odometry; the longer the path, the fewer scans
    are key scans, so that there are a thousand or two at the most.
    """
    parse_pose_choice(poses)
    is_matched = poses == "match" or (poses == "auto" and log.poses is None)
    source = log.odometry if is_matched or log.poses is None else log.poses
    kept = _moving_scans(source)
    if len(kept) < FEWEST_SCANS:
        raise InputError(f"{len(kept)} of {len(log.times)} scans have movement; a map needs {FEWEST_SCANS}")
    lidar = _make_lidar(log)
    middle = np.array([0.0, 0.0, log.angles[: lidar.beams].mean()])
    odometry, laid = compose_poses(log.odometry[kept], middle), compose_poses(source[kept], middle)
    ranges = log.ranges[kept, : lidar.beams]
    on_scan(len(log.times) - len(kept) + 1)
    if is_matched:
        laid = _match_poses(odometry, lidar, ranges, on_scan)
    else:
        on_scan(len(kept) - 1)
    robot = RobotLog(times=log.times[kept], poses=laid, odometry=odometry, ranges=ranges)
    return Survey(robot=robot, lidar=lidar, is_matched=is_matched)


def parse_pose_choice(name: str) -> PoseChoice:
    """Parse the name of a choice of poses, or raise InputError."""
    for choice in get_args(PoseChoice):
        if name == choice:
            return cast(PoseChoice, choice)
    raise InputError(f"poses must be one of {', '.join(get_args(PoseChoice))}, got {name!r}")


def _moving_scans(poses: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the scans (K,) with movement since the last kept scan."""
    kept = [0]
    x, y, yaw = poses[0]
    for k, (u, v, turned) in enumerate(poses.tolist()):
        if math.hypot(u - x, v - y) > STILL_M or abs(math.remainder(turned - yaw, 2 * math.pi)) > STILL_RAD:
            kept.append(k)
            x, y, yaw = u, v, turned
    return np.array(kept, dtype=np.int64)


def _make_lidar(log: CarmenLog) -> Lidar:
    """Make a scanner of the beams of a log, without those beyond a full turn."""
    count = len(log.angles)
    step = math.degrees(log.angles[1] - log.angles[0]) if count > 1 else 1.0
    count = min(count, math.floor(360.0 / step + WHOLE))
    return Lidar(beams=count, fov_deg=min(360.0, count * step), min_range_m=0.0, max_range_m=log.max_range_m)


def _match_poses(
    odometry: NDArray[np.float64],
    lidar: Lidar,
    ranges: NDArray[np.float64],
    on_scan: Callable[[int], None] = lambda scans: None,
) -> NDArray[np.float64]:
    steps = relative_poses(odometry[:-1], odometry[1:])
    way_m, turn_deg = float(np.hypot(steps[:, 0], steps[:, 1]).sum()), math.degrees(np.abs(steps[:, 2]).sum())
    usual = Slam()
    slam = Slam(
        key_distance_m=min(5.0, max(usual.key_distance_m, way_m / MOST_KEYS)),
        key_turn_deg=min(180.0, max(usual.key_turn_deg, turn_deg / MOST_KEYS)),
        window_m=WINDOW_M,
        window_deg=WINDOW_DEG,
    )
    return match_scans(
        odometry,
        lidar.angles,
        ranges,
        max_range_m=lidar.max_range_m,
        loop_closure=True,
        slam=slam,
        on_scan=lambda: on_scan(1),
    )
