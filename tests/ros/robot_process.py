"""Robot whose map grows, as a process of its own: ``python -m tests.ros.robot_process ROBOT FRAME ...``."""

from __future__ import annotations

import sys
import time

import rclpy
from nav_msgs.msg import OccupancyGrid as GridMessage
from rclpy.node import Node

from rectmerge.live.node import LATCHED, VOLATILE
from rectmerge.live.ros_messages import grid_message
from tests.rectmerge.live import growing


def main(robot: str, frame: str, which: str, period_s: str, durability: str) -> None:
    """Publish the versions of a map, a period apart, and stay."""
    rclpy.init()
    node = Node("robot")
    publisher = node.create_publisher(GridMessage, f"/{robot}/map", LATCHED if durability == "latched" else VOLATILE)
    for grid in growing.growing(getattr(growing, which)):
        publisher.publish(grid_message(grid, frame, node.get_clock().now().to_msg()))
        time.sleep(float(period_s))
    while True:  # a volatile map is heard only by those that listen when it comes
        if durability != "latched":
            publisher.publish(grid_message(grid, frame, node.get_clock().now().to_msg()))
        time.sleep(float(period_s))


if __name__ == "__main__":
    main(*sys.argv[1:])
