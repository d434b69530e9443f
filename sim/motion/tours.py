"""Tours of rooms: the rooms, their order, and the starts of two robots.

Tours are planned on the true plan and driven by true poses, as by an operator who knows the building.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import SimulationError
from sim.motion.driving import (
    DriveField,
    PathPlanner,
    cell_at,
    cell_centre,
    cell_centres,
    disc_mask,
    find_standing_spot,
    nearest_cell,
)
from sim.world import Room, World, covers

SECOND_LOOK_M2 = 22.0  # rooms larger than this are looked at from a second spot
APART_M = 1.0  # between two robots at the start, at least
Point = NDArray[np.float64]
Stop = tuple[str, Point]  # a room's name and a point (2,) in it


def share_rooms(world: World, share: float, *, from_left: bool) -> tuple[Room, ...]:
    """Choose the rooms of one robot: the leftmost or rightmost share of the building, at least two.

    Parameters
    ----------
    world
        The building.
    share
        Of the number of rooms, 0..1.
    from_left
        End of the building to begin at; the shares of two robots overlap where they add up to more than 1.
    """
    rooms = sorted(world.rooms, key=lambda room: float(room.outline.mean(axis=0)[0]), reverse=not from_left)
    return tuple(rooms[: max(2, min(len(rooms), round(share * len(rooms))))])


def middle_rooms(world: World, share: float, at: float) -> tuple[Room, ...]:
    """Choose the rooms of a robot that begins between the ends of the building: a share of them, at least two.

    Parameters
    ----------
    world
        The building.
    share
        Of the number of rooms, 0..1.
    at
        Place of the share among the rooms from left to right: 0 for the leftmost ones, 1 for the rightmost ones.
    """
    rooms = sorted(world.rooms, key=lambda room: float(room.outline.mean(axis=0)[0]))
    count = max(2, min(len(rooms), round(share * len(rooms))))
    first = round(at * max(0, len(rooms) - count))
    return tuple(rooms[first : first + count])


def find_stops(drive: DriveField, rooms: Sequence[Room], rng: np.random.Generator) -> list[Stop]:
    """Choose a stop in each room that can be entered, and two in a large one, the second at random.

    Raises
    ------
    SimulationError
        If there are no rooms, or none can be entered.
    """
    if not rooms:
        raise SimulationError("this world has no rooms to tour; path = 'frontier' explores it without")
    stops = [(room.name, spot) for room in rooms for spot in _spots(drive, room, rng)]
    if not stops:
        raise SimulationError(f"a robot can enter none of the {len(rooms)} rooms to tour")
    return stops


def _spots(drive: DriveField, room: Room, rng: np.random.Generator) -> list[NDArray[np.float64]]:
    first: NDArray[np.float64] | None = room.spot
    if nearest_cell(drive.is_drivable, room.spot) != cell_at(room.spot):  # what only this visit finds may stand there
        first = find_standing_spot(drive, room)
    if first is None:
        return []
    if room.area_m2 < SECOND_LOOK_M2:
        return [first]
    rows, cols = np.nonzero(drive.is_drivable & (drive.clearance > 0.5))
    points = cell_centres(rows, cols)
    away = np.hypot(*(points - first).T) > 0.3 * math.sqrt(room.area_m2)
    choice = points[away & covers(room.outline, points)]
    return [first] if not len(choice) else [first, choice[int(rng.integers(len(choice)))]]


def choose_starts(
    drive: DriveField, planner: PathPlanner, apart: float, rng: np.random.Generator, count: int = 2
) -> tuple[NDArray[np.float64], ...]:
    """Choose the starts of robots: one at an end of the building, the last at a share of the way to the other end.

    Any others start between these.

    Parameters
    ----------
    drive, planner
        Drive field and path planner.
    apart
        Separation: 0 for side by side, 1 for as far as possible.
    rng
        Source of the choice.
    count
        Number of robots.
    """
    rows, cols = np.nonzero(drive.is_drivable & (drive.clearance >= min(0.5, drive.clearance[drive.is_drivable].max())))
    spots = cell_centres(rows, cols)
    anywhere = spots[int(rng.integers(len(spots)))]
    first: Point = spots[int(np.argmax(planner.costs(anywhere)[rows, cols]))]
    order = np.argsort(planner.costs(first)[rows, cols], kind="stable")
    last = min(1.0, max(0.0, apart + rng.uniform(-0.05, 0.05)))
    shares = [last * (k + 1) / (count - 1) for k in range(count - 1)]
    return first, *(spots[order[round(share * (len(order) - 1))]] for share in shares)


def keep_apart(drive: DriveField, start: NDArray[np.float64], *others: NDArray[np.float64]) -> NDArray[np.float64]:
    """Move a start away from other robots where it is too near.

    Raises
    ------
    SimulationError
        If there is no place for another robot.
    """
    if all(np.hypot(*(start - other)) >= APART_M for other in others):
        return start
    away = drive.is_drivable.copy()
    for other in others:
        away &= ~disc_mask(away.shape, other, APART_M)
    if not away.any():
        raise SimulationError("there is no place for another robot in this world")
    row, col = nearest_cell(away, start)
    return cell_centre(row, col)


def order_by_nearest(planner: PathPlanner, stops: Sequence[Stop], first: int) -> list[Stop]:
    """Sort stops so that, from the first on, the nearest comes next."""
    left = list(stops)
    order = [left.pop(first)]
    while left:
        order.append(left.pop(nearest_stop(planner, left, order[-1][1])))
    return order


def nearest_stop(planner: PathPlanner, stops: Sequence[Stop], point: Point) -> int:
    """Return the index of the stop with the shortest path from a point."""
    return int(np.argmin([planner.cost_m(spot, point) for _, spot in stops]))


def shorten_round(planner: PathPlanner, stops: Sequence[Stop]) -> list[Stop]:
    """Shorten a round trip through all stops by reversing parts of it (2-opt).

    In a building whose corridor is a ring the shortest round trip goes round it.
    """
    apart = np.array([[planner.cost_m(p, q) for _, p in stops] for _, q in stops])
    order, is_better = list(range(len(stops))), True
    while is_better:
        is_better = False
        for i in range(len(order) - 1):
            for j in range(i + 2, len(order) - (i == 0)):
                p, q, r, s = order[i], order[i + 1], order[j], order[(j + 1) % len(order)]
                if apart[p, r] + apart[q, s] < apart[p, q] + apart[r, s] - 1e-6:
                    order[i + 1 : j + 1] = order[j:i:-1]
                    is_better = True
    return [stops[k] for k in order]


@dataclass(slots=True, eq=False)
class Tour:
    """Guide of one robot through its stops, in order.

    Parameters
    ----------
    planner
        Path planner.
    stops
        Stops, in order.
    home
        Start to return to at the end; None for no return.
    """

    planner: PathPlanner
    stops: list[Stop]
    home: NDArray[np.float64] | None = None
    visited: list[str] = field(default_factory=list)
    note: str = ""
    is_done: bool = False
    _put_off: set[str] = field(default_factory=set)

    @property
    def goal(self) -> str:
        """Name of the next goal, for notes."""
        return self.stops[0][0] if self.stops else "its start"

    @property
    def faces(self) -> NDArray[np.float64] | None:
        """Point to look at from a stop: None, any direction will do."""
        return None

    def is_path_outdated(self) -> bool:
        """Return False: scans do not change a tour."""
        return False

    def path(
        self, position: NDArray[np.float64], blocked: NDArray[np.bool_] | None = None
    ) -> NDArray[np.float64] | None:
        """Plan the path to the next stop or home, off blocked cells (H, W); None where there is none."""
        target = self.stops[0][1] if self.stops else self.home
        return None if target is None else self.planner.path(position, target, blocked)

    def arrive(self) -> None:
        """Record the stop and go on to the next."""
        if self.stops:
            self.visited.append(self.stops.pop(0)[0])
        else:
            self.is_done = True
        self.is_done |= not self.stops and self.home is None

    def put_off(self) -> None:
        """Try the current stop again after all others, which may be none; the second time leave it out."""
        if not self.stops:
            return
        stop = self.stops.pop(0)
        key = str(stop)
        if key not in self._put_off:
            self._put_off.add(key)
            self.stops.append(stop)
        else:
            self.note = "; ".join(filter(None, (self.note, f"could not get to {stop[0]}")))
        self.is_done = not self.stops and self.home is None

    def finish(self) -> None:
        """Drop the other stops: go home, or end here."""
        self.stops = []
        self.is_done = self.home is None


def make_tour(
    planner: PathPlanner, stops: Sequence[Stop], start: Point, *, closes_loop: bool = False, rival: Point | None = None
) -> Tour:
    """Plan a tour of stops.

    Parameters
    ----------
    planner
        Path planner.
    stops
        Stops, in order.
    start
        Start of the robot: the nearest stop comes first, then always the nearest of the others.
    closes_loop
        Whether it tours the stops in a round and returns to its start.
    rival
        Start of the other robot: stops nearer to it come last; None for no such preference.
    """
    mine = [s for s in stops if rival is None or planner.cost_m(s[1], start) <= planner.cost_m(s[1], rival)]
    others = [s for s in stops if not any(s is stop for stop in mine)]
    order: list[Stop] = []
    for part in (mine, others):
        at = order[-1][1] if order else start
        if part:
            order += order_by_nearest(planner, part, nearest_stop(planner, part, at))
    if closes_loop:
        return Tour(planner, shorten_round(planner, order), start)
    return Tour(planner, order)
