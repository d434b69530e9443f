"""Small CARMEN logs of a robot that tours an office, written as CARMEN's logger does."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sim.sensors.ray_casting import Caster
from sim.slam.odometry import simulate_odometry
from sim.slam.poses import compose_poses
from sim.world import World
from tests.sim.small_worlds import plain_office, walked_log

SICK = np.radians(np.arange(-90.0, 90.5, 1.0))  # 181 beams
NOTHING_M = 81.83
HEAD = b"# CARMEN Logfile\n# FLASER num_readings [range_readings] x y theta odom_x odom_y odom_theta\n\n"
NOISE = b"PARAM robot_length 0.5 nohost 0\r\nSYNC caf\xe9 nohost 0\nRLASER 2 1.0 1.0 0 0 0 0 0 0 0.5 nohost 0.5\n"


@dataclass(frozen=True)
class Walk:
    """Walk of a robot: true poses and odometry (S, 3), and readings of its laser (S, B), inf for nothing."""

    world: World
    poses: NDArray[np.float64]
    odometry: NDArray[np.float64]
    ranges: NDArray[np.float64]
    angles: NDArray[np.float64]

    def replaced(self, **changes: object) -> Walk:
        return replace(self, **changes)


@functools.cache
def office_walk(level: float = 1.0) -> Walk:
    """Make a tour of a small office and some way back, with a scan every 0.2 to 0.3 m."""
    world, poses = plain_office(4, oblique=0.0), walked_log().a.poses
    caster, rng = Caster(world, 0.25), np.random.default_rng(0)
    ranges = np.array([caster.cast(pose, SICK, 30.0, np.empty((0, 3))).ranges for pose in poses])
    ranges += rng.normal(0.0, 0.01, ranges.shape)
    return Walk(world, poses, simulate_odometry(poses, rng, level=level), ranges, SICK)


def numbers(values: object) -> str:
    return " ".join(f"{value:.6f}" for value in np.ravel(values))


def readings(ranges: NDArray[np.float64]) -> str:
    return " ".join(f"{value:.2f}" for value in np.where(np.isfinite(ranges), ranges, NOTHING_M))


def tail(k: int) -> str:
    return f"{100 + 0.25 * k:.6f} nohost {0.25 * k:.6f}"


def flaser(walk: Walk, *, is_corrected: bool, odometry: bool = True) -> bytes:
    """Write the scans as FLASER; without odometry its columns are zero."""
    robot = walk.odometry if odometry else np.zeros_like(walk.poses)
    laser = walk.poses if is_corrected else robot
    lines = [
        f"FLASER {len(seen)} {readings(seen)} {numbers(laser[k])} {numbers(robot[k])} {tail(k)}"
        for k, seen in enumerate(walk.ranges)
    ]
    return HEAD + NOISE + ("\n".join(lines) + "\n").encode()


def robotlaser(walk: Walk, *, is_corrected: bool, ahead_m: float = 0.2, remissions: str | None = "0") -> bytes:
    """Write the scans as ROBOTLASER1, of a laser mounted ahead of the middle of the robot."""
    step, robot = walk.angles[1] - walk.angles[0], compose_poses(walk.odometry, np.array([-ahead_m, 0.0, 0.0]))
    laser = walk.poses if is_corrected else walk.odometry
    config = f"0 {walk.angles[0]:.6f} {math.pi:.6f} {step:.9f} 81.92 0.01 0"
    lines = [
        f"ROBOTLASER1 {config} {len(seen)} {readings(seen)} {remissions + ' ' if remissions else ''}"
        f"{numbers(laser[k])} {numbers(robot[k])} 0.1 0.0 0.5 0.3 1e6 {tail(k)}"
        for k, seen in enumerate(walk.ranges)
    ]
    return HEAD + NOISE + ("\n".join(lines) + "\n").encode()


def odom(walk: Walk) -> bytes:
    """Write the odometry as ODOM, a tenth of a second before each scan and after it."""
    lines = [f"ODOM {numbers(pose)} 0.1 0.0 0.0 {tail(k)}" for k, pose in enumerate(walk.odometry)]
    return ("\n".join(lines) + "\n").encode()


def write_log(path: Path, *parts: bytes) -> Path:
    path.write_bytes(b"".join(parts))
    return path
