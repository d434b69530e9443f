"""Missions: two robots or more explore one building in one simulation, and their exact readings are logged."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError, SimulationError
from sim.bullet import Physics, physics
from sim.missions.mission_log import FEWEST_SCANS, MissionLog, RobotLog, cut_to_overlap
from sim.missions.robot import Robot
from sim.missions.spec import USUAL_SHARE, MissionSpec, RobotSpec
from sim.motion.coverage import SeenFloor, compute_cuts, least_area_m2
from sim.motion.driving import DriveField, PathPlanner, cell_centre, make_drive_field, nearest_drivable
from sim.motion.frontiers import Frontiers
from sim.motion.piloting import Guide, Pilot, mind_nearest
from sim.motion.steering import Steering
from sim.motion.tours import choose_starts, find_stops, keep_apart, make_tour, middle_rooms, nearest_stop, share_rooms
from sim.sensors.ray_casting import Caster
from sim.world import World

CONTROL_EVERY = 3  # physics steps per control step
CHECK_EVERY_S = 1.0  # between checks of the end of exploration
NO_GAIN_S, GAIN = 15.0, 1.02  # a mission ends after so long without better cuts to the wanted overlap
FAR_ENOUGH = 0.7  # starts are this times the wanted overlap nearer than as far apart as can be
KEEPS_OFF_BELOW = 0.5  # for a smaller overlap, rooms nearer to the start of the other robot come last
LOOKS_ALL_ROUND_DEG = 330.0
MOST_ROBOTS = 8
UNHURRIED = 0.5  # mean speed on a path over the top speed, turns and doors included


def run_mission(world: World, spec: MissionSpec, seed: int) -> MissionLog:
    """Let two robots explore a building in one simulation.

    Parameters
    ----------
    world
        The building.
    spec
        Settings of the exploration.
    seed
        Seed of starts, headings and second looks; same world, spec and seed, same bytes.

    Returns
    -------
    MissionLog
        Cut to the wanted overlap, if there is one. Failed tries are in `discarded`.

    Raises
    ------
    SimulationError
        If PyBullet is missing, a robot fits nowhere, there is nothing to tour, or no try gave maps worth making with
        the wanted overlap; the message names the reason of every failed try.
    """
    discarded: list[str] = []
    drives, apart = _drives(world), None if spec.overlap is None else 1.0 - FAR_ENOUGH * spec.overlap
    for stream in np.random.SeedSequence(seed).spawn(spec.tries):
        mission = _Mission(world, spec, (spec.a, spec.b), drives, apart, np.random.default_rng(stream))
        try:
            a, b = mission.run()
            log = MissionLog(world=world, spec=spec, seed=seed, a=a, b=b, discarded=tuple(discarded))
            log = replace(log, seconds=mission.seconds())
            return log if spec.overlap is None else cut_to_overlap(log, spec.overlap)
        except SimulationError as error:
            discarded.append(str(error))
            apart = mission.better_apart()
    raise _no_mission(spec, discarded)


def run_fleet(world: World, spec: MissionSpec, robots: int, seed: int) -> tuple[RobotLog, ...]:
    """Let two to eight robots explore a building in one simulation, where they see and avoid each other.

    Parameters
    ----------
    world
        The building.
    spec
        Settings of the exploration, without a wanted overlap: robots 0, 2, 4 ... are like `a`, the others like `b`.
    robots
        How many.
    seed
        Seed of starts, headings and second looks; same input, same bytes.

    Returns
    -------
    tuple
        The robots' logs.

    Raises
    ------
    InputError
        If there are fewer than two robots or more than eight, or the spec wants an overlap.
    SimulationError
        As from `run_mission`.
    """
    if not 2 <= robots <= MOST_ROBOTS or spec.overlap is not None:
        raise InputError(f"a fleet has 2 to {MOST_ROBOTS} robots and no overlap, got {robots} and {spec.overlap}")
    discarded: list[str] = []
    drives, specs = _drives(world), [(spec.a, spec.b)[k % 2] for k in range(robots)]
    for stream in np.random.SeedSequence(seed).spawn(spec.tries):
        try:
            return tuple(_Mission(world, spec, specs, drives, None, np.random.default_rng(stream)).run())
        except SimulationError as error:
            discarded.append(str(error))
    raise _no_mission(spec, discarded)


def _no_mission(spec: MissionSpec, discarded: Sequence[str]) -> SimulationError:
    return SimulationError(f"no mission in {spec.tries} tries: {'; '.join(dict.fromkeys(discarded))}")


def _drives(world: World) -> list[DriveField]:
    """Return the drive fields of A and of B."""
    first = make_drive_field(world.at_visit(0))
    return [first, make_drive_field(world.at_visit(1)) if any(world.visits) else first]


class _Mission:
    """Try of a mission: starts and guides of the robots, and the simulation that they drive in."""

    def __init__(
        self,
        world: World,
        spec: MissionSpec,
        robots: Sequence[RobotSpec],
        drives: list[DriveField],
        apart: float | None,
        rng: np.random.Generator,
    ) -> None:
        self.clock = _Clock()
        self.world, self.spec, self.specs = world, spec, robots
        count = len(robots)
        self.a_is_left = bool(rng.random() < 0.5)
        self.yaws = rng.uniform(-math.pi, math.pi, count)
        planners = [PathPlanner(drives[0])] * 2 if drives[0] is drives[1] else [PathPlanner(drive) for drive in drives]
        self.drives = [drives[k % 2] for k in range(count)]  # every second robot comes at the second visit
        self.planners = [planners[k % 2] for k in range(count)]
        self.apart = rng.uniform(0.3, 1.0) if apart is None else apart
        self.spots = choose_starts(drives[0], planners[0], self.apart, rng, count)
        self.seen = [SeenFloor(robot.lidar, drives[0].is_drivable.shape) for robot in self.specs]
        self.starts: list[NDArray[np.float64]] = []
        self.guides = [self._tour(k, rng) if self.specs[k].path == "tour" else self._frontiers(k) for k in range(count)]
        self.best, self.best_at, self.was_below = 0.0, 0.0, False
        self.clock.lap("planning")

    def _tour(self, k: int, rng: np.random.Generator) -> Guide:
        robot, rooms = self.specs[k], self.world.rooms
        if self.spec.overlap is None:
            share = USUAL_SHARE if robot.share is None else robot.share
            rooms = share_rooms(self.world, share, from_left=self.a_is_left == (k == 0))
            if k > 1:  # between the ends, at which the first two begin
                rooms = middle_rooms(self.world, share, (k - 1) / (len(self.specs) - 1))
        stops = find_stops(self.drives[k], rooms, rng)
        first = 0 if self.spec.overlap is None else nearest_stop(self.planners[k], stops, self.spots[k])
        start = self._start(k, stops[first][1])
        keeps_off = self.spec.overlap is not None and self.spec.overlap < KEEPS_OFF_BELOW
        rival = self.spots[1 - k] if keeps_off else None
        return make_tour(self.planners[k], stops, start, closes_loop=robot.closes_loop, rival=rival)

    def _frontiers(self, k: int) -> Guide:
        start = self._start(k, self.spots[k])
        return Frontiers(self.planners[k], self.seen[k], start if self.specs[k].closes_loop else None)

    def _start(self, k: int, near: NDArray[np.float64]) -> NDArray[np.float64]:
        """Choose the start of a robot: a drivable cell near a point, apart from the other robots."""
        start = keep_apart(self.drives[k], cell_centre(*nearest_drivable(self.drives[k], near)), *self.starts)
        self.starts.append(start)
        return start

    def run(self) -> list[RobotLog]:
        """Simulate until all robots are done."""
        with physics(self.world, hz=self.spec.physics_hz) as bullet:
            robots = [self._robot(bullet, k) for k in range(len(self.specs))]
            for robot in robots:
                robot.pilot.position = robot.start[:2]
            self._drive(bullet, robots)
        for robot in robots:
            self._end(robot)
        return [robot.log(self.world) for robot in robots]

    def seconds(self) -> Mapping[str, float]:
        """Return the real seconds of every stage."""
        return self.clock.seconds()

    def _robot(self, bullet: Physics, k: int) -> Robot:
        robot = self.specs[k]
        steering = Steering(speed_m_s=robot.speed_m_s)
        turns = robot.lidar.fov_deg < LOOKS_ALL_ROUND_DEG
        pilot = Pilot(self.guides[k], self.planners[k], steering, turns_to_look=turns)
        is_asked = robot.path == "frontier" or not self.spec.coverage is self.spec.overlap is None
        compiled = self.spec.rays == "compiled"
        return Robot(
            bullet,
            robot,
            pilot,
            np.append(self.starts[k], self.yaws[k]),
            visit=k % 2,
            seen=self.seen[k] if is_asked else None,
            caster=Caster(self.world.at_visit(k % 2), robot.lidar.height_m) if compiled else None,
        )

    def _drive(self, bullet: Physics, robots: list[Robot]) -> None:
        hz, clock = self.spec.physics_hz, self.clock
        scan_every = [math.ceil(hz / robot.scan_hz - 1e-9) for robot in self.specs]
        for k in range(round(self.spec.max_seconds * hz)):
            now = k / hz
            if all(robot.pilot.is_done for robot in robots):
                return
            for robot, every in zip(robots, scan_every, strict=True):
                if k % every == 0 and not robot.pilot.is_done:
                    robot.scan(now, np.array([other.pose for other in robots if other is not robot]))
                    clock.lap("rays")
                    robot.look()
            if k % CONTROL_EVERY == 0:
                mind_nearest([robot.pilot for robot in robots])
                for robot in robots:
                    robot.control(now)
            if k % round(CHECK_EVERY_S * hz) == 0:
                self._check(robots, now)
            clock.lap("planning")
            bullet.step()
            clock.lap("physics")

    def _check(self, robots: list[Robot], now: float) -> None:
        """End the exploration of robots that have seen enough or must return now."""
        is_met = self.spec.overlap is not None and self._is_met(self.spec.overlap, now)
        parts = zip(robots, self.specs, self.planners, self.drives, self.seen, strict=True)
        for robot, spec, planner, drive, seen in parts:
            guide = robot.pilot.guide
            way_m = planner.cost_m(robot.pose[:2], robot.start[:2]) if spec.closes_loop else 0.0
            is_late = spec.closes_loop and now + way_m / (UNHURRIED * spec.speed_m_s) > self.spec.max_seconds
            is_full = self.spec.coverage is not None and seen.share_of(drive.is_drivable) >= self.spec.coverage
            if (is_met or is_late or is_full) and not robot.pilot.is_done:
                guide.finish()
                robot.pilot.replan()

    def _is_met(self, overlap: float, now: float) -> bool:
        """Return whether the wanted overlap has been passed and cuts to it have not gained for a while.

        Robots that close their loops return as soon as it is reached, so that they have it at their start.
        """
        if min(seen.scans for seen in self.seen) < FEWEST_SCANS:
            return False
        cuts = compute_cuts(*self.seen, fewest=FEWEST_SCANS)
        is_passed = bool(cuts.overlaps[-1, -1] > overlap)
        self.was_below |= not is_passed
        least = least_area_m2(self.drives[0].is_drivable)
        is_enough = min(cuts.area_a[-1], cuts.area_b[-1]) >= least
        if self.was_below and is_passed and is_enough and (self.spec.a.closes_loop or self.spec.b.closes_loop):
            return True
        choice = cuts.choose(overlap, least_m2=least)
        if choice is not None and choice.worth > GAIN * self.best:
            self.best, self.best_at = choice.worth, now
        return self.best > 0 and is_passed and now - self.best_at >= NO_GAIN_S

    def better_apart(self) -> float | None:
        """Return the separation of the next starts: larger where the maps had too much in common, else smaller."""
        if self.spec.overlap is None:
            return None
        least = least_area_m2(self.drives[0].is_drivable)
        reached = compute_cuts(*self.seen, fewest=1).range(least_m2=least) or (0.0, 0.0)
        return (self.apart + 1) / 2 if reached[0] > self.spec.overlap else self.apart / 2

    def _end(self, robot: Robot) -> None:
        """Note why the exploration of a robot is incomplete."""
        pilot = robot.pilot
        if not pilot.is_done:
            pilot.end(f"out of time after {self.spec.max_seconds:.0f} s")
        elif not pilot.note and self.spec.coverage is not None and robot.seen is not None:
            share = robot.seen.share_of(self.drives[0].is_drivable)
            if share < self.spec.coverage:
                pilot.end(f"found {share:.0%} of the floor, not {self.spec.coverage:.0%}")


class _Clock:
    """Clock of real seconds by stage, for benches."""

    def __init__(self) -> None:
        self._began = self._last = time.perf_counter()
        self._spent: dict[str, float] = {}

    def lap(self, stage: str) -> None:
        """Add the time since the last lap to a stage."""
        now = time.perf_counter()
        self._spent[stage] = self._spent.get(stage, 0.0) + now - self._last
        self._last = now

    def seconds(self) -> dict[str, float]:
        """Return the seconds of every stage, and the rest."""
        whole = time.perf_counter() - self._began
        return {**self._spent, "rest": whole - sum(self._spent.values())}
