"""Inbox of the robots' maps: the newest of each, with its updates written into it; what was not taken is dropped."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field
from typing import Any

from rectmerge.errors import MapFileError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.occupancy_message import grid_of_message, updated


@dataclass(slots=True, eq=False)
class _Slot:
    """Newest map of a robot: as a message until somebody needs its cells, then as a grid, or why it is none."""

    message: Any
    sent: tuple[int, int]  # run of the publisher's clock and time in it, nanoseconds
    newest: OccupancyGrid | MapFileError | None = None
    fault: MapFileError | None = None  # of the last update, until it is taken
    is_new: bool = True
    lock: threading.Lock = field(default_factory=threading.Lock)  # decoding one map holds up no other

    def update(self, robot: str, message: Any) -> None:
        with self.lock:
            if isinstance(grid := self._decode(robot), MapFileError):
                return
            try:
                self.newest = updated(grid, message, f"the map update of {robot}")
                self.is_new, self.fault = True, None
            except MapFileError as fault:
                self.fault = fault

    def take(self, robot: str) -> list[OccupancyGrid | MapFileError]:
        with self.lock:
            new = [self._decode(robot)] if self.is_new else []
            if self.fault is not None:
                new.append(self.fault)
            self.is_new, self.fault = False, None
            return new

    def _decode(self, robot: str) -> OccupancyGrid | MapFileError:
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
        self._lock, self._arrived = threading.Lock(), threading.Event()
        self._slots: dict[str, _Slot] = {}
        self._heard: dict[tuple[str, str], tuple[int, int]] = {}  # when the last message of a subscription was sent

    def put(self, robot: str, message: Any, sent_ns: int = 0, subscription: str = "") -> None:
        """Keep a nav_msgs/OccupancyGrid in place of an earlier one.

        Parameters
        ----------
        robot
            Whose map it is.
        message
            The message.
        sent_ns
            Time at which it was sent, by its publisher's clock, nanoseconds; 0 where it is not known. A message sent no
            later than the newest comes late on another subscription, and is dropped.
        subscription
            Which of the robot's subscriptions brought it. Each brings messages in the order of their sending: where the
            time goes back on one, the publisher has been started again, and its clock runs anew.
        """
        with self._lock:
            slot, heard = self._slots.get(robot), self._heard.get((robot, subscription), (0, 0))
            sent = heard[0] + (0 < sent_ns < heard[1]), sent_ns
            if slot is not None and sent_ns and sent_ns == slot.sent[1]:
                sent = slot.sent  # the same message, so the same run of the clock
            if sent_ns:
                self._heard[robot, subscription] = sent
            if slot is None or not sent_ns or sent > slot.sent:
                self._slots[robot] = _Slot(message, sent)
                self._arrived.set()

    def update(self, robot: str, message: Any) -> None:
        """Write a map_msgs/OccupancyGridUpdate into the robot's newest map; before there is one it is dropped.

        An update that does not fit the map is reported by the next `take`, and the map stays as it was.
        """
        with self._lock:
            slot = self._slots.get(robot)
        if slot is not None:
            slot.update(robot, message)
            self._arrived.set()

    def wait(self, seconds: float) -> bool:
        """Wait until something has come since the last `take`, so long at most; return whether it has."""
        return self._arrived.wait(seconds)

    def wake(self) -> None:
        """End a wait though nothing has come."""
        self._arrived.set()

    def take(self) -> list[tuple[str, OccupancyGrid | MapFileError]]:
        """Return, with their robots, the maps that are new since the last call, and why a message is none.

        A robot's map comes before the fault of its last update.
        """
        self._arrived.clear()
        with self._lock:
            slots = list(self._slots.items())
        return [(robot, new) for robot, slot in slots for new in slot.take(robot)]
