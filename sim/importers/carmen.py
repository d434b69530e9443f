"""CARMEN logs: the scans of one laser, its odometry, and its corrected poses where the log has them."""

from __future__ import annotations

import gzip
import math
import os
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.io.image_file import require_file
from sim.importers.carmen_lines import FLASER, ROBOTLASER, Laser, parse_finite, parse_scan, require_words
from sim.slam.poses import compose_poses, relative_poses, wrap_angles

STEPS_DEG = {180: 1.0, 181: 1.0, 360: 0.5, 361: 0.5, 400: 0.25, 401: 0.25, 540: 0.5, 541: 0.5}  # by readings
FARTHEST_READING_M, NEAR_FARTHEST_M = 80.0, 0.01  # larger readings of a SICK are error codes
REACH_M = 30.0
MOST_LINE_BYTES, MOST_READINGS = 1_000_000, 50_000_000
CORRECTED_M, CORRECTED_RAD, CORRECTED_SHARE = 0.02, 0.01, 0.05
MOVED = 1e-6  # smaller movements are none
Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CarmenLog:
    """Log of one laser: S scans of B beams.

    Parameters
    ----------
    times
        IPC timestamps, shape (S,), seconds.
    odometry
        Poses of the laser by the wheels, (x, y, yaw), shape (S, 3), metres and radians.
    poses
        Corrected poses of the laser, shape (S, 3); None where the log has none.
    angles
        Directions of the beams from the laser's heading, shape (B,), radians.
    ranges
        Shape (S, B), metres: inf where the beam met nothing nearer than `max_range_m`, nan where there is no reading.
    max_range_m
        Range up to which readings are used.
    """

    times: Array
    odometry: Array
    poses: Array | None
    angles: Array
    ranges: Array
    max_range_m: float


def read_carmen(path: str | os.PathLike[str], *, every: int = 1, reach_m: float = REACH_M) -> CarmenLog:
    """Read a CARMEN log, plain or as ``.gz``.

    Parameters
    ----------
    path
        The log.
    every
        Keep one scan in so many.
    reach_m
        Larger readings count as free space up to this range.

    Raises
    ------
    InputError
        If the file cannot be read, has no scan, or a line of it cannot be used; the message names file and line.

    Notes
    -----
    The messages are those of CARMEN's logger (carmen.sourceforge.net/logger_playback.html)::

        FLASER n [n ranges] x y theta odom_x odom_y odom_theta TAIL
        ROBOTLASER1 type start_angle fov resolution maximum accuracy remission_mode n [n ranges] m [m remissions]
            laser_x laser_y laser_theta robot_x robot_y robot_theta tv rv forward side turn_axis TAIL
        ODOM x y theta tv rv accel TAIL

    where TAIL is ``ipc_timestamp host logger_timestamp``, of which host and logger's timestamp may be missing. Older
    logs have ROBOTLASER1 without ``m [m remissions]``. Of FLASER and ROBOTLASER1, which may both report one laser,
    the kind that comes first is read. All other messages are skipped, and so is a last line that is cut off.

    FLASER has no directions: 180 or 181 readings are a degree apart, 360, 361, 540 or 541 half a degree, 400 or 401
    a quarter, the middle one straight ahead, or the one after the middle where their number is even: the last beam is
    left out. The number and the first of the beams are from CARMEN's readlog.c, 540 and 541 from GMapping's Carmen
    configuration. Any other number is as far apart as ``PARAM laser_front_laser_resolution`` says, in degrees, or
    spread over ``PARAM laser_front_laser_fov``, or over 180 degrees as in readlog.c. That the fov is in degrees is from
    memory.

    A reading of the maximum or more is no reading, as in GMapping: the laser reports it where nothing is in reach, and
    also where glass, black or the sun swallowed the beam. The maximum is ROBOTLASER1's or ``PARAM
    robot_front_laser_max``, at most 80 m, which readlog.c takes; beyond, a SICK reports codes, 81.83 m and more (from
    memory).

    In a raw log the laser's pose and the robot's are one rigid motion apart; then there is no correction, and the
    laser's is the odometry. Where they are not, by more than 2 cm or 0.01 rad in more than a twentieth of the scans,
    the laser's pose is the corrected one. Where scans have no odometry of their own (always the same pose), it is
    interpolated between ODOM lines at the time of a scan. Such odometry, and that of a corrected log, is the robot's,
    with the laser ``PARAM robot_frontlaser_offset`` ahead.
    """
    if every < 1:
        raise InputError(f"every must be >= 1, got {every}")
    if not (math.isfinite(reach_m) and reach_m > 0):
        raise InputError(f"reach_m must be a positive number of metres, got {reach_m}")
    file = Path(path)
    require_file(file)
    reader = _LogReader(every)
    for number, line in _lines(file):
        try:
            reader.add(line.split())
        except InputError as error:
            if line.endswith(b"\n"):
                raise InputError(f"{file}:{number}: {error}") from None  # else it is the last, and cut off
    if not reader.scans:
        raise InputError(
            f"{file}: there is no scan in it: a CARMEN log has lines that begin with FLASER or ROBOTLASER1"
        )
    try:
        return reader.log(reach_m)
    except InputError as error:
        raise InputError(f"{file}: {error}") from None


def _lines(file: Path) -> Iterator[tuple[int, bytes]]:
    number = 0
    try:
        with gzip.open(file) if file.suffix == ".gz" else file.open("rb") as stream:
            while line := stream.readline(MOST_LINE_BYTES + 1):
                number += 1
                if len(line) > MOST_LINE_BYTES:
                    raise InputError(f"{file}:{number}: longer than {MOST_LINE_BYTES} bytes: this is no CARMEN log")
                yield number, line
    except (OSError, EOFError, zlib.error) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{file}: cannot be read after line {number}: {reason}") from None


@dataclass(slots=True)
class _LogReader:
    """Reader of the lines of a log."""

    every: int
    laser: Laser | None = None
    seen: int = 0
    scans: list[NDArray[np.float32]] = field(default_factory=list)  # (B,)
    stamps: list[list[float]] = field(default_factory=list)  # laser's pose, robot's pose, time
    wheels: list[list[float]] = field(default_factory=list)  # ODOM: x, y, theta, time
    params: dict[str, str] = field(default_factory=dict)

    def add(self, words: list[bytes]) -> None:
        """Read a line, split into words."""
        kind = words[0] if words else b""
        if kind == b"PARAM" and len(words) > 2:
            self.params[words[1].decode("ascii", "replace")] = words[2].decode("ascii", "replace")
        elif kind == b"ODOM":
            require_words(words, 8)
            self.wheels.append(parse_finite([*words[1:4], words[7]]))
        elif kind in (FLASER, ROBOTLASER) and (self.laser is None or self.laser.kind == kind):
            self._add_scan(words)

    def _add_scan(self, words: list[bytes]) -> None:
        self.seen += 1
        if (self.seen - 1) % self.every:
            return
        scan = parse_scan(words)
        self.laser = self.laser or scan.laser
        if scan.laser != self.laser:
            raise InputError(f"a scan of {scan.laser} after scans of {self.laser}: cut the log where the laser changes")
        if (len(self.scans) + 1) * scan.laser.readings > MOST_READINGS:
            raise InputError(
                f"more than {MOST_READINGS // 10**6} million readings: keep every N-th scan only (--every N)"
            )
        self.scans.append(scan.ranges)
        self.stamps.append(scan.stamp)

    def log(self, reach_m: float) -> CarmenLog:
        """Return the log of all lines that were read."""
        if self.laser is None:
            raise InputError("there is no scan in it")
        stamps, named_m = np.array(self.stamps), self.laser.maximum_m or self._param("robot_front_laser_max")
        maximum_m = min(named_m or FARTHEST_READING_M, FARTHEST_READING_M)
        odometry, poses = self._choose_poses(stamps[:, :3], stamps[:, 3:6], stamps[:, 6])
        ranges = np.array(self.scans, dtype=np.float64)  # (S, B)
        ranges[(ranges >= maximum_m - NEAR_FARTHEST_M) | (ranges <= 0)] = np.nan
        ranges[ranges > reach_m] = np.inf
        return CarmenLog(
            times=stamps[:, 6],
            odometry=odometry,
            poses=poses,
            angles=self._angles(self.laser),
            ranges=ranges,
            max_range_m=min(maximum_m, reach_m),
        )

    def _angles(self, laser: Laser) -> Array:
        if laser.start is not None and laser.step is not None:
            return laser.start + laser.step * np.arange(laser.readings, dtype=np.float64)
        count = laser.readings
        step, middle = STEPS_DEG.get(count) or self._param("laser_front_laser_resolution"), count // 2 * 1.0
        if step is None:
            middle = (count - 1) / 2
            step = (self._param("laser_front_laser_fov") or 180.0) / max(1, count - 1)
        if step * (count - 1) > 360:
            raise InputError(f"{count} readings {step:g} degrees apart go more than once around")
        return math.radians(step) * (np.arange(count, dtype=np.float64) - middle)

    def _choose_poses(self, laser: Array, robot: Array, times: Array) -> tuple[Array, Array | None]:
        """Return the odometry and the corrected poses of the laser, from the poses (S, 3) in its scans."""
        offset = np.array([self._param("robot_frontlaser_offset") or 0.0, 0.0, 0.0])
        if not _moves(robot) and len(self.wheels) > 1:
            robot = _interpolated(np.array(self.wheels), times)
        elif not _moves(robot):
            robot = laser
        if not _moves(laser):
            return compose_poses(robot, offset), None
        return (compose_poses(robot, offset), laser) if _are_corrected(laser, robot) else (laser, None)

    def _param(self, name: str) -> float | None:
        """Return a parameter that is a positive number; None where there is none."""
        try:
            value = float(self.params.get(name, ""))
        except ValueError:
            return None
        return value if math.isfinite(value) and value > 0 else None


def _moves(poses: Array) -> bool:
    return bool(np.ptp(poses, axis=0).max() > MOVED)


def _interpolated(wheels: Array, times: Array) -> Array:
    """Return the poses (S, 3) of ODOM lines (x, y, theta, time), shape (N, 4), at times (S,)."""
    wheels = wheels[np.argsort(wheels[:, 3], kind="stable")]
    wheels[:, 2] = np.unwrap(wheels[:, 2])
    poses = np.stack([np.interp(times, wheels[:, 3], wheels[:, k]) for k in range(3)], axis=-1)  # (S, 3)
    poses[:, 2] = wrap_angles(poses[:, 2])
    return poses


def _are_corrected(laser: Array, robot: Array) -> bool:
    """Return whether the poses (S, 3) of the laser and of the robot are not one rigid motion apart."""
    offset = relative_poses(robot, laser)
    offset[:, 2] = wrap_angles(offset[:, 2] - offset[0, 2])
    off = np.abs(offset - np.median(offset, axis=0))
    is_off = (np.hypot(off[:, 0], off[:, 1]) > CORRECTED_M) | (off[:, 2] > CORRECTED_RAD)
    return bool(is_off.mean() > CORRECTED_SHARE)
