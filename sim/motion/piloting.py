"""Pilot of a robot: it follows paths, passes the other robot, and backs off where it is stuck."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim.motion.avoidance import BERTH_M, NEAR_M, find_refuge, is_in_the_way
from sim.motion.driving import PathPlanner, disc_mask
from sim.motion.steering import PathFollower, Steering

ARRIVED_M = 0.25
STUCK_AFTER_S, STUCK_WITHIN_M = 6.0, 0.08
BACK_OFF_S, MOST_BACK_OFFS = 1.0, 4
BACKWARDS = (-0.2, 0.0)  # speed and rate of turn of a robot that backs off
HALT_M = 0.9  # distance at which a robot halts before another on its path
DETOUR_EVERY_S, LONGEST_DETOUR_CELLS = 0.5, 80
PATIENCE_S = 2.0  # wait of the robot with right of way before it plans a detour
PUT_OFF_AFTER_S, GIVE_UP_AFTER_S = 8.0, 30.0  # of waiting for the other robot
ASIDE_S = 12.0  # a robot that has stepped aside comes back after so long at the latest
TOUCH_M = 0.5  # nearer than this it drives no further towards the other robot
WAITS_WITHIN_M = 0.3
LOOK_S, FACES_WITHIN_RAD = 3.0, 0.5  # longest turn to the point to look at, and the tolerance of its direction
NOWHERE = np.empty((0, 2))
Mark = tuple[float, float, float]  # time, x, y


class Guide(Protocol):
    """Source of goals: a `Tour` or `Frontiers`."""

    note: str
    is_done: bool

    @property
    def goal(self) -> str:
        """Name of the next goal, for notes."""

    @property
    def faces(self) -> NDArray[np.float64] | None:
        """Point to look at from the goal, (2,), or None."""

    def path(
        self, position: NDArray[np.float64], blocked: NDArray[np.bool_] | None = None
    ) -> NDArray[np.float64] | None:
        """Plan the path to the goal, off blocked cells (H, W); None where there is none."""

    def is_path_outdated(self) -> bool:
        """Return whether the path should be planned anew after a scan."""

    def arrive(self) -> None:
        """Record that the robot has reached the goal."""

    def put_off(self) -> None:
        """Record that the robot cannot reach the goal now."""

    def finish(self) -> None:
        """End the exploration."""


@dataclass(slots=True, eq=False)
class Pilot:
    """Pilot of one robot; call `command` once per control step.

    A robot without progress backs off and plans anew; after some tries it gives up with a note. Where two robots block
    each other, the robot that gives way makes a detour or steps aside, and the other waits.

    Parameters
    ----------
    guide
        Source of its goals.
    planner
        Path planner.
    steering
        Path-tracking controller.
    gives_way
        Whether it gives way to the other robot.
    turns_to_look
        Whether it turns to the point to look at, for a scanner that does not look all round.
    other
        Pilot of the other robot, if there is one; of several the nearest.
    """

    guide: Guide
    planner: PathPlanner
    steering: Steering
    gives_way: bool = False
    turns_to_look: bool = False
    other: Pilot | None = None
    position: NDArray[np.float64] = field(default_factory=lambda: np.full(2, np.inf))
    note: str = ""
    is_done: bool = False
    _way: PathFollower | None = None
    _refuge: PathFollower | None = None
    _tries: int = 0  # to get on, since the last arrival
    _back_until: float = -1.0
    _look_until: float = math.inf
    _aside_until: float = -1.0
    _next_detour: float = -1.0
    _next_put_off: float = -1.0
    _waits: Mark = (-1.0, math.inf, math.inf)  # time and position of the start of the wait for the other robot
    _mark: Mark = (0.0, math.inf, math.inf)  # of the last progress

    @property
    def ahead(self) -> NDArray[np.float64]:
        """Waypoints ahead, (N, 2)."""
        way = self._refuge or self._way
        return NOWHERE if way is None or self.is_done else way.rest

    def replan(self) -> None:
        """Drop the path, so that it is planned anew."""
        self._way, self._look_until = None, math.inf

    def end(self, note: str = "") -> None:
        """End the drive; the robot still moves off the path of the other."""
        self.is_done, self.note = True, "; ".join(filter(None, (self.guide.note, note)))

    def command(self, pose: NDArray[np.float64], time: float) -> tuple[float, float]:
        """Return forward speed (m/s) and rate of turn (rad/s) for a pose (x, y, yaw) at a time in seconds."""
        self.position = pose[:2]
        speed, turn = self._intend(pose, time)
        if self.other is not None and self._is_near(TOUCH_M):
            away = self.other.position - self.position
            bearing = math.atan2(away[1], away[0]) - pose[2]
            if speed * math.cos(bearing) > 0.5 * abs(speed):
                speed = 0.0
        return speed, turn

    def _intend(self, pose: NDArray[np.float64], time: float) -> tuple[float, float]:
        if time < self._back_until:
            return BACKWARDS
        if self._refuge is not None:
            return self._step_aside(self._refuge, pose, time)
        if self.is_done:
            return self._make_room(time)
        if self._way is None and not self._plan():
            return (0.0, 0.0) if self.is_done else self._back_off(time)
        assert self._way is not None
        if np.hypot(*(self._way.end - self.position)) < ARRIVED_M:
            return self._arrive(pose, time)
        if self._is_stuck(time):
            return self._back_off(time)
        if self.other is not None and self._is_near(NEAR_M) and is_in_the_way(self._way.rest, self.other.position):
            return self._meet(self.other, self._way, pose, time)
        return self.steering.command(pose, self._way.target(self.position))

    def _is_near(self, reach: float) -> bool:
        return self.other is not None and math.dist(self.position, self.other.position) < reach

    def _plan(self) -> bool:
        path = self.guide.path(self.position)
        if path is not None:
            self._way = PathFollower(path)
        elif self.guide.is_done:
            self.end()
        return path is not None

    def _arrive(self, pose: NDArray[np.float64], time: float) -> tuple[float, float]:
        faces = self.guide.faces if self.turns_to_look else None
        self._look_until = min(self._look_until, time + LOOK_S)
        if faces is not None and time < self._look_until:
            away = faces - self.position
            error = math.remainder(math.atan2(away[1], away[0]) - pose[2], math.tau)
            if abs(error) > FACES_WITHIN_RAD:
                return 0.0, math.copysign(self.steering.turn_rad_s, error)
        self.guide.arrive()
        self.replan()
        self._tries, self._mark = 0, (time, *self.position.tolist())
        if self.guide.is_done:
            self.end()
        return 0.0, 0.0

    def _is_stuck(self, time: float) -> bool:
        if math.dist(self.position, self._mark[1:]) > STUCK_WITHIN_M:
            self._mark = (time, *self.position.tolist())
        return time - self._mark[0] > STUCK_AFTER_S

    def _back_off(self, time: float) -> tuple[float, float]:
        self._tries += 1
        self.replan()
        self._back_until, self._mark = time + BACK_OFF_S, (time + BACK_OFF_S, math.inf, math.inf)
        if self._tries > MOST_BACK_OFFS:
            self.end(f"stuck on the way to {self.guide.goal} after {time:.0f} s")
        return BACKWARDS

    def _meet(self, other: Pilot, way: PathFollower, pose: NDArray[np.float64], time: float) -> tuple[float, float]:
        """Make a detour around the other robot, step aside for it, or wait for it."""
        gives_way = self.gives_way and not other.is_done
        if not gives_way and not self._is_near(HALT_M):
            speed, turn = self.steering.command(pose, way.target(self.position))
            return speed / 2, turn
        command = self._wait(time)
        if self.is_done or time < self._next_detour or not (gives_way or time - self._waits[0] > PATIENCE_S):
            return command
        self._next_detour = time + DETOUR_EVERY_S
        path = self.guide.path(self.position, disc_mask(self.planner.prices.shape, other.position, BERTH_M))
        if path is not None and len(path) < len(way.rest) + LONGEST_DETOUR_CELLS:
            self._way = PathFollower(path)
        elif gives_way:
            self._leave(other, time)
        return command

    def _wait(self, time: float) -> tuple[float, float]:
        """Stand still; after a while try another goal, and in the end give up."""
        self._mark = (time, *self.position.tolist())
        if math.dist(self.position, self._waits[1:]) > WAITS_WITHIN_M:
            self._waits, self._next_put_off = self._mark, time + PUT_OFF_AFTER_S
        if time - self._waits[0] > GIVE_UP_AFTER_S:
            self.end(f"the other robot stood in its way to {self.guide.goal} after {time:.0f} s")
        elif time > self._next_put_off:
            self._next_put_off = time + PUT_OFF_AFTER_S
            self.guide.put_off()
            self.replan()
        return 0.0, 0.0

    def _leave(self, other: Pilot, time: float) -> None:
        """Set out for a refuge off the path of the other robot, if there is one."""
        path = find_refuge(self.planner.prices, self.position, other.position, other.ahead)
        if path is not None:
            self._refuge, self._aside_until = PathFollower(path), time + ASIDE_S

    def _step_aside(self, refuge: PathFollower, pose: NDArray[np.float64], time: float) -> tuple[float, float]:
        is_there = bool(np.hypot(*(refuge.end - self.position)) < ARRIVED_M)
        is_clear = self._way is None or self.other is None or not is_in_the_way(self._way.rest, self.other.position)
        if time > self._aside_until or (is_there and (is_clear or self.is_done)):
            self._refuge = None
            self.replan()
        self._mark = (time, *self.position.tolist())
        return (0.0, 0.0) if is_there else self.steering.command(pose, refuge.target(self.position))

    def _make_room(self, time: float) -> tuple[float, float]:
        """Stand still, unless the other robot wants to pass."""
        other = self.other
        if other is not None and time >= self._next_detour and self._is_near(NEAR_M):
            self._next_detour = time + DETOUR_EVERY_S
            if is_in_the_way(other.ahead, self.position):
                self._leave(other, time)
        return 0.0, 0.0


def mind_nearest(pilots: Sequence[Pilot]) -> None:
    """Let each of some pilots mind the nearest other one; of two, the later gives way."""
    for k, pilot in enumerate(pilots):
        nearest = min(
            (j for j in range(len(pilots)) if j != k),
            key=lambda j: math.dist(pilot.position, pilots[j].position),
        )
        pilot.other, pilot.gives_way = pilots[nearest], k > nearest
