"""Missions: two robots tour one building in one simulation; the log keeps what their lasers could know, exactly."""

from __future__ import annotations

import io
import json
import math
import zipfile
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import cattrs
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError, SimulationError
from rectmerge.imagefile import replace_file
from sim.bullet import TRACK_M, WHEEL_RADIUS_M, Physics, physics
from sim.driving import Steering, drivable
from sim.exploration import Tour, make_tour, share_rooms
from sim.lidar import Lidar
from sim.world import World

CONTROL_EVERY = 3  # physics steps per control step
FEWEST_SCANS = 10
BROKEN = (  # what a foreign file may raise
    *(OSError, EOFError, zipfile.BadZipFile, ValueError, KeyError, TypeError, AttributeError),
    cattrs.BaseValidationError,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSpec:
    """What one robot is and how it explores.

    Parameters
    ----------
    lidar
        Its scanner.
    speed_m_s
        Top speed.
    scan_hz
        Scans that are kept per simulated second.
    share
        Share of the rooms that it tours: A from one end of the building, B from the other.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    lidar: Lidar = field(default_factory=Lidar)
    speed_m_s: float = 0.9
    scan_hz: float = 4.0
    share: float = 0.7

    def __post_init__(self) -> None:
        _require_within(self, speed_m_s=(0.1, 2.0), scan_hz=(0.5, 40.0), share=(0.0, 1.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionSpec:
    """How two robots explore.

    Parameters
    ----------
    a, b
        The robots, which may differ in everything.
    physics_hz
        Physics steps per simulated second.
    max_seconds
        Simulated time after which a robot stops, wherever it is.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    a: RobotSpec = field(default_factory=RobotSpec)
    b: RobotSpec = field(default_factory=RobotSpec)
    physics_hz: int = 60
    max_seconds: float = 240.0

    def __post_init__(self) -> None:
        _require_within(self, physics_hz=(30, 480), max_seconds=(5.0, 3600.0))


def _require_within(spec: object, **bounds: tuple[float, float]) -> None:
    for name, (low, high) in bounds.items():
        if not low <= getattr(spec, name) <= high:
            raise InputError(f"{name} must be {low} to {high}, got {getattr(spec, name)}")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotLog:
    """What one robot did and could see; S scans of B beams.

    Parameters
    ----------
    times
        Shape (S,), simulated seconds.
    poses
        True poses (x, y, yaw) of the scanner in the world, shape (S, 3).
    odometry
        Poses by counting wheel turns from the true first pose, shape (S, 3).
    ranges
        True ranges, shape (S, B), metres; inf where nothing is in the scanner's reach. Noise comes when a map is built.
    rooms
        The rooms it reached, in order.
    note
        Empty, or why it stopped before its tour was done.
    """

    times: NDArray[np.float64]
    poses: NDArray[np.float64]
    odometry: NDArray[np.float64]
    ranges: NDArray[np.float64]
    rooms: tuple[str, ...]
    note: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MissionLog:
    """One mission: the building, how it was explored, and both robots' logs. Picklable."""

    world: World
    spec: MissionSpec
    seed: int
    a: RobotLog
    b: RobotLog

    def save(self, path: Path) -> None:
        """Write the log as one .npz file, whole or not at all."""
        head = {"world": self.world.as_dict(), "spec": asdict(self.spec), "seed": self.seed}
        arrays: dict[str, NDArray[Any]] = {}
        for name, robot in (("a", self.a), ("b", self.b)):
            head[name] = {"rooms": robot.rooms, "note": robot.note}
            arrays |= {f"{name}_{key}": getattr(robot, key) for key in ("times", "poses", "odometry", "ranges")}
        arrays["head"] = np.array(json.dumps(head))
        packed = io.BytesIO()
        np.savez_compressed(packed, allow_pickle=False, **arrays)
        replace_file(path, packed.getvalue())

    @classmethod
    def load(cls, path: Path) -> MissionLog:
        """Read what `save` wrote.

        Raises
        ------
        InputError
            If the file is no mission log.
        """
        try:
            with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
                head = json.loads(str(data["head"]))
                robots = {n: _read_robot(data, n, head[n]) for n in ("a", "b")}
            spec = cattrs.structure(head["spec"], MissionSpec)
            return cls(world=World.from_dict(head["world"]), spec=spec, seed=int(head["seed"]), **robots)
        except BROKEN as error:
            raise InputError(f"{path} is not a mission log: {error}") from error


def run_mission(world: World, spec: MissionSpec, seed: int) -> MissionLog:
    """Let two robots tour a building, each its own rooms, in one simulation.

    Parameters
    ----------
    world
        The building.
    spec
        How it is explored.
    seed
        Which end A begins at, the start headings, second looks; same world, spec and seed, same bytes.

    Raises
    ------
    SimulationError
        If PyBullet is missing, or a robot fits nowhere or got stuck before it had seen anything worth a map.
    """
    rng = np.random.default_rng(seed)
    drive = drivable(world)
    a_is_left = bool(rng.random() < 0.5)
    with physics(world, hz=spec.physics_hz) as bullet:
        drivers: list[_Driver] = []
        for robot, from_left in ((spec.a, a_is_left), (spec.b, not a_is_left)):
            rooms = share_rooms(world, robot.share, from_left=from_left)
            start, tour = make_tour(world, drive, rooms, Steering(speed_m_s=robot.speed_m_s), rng)
            drivers.append(_Driver(bullet, start, tour, robot, spec.physics_hz, visit=len(drivers)))
        _drive(bullet, drivers, spec)
    a, b = (driver.log() for driver in drivers)
    return MissionLog(world=world, spec=spec, seed=seed, a=a, b=b)


def _drive(bullet: Physics, drivers: list[_Driver], spec: MissionSpec) -> None:
    """Step the simulation until both tours have ended."""
    for k in range(round(spec.max_seconds * spec.physics_hz)):
        time = k / spec.physics_hz
        busy = [driver for driver in drivers if not driver.tour.is_done]
        if not busy:
            return
        for driver in busy:
            if k % CONTROL_EVERY == 0:
                driver.control(time)
            if k % driver.scan_every == 0:
                driver.scan(time)
        bullet.step()
    for driver in drivers:
        if not driver.tour.is_done:
            driver.tour.note = f"out of time after {spec.max_seconds:.0f} s"


class _Driver:
    """One robot in the simulation, its tour, and what it has logged so far."""

    def __init__(
        self, bullet: Physics, start: NDArray[np.float64], tour: Tour, spec: RobotSpec, hz: int, *, visit: int
    ) -> None:
        self.bullet, self.tour, self.lidar = bullet, tour, spec.lidar
        self.robot = bullet.add_robot(start, visit=visit)
        self.angles = spec.lidar.angles
        self.scan_every = max(1, round(hz / spec.scan_hz))
        self.odometry, self.wheels = start.copy(), (0.0, 0.0)
        self.rows: list[tuple[float, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]] = []

    def control(self, time: float) -> None:
        """Count the wheels' turns and set their speeds."""
        wheels = self.bullet.wheel_angles(self.robot)
        left, right = ((new - old) * WHEEL_RADIUS_M for new, old in zip(wheels, self.wheels, strict=True))
        self.wheels = wheels
        heading = self.odometry[2] + (right - left) / TRACK_M / 2
        ahead = (left + right) / 2
        step = [ahead * math.cos(heading), ahead * math.sin(heading), (right - left) / TRACK_M]
        self.odometry = self.odometry + step
        self.bullet.drive(self.robot, *self.tour.command(self.bullet.pose(self.robot), time))

    def scan(self, time: float) -> None:
        """Log one scan."""
        pose = self.bullet.pose(self.robot)
        reading = self.bullet.cast(self.robot, self.angles, self.lidar.max_range_m, self.lidar.height_m)
        self.rows.append((time, pose, self.odometry, reading.ranges))

    def log(self) -> RobotLog:
        """Return what was logged."""
        if len(self.rows) < FEWEST_SCANS:
            raise SimulationError(f"a robot made only {len(self.rows)} scans: {self.tour.note or 'its tour was short'}")
        times, poses, odometry, ranges = (np.array(column) for column in zip(*self.rows, strict=True))
        rooms = tuple(self.tour.visited)
        return RobotLog(times=times, poses=poses, odometry=odometry, ranges=ranges, rooms=rooms, note=self.tour.note)


def _read_robot(data: Any, name: str, head: dict[str, Any]) -> RobotLog:
    arrays = {key: data[f"{name}_{key}"] for key in ("times", "poses", "odometry", "ranges")}
    return RobotLog(**arrays, rooms=tuple(head["rooms"]), note=str(head["note"]))
