"""Mission logs: what both robots did and could see, exactly; whole, cut, and in files."""

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
from sim.motion.coverage import FINE_M, SeenFloor, all_cuts, least_area_m2
from sim.motion.driving import drivable
from sim.world import World

FEWEST_SCANS = 10
STILL_WITHIN_M, STILL_AFTER_S = 0.08, 2.0  # a robot that stays so near for longer makes no progress
STUCK_SHARE = 0.2  # of its time; a log with more says so
BROKEN = (  # what a foreign file may raise
    *(OSError, EOFError, zipfile.BadZipFile, ValueError, KeyError, TypeError, AttributeError),
    cattrs.BaseValidationError,
)


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
    glass
        Distances to the panes before that, shape (S, B), inf where there is none; None where no beam met glass.
    rooms, entered
        The rooms it was in, in the order in which it first entered them, and when, seconds.
    note
        Empty, or why it stopped before its exploration was done and what went wrong.
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
        """Return the log as if the robot had stopped after a time in seconds; itself where it had stopped by then."""
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
    """One mission: the building, how it was explored, and both robots' logs. Picklable.

    Parameters
    ----------
    world, spec, seed
        What was run; the seed is the mission's, whichever try succeeded.
    a, b
        Both robots' logs.
    discarded
        Why each earlier try was discarded, in order.
    whole
        Of a mission that was cut to an overlap, the log as it was before; not saved.
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
        head = {"world": self.world.as_dict(), "spec": asdict(self.spec), "seed": self.seed}
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
        """Read what `save` wrote.

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
            world, seed, discarded = World.from_dict(head["world"]), int(head["seed"]), tuple(head["discarded"])
            return cls(world=world, spec=spec, seed=seed, a=a, b=b, discarded=discarded)
        except BROKEN as error:
            raise InputError(f"{path} is not a mission log: {error}") from error


def cut_to_overlap(log: MissionLog, wanted: float) -> MissionLog:
    """Cut both logs where their maps have a wanted overlap, and show as much as they can have then.

    Parameters
    ----------
    log
        A finished mission, with or without a wanted overlap of its own.
    wanted
        The overlap, 0.1 to 1: floor that both robots have seen, over the smaller of what each has seen.

    Returns
    -------
    MissionLog
        With logs that show at least 40 square metres of floor each, or 0.4 of what is drivable. A robot that closed
        its loop keeps it where any such cut allows it.

    Raises
    ------
    SimulationError
        If no pair of cuts has that overlap; the message says what there is.
    """
    shape = tuple(math.ceil(side / FINE_M) for side in log.world.size[::-1])
    floors = [SeenFloor(robot.lidar, shape, cell_m=FINE_M) for robot in (log.spec.a, log.spec.b)]
    for floor, robot in zip(floors, (log.a, log.b), strict=True):
        floor.add(robot.poses, robot.ranges)
    cuts, least = all_cuts(*floors, fewest=FEWEST_SCANS), least_area_m2(drivable(log.world).is_drivable)
    choice = cuts.choose(wanted, least_m2=least, whole=(log.spec.a.closes_loop, log.spec.b.closes_loop))
    if choice is None:
        reached = cuts.range(least_m2=least)
        what = "show too little" if reached is None else f"can only be cut to {reached[0]:.2f} to {reached[1]:.2f}"
        areas = f"maps of {cuts.area_a[-1]:.0f} and {cuts.area_b[-1]:.0f} m2"
        raise SimulationError(f"an overlap of {wanted:g} is out of reach: {areas} {what}")
    ends = log.a.times[choice.scans_a - 1], log.b.times[choice.scans_b - 1]
    a, b = (robot.until(float(end)) for robot, end in zip((log.a, log.b), ends, strict=True))
    return replace(log, a=a, b=b, whole=log.whole or log)


def _read_robot(data: Any, name: str, head: dict[str, Any]) -> RobotLog:
    arrays = {key: data[f"{name}_{key}"] for key in ("times", "poses", "odometry", "ranges")}
    glass = data.get(f"{name}_glass")
    rooms, entered = tuple(map(str, head["rooms"])), tuple(map(float, head["entered"]))
    return RobotLog(**arrays, glass=glass, rooms=rooms, entered=entered, note=str(head["note"]))
