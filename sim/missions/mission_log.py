"""Mission logs: exact poses and ranges of both robots; whole, cut to an overlap, and in files."""

from __future__ import annotations

import io
import json
import math
import zipfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import cattrs
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError, SimulationError
from rectmerge.io.atomic_file import replace_file
from sim.missions.spec import MissionSpec
from sim.motion.coverage import FINE_M, SeenFloor, compute_cuts, least_area_m2
from sim.motion.driving import make_drive_field
from sim.world import World

FEWEST_SCANS = 10
STILL_WITHIN_M, STILL_AFTER_S = 0.08, 2.0  # a robot that moves less for longer makes no progress
STUCK_SHARE = 0.2  # of its time without progress; a log with more has a note
BROKEN = (  # errors that a foreign file may raise
    *(OSError, EOFError, zipfile.BadZipFile, ValueError, KeyError, TypeError, AttributeError),
    cattrs.BaseValidationError,
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RobotLog:
    """Log of one robot: S scans of B beams, exact poses and odometry.

    Parameters
    ----------
    times
        Shape (S,), simulated seconds.
    poses
        True poses (x, y, yaw) of the scanner in the world, shape (S, 3).
    odometry
        Poses by counting wheel turns from the true first pose, shape (S, 3).
    ranges
        True ranges, shape (S, B), metres; inf where nothing is in reach. Noise is added when a map is built.
    glass
        Distances to panes before that, shape (S, B), inf where there is none; None where no beam met glass.
    rooms, entered
        Rooms in the order of their first visit, and the times of these, seconds.
    note
        Empty, or the reason why the exploration ended early.
    """

    times: NDArray[np.float64]
    poses: NDArray[np.float64]
    odometry: NDArray[np.float64]
    ranges: NDArray[np.float64]
    glass: NDArray[np.float64] | None = None
    rooms: tuple[str, ...] = ()
    entered: tuple[float, ...] = ()
    note: str = ""

    @property
    def stuck_s(self) -> float:
        """Seconds without progress, waits for the other robot included: less than 0.08 m in more than 2 s."""
        stuck, since = 0.0, 0
        places = self.poses[:, :2].tolist()
        for k, place in enumerate(places):
            if math.dist(place, places[since]) > STILL_WITHIN_M or k == len(places) - 1:
                still = float(self.times[k] - self.times[since])
                stuck += still if still > STILL_AFTER_S else 0.0
                since = k
        return stuck

    def until(self, time: float) -> RobotLog:
        """Return the log up to a time in seconds; the log itself where it ends before."""
        kept = int(np.searchsorted(self.times, time, side="right"))
        if kept == len(self.times):
            return self
        rooms = sum(entered <= time for entered in self.entered)
        cut = replace(
            self,
            times=self.times[:kept],
            poses=self.poses[:kept],
            odometry=self.odometry[:kept],
            ranges=self.ranges[:kept],
            glass=None if self.glass is None else self.glass[:kept],
            rooms=self.rooms[:rooms],
            entered=self.entered[:rooms],
            note=f"cut after {time:.0f} s",
        )
        return cut.with_stuck_noted()

    def with_stuck_noted(self) -> RobotLog:
        """Return the log with a note where the robot made no progress for more than a fifth of its time."""
        if self.stuck_s <= STUCK_SHARE * float(self.times[-1]):
            return self
        note = f"no progress in {self.stuck_s:.0f} of {self.times[-1]:.0f} s"
        return replace(self, note="; ".join(filter(None, (self.note, note))))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MissionLog:
    """Log of a mission: the building, the spec, and the logs of both robots. Picklable.

    Parameters
    ----------
    world, spec, seed
        Input of the mission; the seed is the same for all tries.
    a, b
        Logs of both robots.
    discarded
        Reasons why earlier tries were discarded, in order.
    whole
        The log before it was cut to an overlap; not saved.
    seconds
        Real seconds by stage, for benches; neither saved nor compared.
    """

    world: World
    spec: MissionSpec
    seed: int
    a: RobotLog
    b: RobotLog
    discarded: tuple[str, ...] = ()
    whole: MissionLog | None = None
    seconds: Mapping[str, float] = field(default_factory=dict)

    def save(self, path: Path) -> None:
        """Write the log as one .npz file, whole or not at all."""
        head = {"world": self.world.to_json_dict(), "spec": asdict(self.spec), "seed": self.seed}
        head["discarded"] = self.discarded
        arrays: dict[str, NDArray[Any]] = {}
        for name, robot in (("a", self.a), ("b", self.b)):
            head[name] = {"rooms": robot.rooms, "entered": robot.entered, "note": robot.note}
            for key in ("times", "poses", "odometry", "ranges", "glass"):
                if getattr(robot, key) is not None:
                    arrays[f"{name}_{key}"] = getattr(robot, key)
        arrays["head"] = np.array(json.dumps(head))
        packed = io.BytesIO()
        np.savez_compressed(packed, allow_pickle=False, **arrays)
        replace_file(path, packed.getvalue())

    @classmethod
    def load(cls, path: Path) -> MissionLog:
        """Read a file that `save` wrote.

        Raises
        ------
        InputError
            If the file is no mission log.
        """
        try:
            with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
                head = json.loads(str(data["head"]))
                a, b = (_read_robot(data, name, head[name]) for name in ("a", "b"))
            spec = cattrs.structure(head["spec"], MissionSpec)
            world, seed, discarded = World.from_json_dict(head["world"]), int(head["seed"]), tuple(head["discarded"])
            return cls(world=world, spec=spec, seed=seed, a=a, b=b, discarded=discarded)
        except BROKEN as error:
            raise InputError(f"{path} is not a mission log: {error}") from error


def cut_to_overlap(log: MissionLog, wanted: float) -> MissionLog:
    """Cut both logs where their maps have a wanted overlap and show most floor.

    Parameters
    ----------
    log
        A finished mission, with or without a wanted overlap of its own.
    wanted
        The overlap, 0.1 to 1: area seen by both robots over the smaller of the areas that each has seen.

    Returns
    -------
    MissionLog
        Logs that show at least 40 square metres of floor each, or 0.4 of the drivable floor. A robot that closed
        its loop keeps it where any such cut allows it.

    Raises
    ------
    SimulationError
        If no pair of cuts has that overlap; the message names the possible range.
    """
    shape = tuple(math.ceil(side / FINE_M) for side in log.world.size[::-1])
    floors = [SeenFloor(robot.lidar, shape, cell_m=FINE_M) for robot in (log.spec.a, log.spec.b)]
    for floor, robot in zip(floors, (log.a, log.b), strict=True):
        floor.add(robot.poses, robot.ranges)
    cuts, least = compute_cuts(*floors, fewest=FEWEST_SCANS), least_area_m2(make_drive_field(log.world).is_drivable)
    choice = cuts.choose(wanted, least_m2=least, whole=(log.spec.a.closes_loop, log.spec.b.closes_loop))
    if choice is None:
        reached = cuts.range(least_m2=least)
        problem = "show too little" if reached is None else f"can only be cut to {reached[0]:.2f} to {reached[1]:.2f}"
        areas = f"maps of {cuts.area_a[-1]:.0f} and {cuts.area_b[-1]:.0f} m2"
        raise SimulationError(f"an overlap of {wanted:g} is out of reach: {areas} {problem}")
    ends = log.a.times[choice.scans_a - 1], log.b.times[choice.scans_b - 1]
    a, b = (robot.until(float(end)) for robot, end in zip((log.a, log.b), ends, strict=True))
    return replace(log, a=a, b=b, whole=log.whole or log)


def _read_robot(data: Any, name: str, head: dict[str, Any]) -> RobotLog:
    arrays = {key: data[f"{name}_{key}"] for key in ("times", "poses", "odometry", "ranges")}
    glass = data.get(f"{name}_glass")
    rooms, entered = tuple(map(str, head["rooms"])), tuple(map(float, head["entered"]))
    return RobotLog(**arrays, glass=glass, rooms=rooms, entered=entered, note=str(head["note"]))
