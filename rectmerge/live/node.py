"""ROS 2 node that merges the maps of robots while they explore.

``python -m rectmerge.live.node --ros-args -p rate:=2.0`` runs it as an executable of ROS does.
"""

from __future__ import annotations

import contextlib
import functools
import os
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import OccupancyGrid as GridMessage
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from rectmerge.errors import InputError, RectMergeError
from rectmerge.grid import OccupancyGrid
from rectmerge.live.inbox import MapInbox
from rectmerge.live.memory import Memory
from rectmerge.live.merger import LiveMerger
from rectmerge.live.params import LiveParams
from rectmerge.live.publication import Publication
from rectmerge.live.robot_names import robot_of
from rectmerge.live.ros_messages import grid_message, status_message, transform_message
from rectmerge.live.settings import Settings
from rectmerge.similarity import Similarity

MAP_TYPE = "nav_msgs/msg/OccupancyGrid"
TOGETHER_S = 0.05  # maps that robots send at the same time are taken at once
LONGEST_END_S = 1.5  # an interrupt ends the node within 2 s
UPDATES = "_updates"  # after the topic of a map, that of its updates
UPDATE_DEPTH = 10  # updates that wait for the node's callbacks; later ones are lost
MOST_ROBOTS = 100  # transforms that a late subscriber gets
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE)
VOLATILE = QoSProfile(depth=1, durability=DurabilityPolicy.VOLATILE, reliability=ReliabilityPolicy.RELIABLE)


class MergerNode(Node):  # type: ignore[misc] # rclpy has no types
    """Node that subscribes to the map of every robot and publishes the merged one.

    Parameters
    ----------
    defaults
        Settings where no parameter of ROS says otherwise.

    Notes
    -----
    Callbacks keep the newest map of each robot alone; a thread takes them as soon as they have come, at the given rate
    at most. What comes faster is dropped.
    """

    def __init__(self, defaults: Settings) -> None:
        super().__init__("rectmerge")
        self.settings = self._declare(defaults)
        memory_file = self.settings.memory_file
        self._memory_file = Path(memory_file).expanduser() if memory_file else None
        memory = None if self._memory_file is None else Memory.read(self._memory_file)
        self._merger = LiveMerger(
            reference=self.settings.reference,
            method=self.settings.method,
            params=LiveParams(accepts=self.settings.accepts),
            memory=memory,
        )
        self.inbox, self._frames = MapInbox(), dict[str, str]()
        self._subscriptions_by_robot: dict[str, Sequence[Any]] = {}
        self._sent_grid: object = None
        self._sent: dict[str, tuple[str, Similarity]] = {}
        self._map = self.create_publisher(GridMessage, self.settings.merged_topic, LATCHED)
        latched_many = QoSProfile(depth=MOST_ROBOTS, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._transforms = self.create_publisher(TransformStamped, "~/transforms", latched_many)
        self._tf = self._static_tf()
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._own_topic = self.resolve_topic_name(self.settings.merged_topic)
        for robot in self.settings.robots:
            self._subscribe(robot)

    def cycle(self) -> bool:
        """Take the newest maps, merge, and publish what has changed; return whether a map was new."""
        if not self.settings.robots:
            self._discover()
        taken = self.inbox.take()
        for robot, newest in taken:
            if isinstance(newest, OccupancyGrid):
                self._frames[robot] = newest.frame or ""
            self._merger.update(robot, newest)
        published = self._merger.step()
        for event in published.events:
            self.get_logger().info(f"{event.robot} {event.change}: {event.reason}")
        if published.events:
            self._remember()
        self._publish(published)
        return bool(taken)

    def _declare(self, defaults: Settings) -> Settings:
        """Declare a parameter for each setting and return the settings that they give."""
        values = {}
        for each in fields(Settings):
            bounds = each.metadata["bounds"]
            descriptor = ParameterDescriptor(description=each.metadata["about"], read_only=True)
            value = getattr(defaults, each.name)
            if isinstance(value, int):
                descriptor.integer_range = [IntegerRange(from_value=bounds[0], to_value=bounds[1], step=0)]
            elif isinstance(value, float):
                descriptor.floating_point_range = [FloatingPointRange(from_value=bounds[0], to_value=bounds[1])]
            if isinstance(value, tuple):
                value = Parameter(each.name, Parameter.Type.STRING_ARRAY, list(value)).value
                descriptor.type, descriptor.dynamic_typing = Parameter.Type.STRING_ARRAY.value, True
            values[each.name] = self.declare_parameter(each.name, value, descriptor).value
        return Settings.from_values(values)

    def _discover(self) -> None:
        """Subscribe to the maps of robots that have appeared."""
        for topic, types in self.get_topic_names_and_types():
            robot = robot_of(topic, self.settings.topics)
            if robot is not None and MAP_TYPE in types and topic != self._own_topic:
                self._subscribe(robot)

    def _subscribe(self, robot: str) -> None:
        """Subscribe to a robot's map, latched or not, and to its updates where ROS has their type."""
        if robot in self._subscriptions_by_robot:
            return

        def subscribed(name: str, quality: QoSProfile) -> Any:
            def put(message: Any, about: Any) -> None:
                self.inbox.put(robot, message, about["source_timestamp"], name)

            return self.create_subscription(GridMessage, topic, put, quality)

        topic = self.settings.topic_of(robot)
        subscriptions = [subscribed("latched", LATCHED), subscribed("volatile", VOLATILE)]
        if (update_type := update_message_type()) is not None:
            update = functools.partial(self.inbox.update, robot)
            subscriptions.append(self.create_subscription(update_type, topic + UPDATES, update, UPDATE_DEPTH))
        self._subscriptions_by_robot[robot] = subscriptions

    def _remember(self) -> None:
        if self._memory_file is None:
            return
        try:
            self._merger.memory.write(self._memory_file)
        except InputError as error:
            self.get_logger().warning(str(error), once=True)

    def _publish(self, published: Publication) -> None:
        stamp = self.get_clock().now().to_msg()
        if published.grid is not None and published.grid is not self._sent_grid:
            self._map.publish(grid_message(published.grid, self.settings.frame, stamp))
            self._sent_grid = published.grid
        notes = self._notes(published)
        placed = {robot: published.transform(robot).rigid for robot in published.placements}
        if published.reference in published.maps:
            placed[published.reference] = Similarity()
        now = {robot: (self._child(robot), place) for robot, place in placed.items()}
        if now != self._sent:
            messages = [transform_message(place, self.settings.frame, child, stamp) for child, place in now.values()]
            for message in messages:
                self._transforms.publish(message)
            if self._tf is not None:
                publisher, message_type = self._tf
                publisher.publish(message_type(transforms=messages))
            self._sent = now
        statuses = [status_message(robot, each, notes.get(robot, [])) for robot, each in published.statuses.items()]
        array = DiagnosticArray(status=statuses)
        array.header.stamp = stamp
        self._diagnostics.publish(array)

    def _notes(self, published: Publication) -> dict[str, list[str]]:
        """Return what a person should know of each robot besides its placement."""
        notes: dict[str, list[str]] = {}
        for robot in published.statuses:
            topic, frame = self.settings.topic_of(robot), self._frames.get(robot, "")
            if (count := self.count_publishers(topic)) > 1:
                notes.setdefault(robot, []).append(f"{count} publishers send on {topic}: maps of two robots would mix")
            if robot in self._frames and (reason := self._shared_frame(robot)):
                notes.setdefault(robot, []).append(f"its frame {frame!r} is {reason}: TF has {robot}/map instead")
            if robot in published.placements and (fault := published.transform(robot).scale_fault):
                notes.setdefault(robot, []).append(fault)
        return notes

    def _shared_frame(self, robot: str) -> str:
        """Return why a robot's frame cannot be a child in TF; empty where it can."""
        frame = self._frames[robot]
        if frame in ("", self.settings.frame):
            return "that of the merged map" if frame else "empty"
        others = [other for other, name in self._frames.items() if name == frame and other != robot]
        return f"that of {others[0]} as well" if others else ""

    def _child(self, robot: str) -> str:
        return f"{robot}/map" if self._shared_frame(robot) else self._frames[robot]

    def _static_tf(self) -> tuple[Any, Any] | None:
        """Return the publisher of /tf_static and its type, where ROS has it: there is no wheel of tf2_msgs."""
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            return None
        return self.create_publisher(TFMessage, "/tf_static", LATCHED), TFMessage


def update_message_type() -> Any:
    """Return map_msgs/OccupancyGridUpdate, None where ROS has it not: there is no wheel of map_msgs."""
    try:
        from map_msgs.msg import OccupancyGridUpdate
    except ImportError:
        return None
    return OccupancyGridUpdate


def run(defaults: Settings, ros_arguments: Sequence[str] = ()) -> None:
    """Run the node until it is interrupted.

    Raises
    ------
    InputError
        If a parameter or an argument of ROS cannot be used; nothing is started then.
    """
    try:
        rclpy.init(args=[sys.argv[0], *ros_arguments])
    except Exception as error:  # noqa: BLE001 - rclpy's own errors of arguments share no class
        raise InputError(f"the arguments of ROS cannot be used: {error}") from None
    try:
        node = MergerNode(defaults)
    except (InvalidParameterValueException, InvalidParameterTypeException) as error:
        rclpy.try_shutdown()
        raise InputError(f"a parameter cannot be used: {error}") from None
    except RectMergeError:
        rclpy.try_shutdown()
        raise
    ended = threading.Event()
    worker = threading.Thread(target=_work, args=(node, ended), daemon=True)
    worker.start()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        ended.set()
        node.inbox.wake()
        rclpy.try_shutdown()
        worker.join(LONGEST_END_S)
        if worker.is_alive():  # a merge in progress holds nobody up, and Python cannot end beside ROS's threads
            os._exit(0)


def _work(node: MergerNode, ended: threading.Event) -> None:
    """Run the node's cycle until the node ends: when maps have come, at its rate at most, and once a period anyway."""
    period = 1.0 / node.settings.rate
    while not ended.is_set():
        if node.inbox.wait(period) and ended.wait(TOGETHER_S):
            return
        began, is_new = time.monotonic(), True
        try:
            is_new = node.cycle()
        except RectMergeError as error:
            node.get_logger().error(str(error))
        except Exception as error:  # noqa: BLE001 - a node that goes silent is worse than one that names its fault
            if ended.is_set() or not rclpy.ok():  # publishers of a node that ends raise whatever they like
                return
            node.get_logger().error(f"internal error, the next maps are tried again: {type(error).__name__}: {error}")
        if is_new:
            ended.wait(max(0.0, began + period - time.monotonic()))


def main() -> None:
    """Run the node with the arguments of the command line."""
    with contextlib.suppress(KeyboardInterrupt):
        run(Settings(), sys.argv[1:])


if __name__ == "__main__":
    main()
