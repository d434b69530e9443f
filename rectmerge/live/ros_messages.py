"""Messages of ROS 2 that the node publishes."""

from __future__ import annotations

import array
import math
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from geometry_msgs.msg import Pose, TransformStamped
from nav_msgs.msg import OccupancyGrid as GridMessage

from rectmerge.grid import OccupancyGrid
from rectmerge.live.publication import RobotStatus
from rectmerge.similarity import Similarity

LEVELS = {"ok": DiagnosticStatus.OK, "warn": DiagnosticStatus.WARN, "error": DiagnosticStatus.ERROR}


def grid_message(grid: OccupancyGrid, frame: str, stamp: Any) -> Any:
    """Return a nav_msgs/OccupancyGrid; a map without resolution has cells of one metre."""
    message = GridMessage()
    message.header.stamp = stamp
    message.header.frame_id = frame
    message.info.map_load_time = stamp
    message.info.resolution = grid.cell_size
    message.info.height, message.info.width = grid.shape
    x, y, yaw = grid.origin
    message.info.origin = Pose()
    message.info.origin.position.x, message.info.origin.position.y = x, y
    message.info.origin.orientation.z, message.info.origin.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    message.data = array.array("b", np.ascontiguousarray(grid.occupancy[::-1]).tobytes())
    return message


def transform_message(child_in_parent: Similarity, parent: str, child: str, stamp: Any) -> Any:
    """Return a geometry_msgs/TransformStamped; the scale is left out."""
    message = TransformStamped()
    message.header.stamp = stamp
    message.header.frame_id, message.child_frame_id = parent, child
    transform, yaw = message.transform, child_in_parent.angle
    transform.translation.x, transform.translation.y = child_in_parent.tx, child_in_parent.ty
    transform.rotation.z, transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return message


def status_message(robot: str, status: RobotStatus, notes: list[str]) -> Any:
    """Return a diagnostic_msgs/DiagnosticStatus of a robot; a note makes a warning of it."""
    level = "warn" if notes and status.level == "ok" else status.level
    text = "; ".join([status.message, *notes])
    message = DiagnosticStatus(level=LEVELS[level], name=f"rectmerge: {robot}", hardware_id=robot, message=text)
    values = {"verdict": status.verdict}
    if status.confidence is not None:
        values["confidence"] = f"{status.confidence:.3f}"
    message.values = [KeyValue(key=key, value=value) for key, value in values.items()]
    return message
