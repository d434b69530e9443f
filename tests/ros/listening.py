"""Listener to what the node publishes, and robots that send to it, for tests on a real ROS 2."""

import math
import time

import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import OccupancyGrid as GridMessage
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock

from rectmerge.io.occupancy_message import grid_of_message
from rectmerge.live.node import LATCHED, MOST_ROBOTS
from rectmerge.live.ros_messages import grid_message
from rectmerge.similarity import Similarity
from tests.ros.domain import DOMAIN, LONGEST_S


class Listener:
    """What the node publishes, as a late subscriber hears it."""

    def __init__(self):
        self._context = Context()
        rclpy.init(context=self._context, domain_id=DOMAIN)
        self._node = Node("listener", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        many = QoSProfile(depth=MOST_ROBOTS, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.maps, self.placements, self.transforms, self.statuses = [], [], {}, {}
        self._robots, self._clock = {}, None
        self._node.create_subscription(GridMessage, "/map", self._take_map, LATCHED)
        self._node.create_subscription(TransformStamped, "/rectmerge/transforms", self._take_transform, many)
        self._node.create_subscription(DiagnosticArray, "/diagnostics", self._take_diagnostics, 10)

    def _take_map(self, message):
        self.maps.append((message.header.frame_id, grid_of_message(message, "merged")))

    def _take_transform(self, message):
        move, turn = message.transform.translation, message.transform.rotation
        angle = 2 * math.atan2(turn.z, turn.w)
        placement = Similarity(1.0, angle, move.x, move.y)
        self.transforms[message.child_frame_id] = message.header.frame_id, placement
        self.placements.append((message.child_frame_id, placement))

    def _take_diagnostics(self, message):
        self.statuses |= {status.hardware_id: status for status in message.status}

    def wait_for(self, what):
        """Listen until something is so."""
        end = time.monotonic() + LONGEST_S
        while not what():
            assert time.monotonic() < end, f"not heard: {self.statuses}"
            self._executor.spin_once(timeout_sec=0.2)

    def is_compared(self, robot):
        """Whether the map of a robot has been compared with others."""
        status = self.statuses.get(robot)
        return status is not None and any(each.key == "verdict" and each.value for each in status.values)

    def listen(self, seconds):
        """Listen for a while."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self._executor.spin_once(timeout_sec=left)

    def send(self, robot, grid, number=1):
        """Publish the map of a robot, by one of several publishers under its name."""
        if (robot, number) not in self._robots:
            self._robots[robot, number] = self._node.create_publisher(GridMessage, f"/{robot}/map", LATCHED)
        stamp = self._node.get_clock().now().to_msg()
        self._robots[robot, number].publish(grid_message(grid, grid.frame or "map", stamp))

    def set_clock(self, seconds):
        """Publish the time of a simulation."""
        if self._clock is None:
            self._clock = self._node.create_publisher(Clock, "/clock", 10)
        self._clock.publish(Clock(clock=Time(sec=seconds)))

    def is_ok(self, robot):
        """Whether the diagnostics say of a robot that its map is in the merged one, without a warning."""
        return robot in self.statuses and self.statuses[robot].level == DiagnosticStatus.OK

    def close(self):
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)
