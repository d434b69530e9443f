"""Robot in the simulation: odometry, scans and their log."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import SimulationError
from sim.bullet import TRACK_M, WHEEL_RADIUS_M, Physics
from sim.missions.mission_log import FEWEST_SCANS, RobotLog
from sim.missions.spec import RobotSpec
from sim.motion.coverage import SeenFloor
from sim.motion.piloting import Pilot
from sim.sensors.lidar import RayHits
from sim.sensors.ray_casting import Caster
from sim.world import World, covers


class Robot:
    """Robot with its pilot and its log.

    Parameters
    ----------
    bullet
        The simulation.
    spec
        Settings of the robot.
    pilot
        Its driver.
    start
        Pose (x, y, yaw).
    visit
        0 for A, 1 for B: whose things stand about.
    seen
        Floor that it has seen, updated with every scan; None where it is not needed.
    caster
        Compiled caster of its rays; None for the rays of PyBullet.
    """

    def __init__(
        self,
        bullet: Physics,
        spec: RobotSpec,
        pilot: Pilot,
        start: NDArray[np.float64],
        *,
        visit: int,
        seen: SeenFloor | None,
        caster: Caster | None,
    ) -> None:
        self._bullet, self._spec, self._caster = bullet, spec, caster
        self.pilot, self.seen, self.start = pilot, seen, start
        self._body = bullet.add_robot(start, visit=visit)
        self._angles = spec.lidar.angles
        self._odometry, self._wheels = start.copy(), (0.0, 0.0)
        self._times: list[float] = []
        self._poses: list[NDArray[np.float64]] = []
        self._counted: list[NDArray[np.float64]] = []
        self._readings: list[RayHits] = []

    @property
    def pose(self) -> NDArray[np.float64]:
        """True pose, (x, y, yaw)."""
        return self._bullet.pose(self._body)

    def control(self, time: float) -> None:
        """Update odometry and set the speeds of the wheels."""
        wheels = self._bullet.wheel_angles(self._body)
        left, right = ((new - old) * WHEEL_RADIUS_M for new, old in zip(wheels, self._wheels, strict=True))
        self._wheels = wheels
        heading = self._odometry[2] + (right - left) / TRACK_M / 2
        ahead = (left + right) / 2
        step = [ahead * math.cos(heading), ahead * math.sin(heading), (right - left) / TRACK_M]
        self._odometry = self._odometry + step
        self._bullet.drive(self._body, *self.pilot.command(self.pose, time))

    def scan(self, time: float, others: NDArray[np.float64]) -> None:
        """Log one scan; `others` are the poses of the other robots, shape (N, 3)."""
        pose, lidar = self.pose, self._spec.lidar
        if self._caster is None:
            reading = self._bullet.cast(self._body, self._angles, lidar.max_range_m, lidar.height_m)
        else:
            reading = self._caster.cast(pose, self._angles, lidar.max_range_m, others)
        self._times.append(time)
        self._poses.append(pose)
        self._counted.append(self._odometry)
        self._readings.append(reading)

    def look(self) -> None:
        """Add the last scan to the seen floor, and plan anew where it changes the path."""
        if self.seen is not None:
            self.seen.add(self._poses[-1][None], self._readings[-1].ranges[None])
            if self.pilot.guide.is_path_outdated():
                self.pilot.replan()

    def log(self, world: World) -> RobotLog:
        """Return the log, with the rooms of the building that the robot entered.

        Raises
        ------
        SimulationError
            If there are too few scans to make a map.
        """
        if len(self._times) < FEWEST_SCANS:
            why = self.pilot.note or "its path was short"
            raise SimulationError(f"a robot made only {len(self._times)} scans: {why}")
        times, poses = np.array(self._times), np.array(self._poses)
        glass = np.array([reading.glass for reading in self._readings])
        rooms = _entered(world, times, poses)
        log = RobotLog(
            times=times,
            poses=poses,
            odometry=np.array(self._counted),
            ranges=np.array([reading.ranges for reading in self._readings]),
            glass=glass if np.isfinite(glass).any() else None,
            rooms=tuple(name for _, name in rooms),
            entered=tuple(time for time, _ in rooms),
            note=self.pilot.note,
        )
        return log.with_stuck_noted()


def _entered(world: World, times: NDArray[np.float64], poses: NDArray[np.float64]) -> list[tuple[float, str]]:
    """Return the time and name of the first visit of each room, in order."""
    inside = [(room.name, covers(room.outline, poses[:, :2])) for room in world.rooms]
    return sorted((float(times[np.argmax(was_in)]), name) for name, was_in in inside if was_in.any())
