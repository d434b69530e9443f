"""How a robot tours rooms: which rooms, in which order, along which path, and what it does when it is stuck.

The tours are planned on the true plan and driven by true poses: they stand for an operator who knows the building.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import SimulationError
from sim.driving import DriveField, Steering, cell_centres, look_ahead, shortest_path
from sim.world import Room, World, covers

ARRIVED_M = 0.25
STUCK_AFTER_S, STUCK_WITHIN_M = 6.0, 0.08
BACK_OFF_S, MOST_BACK_OFFS = 1.0, 4
SECOND_LOOK_M2 = 22.0  # rooms larger than this are looked at from a second spot


def share_rooms(world: World, share: float, *, from_left: bool) -> tuple[Room, ...]:
    """Choose the rooms of one robot: the leftmost or rightmost share of the building, at least two.

    Parameters
    ----------
    world
        The building.
    share
        Of the number of rooms, 0..1.
    from_left
        Which end to begin at; the shares of two robots overlap where they add up to more than 1.
    """
    rooms = sorted(world.rooms, key=lambda room: float(room.outline.mean(axis=0)[0]), reverse=not from_left)
    return tuple(rooms[: max(2, min(len(rooms), round(share * len(rooms))))])


def plan_stops(
    drive: DriveField, rooms: Sequence[Room], rng: np.random.Generator
) -> tuple[NDArray[np.float64], tuple[tuple[str, NDArray[np.float64]], ...]]:
    """Choose where to start and, always the nearest next, where to look around.

    Returns
    -------
    start, stops
        The start (2,), in the first room, and the (room name, point (2,)) to visit in order.
    """
    left = [(room.name, spot) for room in rooms for spot in _spots(drive, room, rng)]
    at = left[0][1]
    start, stops = at, []
    while left:
        costs = [shortest_path(drive, at, spot)[1] for _, spot in left]
        stops.append(left.pop(int(np.argmin(costs))))
        at = stops[-1][1]
    return start, tuple(stops)


def _spots(drive: DriveField, room: Room, rng: np.random.Generator) -> list[NDArray[np.float64]]:
    """The room's spot, and in a large room one more, drawn from its drivable cells, well away from the first."""
    if room.area_m2 < SECOND_LOOK_M2:
        return [room.spot]
    rows, cols = np.nonzero(drive.is_drivable & (drive.clearance > 0.5))
    points = cell_centres(rows, cols)
    reach = 0.3 * math.sqrt(room.area_m2)
    away = np.hypot(*(points - room.spot).T) > reach
    choice = points[away & covers(room.outline, points)]
    return [room.spot] if not len(choice) else [room.spot, choice[int(rng.integers(len(choice)))]]


@dataclass(slots=True, eq=False)
class Tour:
    """Drives one robot through its stops; call `command` once per control step.

    A robot that does not get on backs off and plans anew; after some such tries it gives up and says so in `note`.
    """

    drive: DriveField
    stops: tuple[tuple[str, NDArray[np.float64]], ...]
    steering: Steering
    visited: list[str] = field(default_factory=list)
    note: str = ""
    is_done: bool = False
    _path: NDArray[np.float64] | None = None
    _at: int = 0
    _back_offs: int = 0
    _back_until: float = -1.0
    _mark: tuple[float, float, float] = (0.0, math.inf, math.inf)  # time, x, y of the last progress

    def command(self, pose: NDArray[np.float64], time: float) -> tuple[float, float]:
        """Return forward speed (m/s) and rate of turn (rad/s) for a pose (x, y, yaw) at a time in seconds."""
        if self.is_done:
            return 0.0, 0.0
        if time < self._back_until:
            return -0.2, 0.0
        if np.hypot(*(self.stops[len(self.visited)][1] - pose[:2])) < ARRIVED_M:
            self._arrive()
            return 0.0, 0.0
        if self._is_stuck(pose, time):
            return self._back_off(time)
        if self._path is None:
            self._path, self._at = shortest_path(self.drive, pose[:2], self.stops[len(self.visited)][1])[0], 0
        target, self._at = look_ahead(self._path, pose[:2], self._at)
        return self.steering.command(pose, target)

    def _arrive(self) -> None:
        self.visited.append(self.stops[len(self.visited)][0])
        self._path = None
        self.is_done = len(self.visited) == len(self.stops)

    def _is_stuck(self, pose: NDArray[np.float64], time: float) -> bool:
        if math.hypot(pose[0] - self._mark[1], pose[1] - self._mark[2]) > STUCK_WITHIN_M:
            self._mark = (time, float(pose[0]), float(pose[1]))
        return time - self._mark[0] > STUCK_AFTER_S

    def _back_off(self, time: float) -> tuple[float, float]:
        self._back_offs += 1
        self._path, self._back_until, self._mark = None, time + BACK_OFF_S, (time + BACK_OFF_S, math.inf, math.inf)
        if self._back_offs > MOST_BACK_OFFS:
            self.is_done = True
            self.note = f"stuck on the way to {self.stops[len(self.visited)][0]} after {time:.0f} s"
        return -0.2, 0.0


def make_tour(
    world: World, drive: DriveField, rooms: Sequence[Room], steering: Steering, rng: np.random.Generator
) -> tuple[NDArray[np.float64], Tour]:
    """Plan one robot's tour; returns its start pose (x, y, yaw) and the tour.

    Raises
    ------
    SimulationError
        If there are no rooms to visit.
    """
    if not rooms:
        raise SimulationError(f"this {world.family or 'world'} has no rooms to visit")
    start, stops = plan_stops(drive, rooms, rng)
    return np.array([start[0], start[1], rng.uniform(-math.pi, math.pi)]), Tour(drive, stops, steering)
