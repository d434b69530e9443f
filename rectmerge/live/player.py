"""Bags of ROS 2 played on real topics with a clock, where no ROS but its client library is installed."""

from __future__ import annotations

import importlib
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock

from rectmerge.io.bag_file import BagMessage, bag_messages

LATCHED_TYPES = ("nav_msgs/msg/OccupancyGrid",)
LATCHED_TOPICS = ("/tf_static",)
DEPTH = 10
STEP_S = 0.2  # longest sleep, so that an interrupt is heard


def play(bag: str | os.PathLike[str], *, speed: float = 1.0, stays: bool = False) -> None:
    """Publish every message of a bag at its time, and the time on /clock; warn of types that are not installed.

    Parameters
    ----------
    bag
        MCAP, sqlite3 or a rosbag2 folder.
    speed
        Seconds of the bag in a second.
    stays
        Keep what is latched on its topics until interrupted.

    Raises
    ------
    MapFileError
        As `rectmerge.io.bag_file.bag_messages`.
    """
    with _node() as node:
        player = _Player(node)
        player.play(bag_messages(bag), speed)
        left_out = sorted(topic for topic, publisher in player.publishers.items() if publisher is None)
        if left_out:
            node.get_logger().warning(f"not published, for their types are not installed: {', '.join(left_out)}")
        while stays:
            time.sleep(STEP_S)


@contextmanager
def _node() -> Iterator[Node]:
    rclpy.init()
    try:
        yield Node("rectbench_mission")
    finally:
        rclpy.try_shutdown()


class _Player:
    """Publishers of a bag's topics; None where the type of a topic is not installed."""

    def __init__(self, node: Node) -> None:
        self.publishers: dict[str, Any] = {}
        self._node = node
        self._clock = node.create_publisher(Clock, "/clock", DEPTH)

    def play(self, messages: Iterable[BagMessage], speed: float) -> None:
        """Publish messages, each at its time."""
        first, started = None, time.monotonic()
        for message in messages:
            first = message.time_s if first is None else first
            due = started + (message.time_s - first) / speed
            while (left := due - time.monotonic()) > 0:
                time.sleep(min(left, STEP_S))
            self._publish(message)

    def _publish(self, message: BagMessage) -> None:
        if message.topic not in self.publishers:
            self.publishers[message.topic] = self._publisher(message)
        if (publisher := self.publishers[message.topic]) is not None:
            nanoseconds = round(message.time_s * 1e9)
            clock = Clock()
            clock.clock.sec, clock.clock.nanosec = divmod(nanoseconds, 10**9)
            self._clock.publish(clock)
            publisher.publish(message.data)

    def _publisher(self, message: BagMessage) -> Any:
        package, _, name = message.type.partition("/msg/")
        try:
            message_type = getattr(importlib.import_module(f"{package}.msg"), name)
        except (ImportError, AttributeError):
            return None
        is_latched = message.type in LATCHED_TYPES or message.topic in LATCHED_TOPICS
        kept = DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE
        return self._node.create_publisher(message_type, message.topic, QoSProfile(depth=DEPTH, durability=kept))
