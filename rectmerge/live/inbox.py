"""Inbox of the robots' maps: the newest of each, with its updates written into it; what was not taken is dropped."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

from rectmerge.errors import MapFileError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.occupancy_message import grid_of_message, updated


@dataclass(slots=True, eq=False)
class _Slot:
    """Newest map of a robot: as a message until somebody needs its cells, then as a grid, or why it is none."""

    message: Any
    sent_ns: int
    newest: OccupancyGrid | MapFileError | None = None
    fault: MapFileError | None = None  # of the last update
    is_new: bool = True

    def decode(self, robot: str) -> OccupancyGrid | MapFileError:
        if self.newest is None:
            try:
                self.newest = grid_of_message(self.message, f"the map of {robot}")
            except MapFileError as fault:
                self.newest = fault
            self.message = None
        return self.newest


class MapInbox:
    """Newest map of each robot; put by the callbacks of a node, taken by the thread that merges.

    It holds one map a robot, however many come.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._slots: dict[str, _Slot] = {}

    def put(self, robot: str, message: Any, sent_ns: int = 0) -> None:
        """Keep a nav_msgs/OccupancyGrid in place of an earlier one.

        Parameters
        ----------
        robot
            Whose map it is.
        message
            The message.
        sent_ns
            Time at which it was sent, by its publisher's clock, nanoseconds; a message of the same time is the same one
            on another subscription, and is dropped. 0 where it is not known.
        """
        with self._lock:
            slot = self._slots.get(robot)
            if slot is None or not sent_ns or slot.sent_ns != sent_ns:
                self._slots[robot] = _Slot(message, sent_ns)

    def update(self, robot: str, message: Any) -> None:
        """Write a map_msgs/OccupancyGridUpdate into the robot's newest map; before there is one it is dropped.

        An update that does not fit the map is told by the next `take`, and the map stays as it was.
        """
        with self._lock:
            slot = self._slots.get(robot)
            if slot is None or isinstance(grid := slot.decode(robot), MapFileError):
                return
            slot.is_new = True
            try:
                slot.newest, slot.fault = updated(grid, message, f"the map update of {robot}"), None
            except MapFileError as fault:
                slot.fault = fault

    def take(self) -> dict[str, OccupancyGrid | MapFileError]:
        """Return the maps that are new since the last call, or why a message is no map, by robot."""
        with self._lock:
            new = {robot: slot for robot, slot in self._slots.items() if slot.is_new}
            for slot in new.values():
                slot.is_new = False
            return {robot: slot.fault or slot.decode(robot) for robot, slot in new.items()}
