"""Waypoints of nav2's panel in RViz, carried to map A."""

from __future__ import annotations

from typing import Any

import yaml

from rectmerge.errors import InputError
from rectmerge.io.image_file import BROKEN
from rectmerge.transfer.carrier import Carrier
from rectmerge.transfer.poses import abbreviate, parse_finite, turn_quaternion

KEYS = {"pose": "xyz", "orientation": "wxyz"}  # the quaternion's w comes first


def carry_waypoints(text: str, carrier: Carrier) -> str:
    """Carry the pose [x, y, z] and the orientation [w, x, y, z] of waypoints; keep everything else.

    Raises
    ------
    InputError
        If the text is not a YAML of such waypoints.
    """
    try:
        document = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, *BROKEN) as error:
        raise InputError(" ".join(str(error).split())[:200] or "no valid YAML") from None
    waypoints = document.get("waypoints") if isinstance(document, dict) else None
    if not isinstance(waypoints, dict) or not waypoints:
        raise InputError("there must be waypoints by name, of each a pose [x, y, z] and an orientation [w, x, y, z]")
    carried = {name: _carry_waypoint(str(name), waypoint, carrier) for name, waypoint in waypoints.items()}
    dumped: str = yaml.safe_dump(
        document | {"waypoints": carried}, sort_keys=False, default_flow_style=None, allow_unicode=True
    )
    return dumped


def _carry_waypoint(name: str, waypoint: Any, carrier: Carrier) -> dict[str, Any]:
    if not isinstance(waypoint, dict):
        raise InputError(f"{abbreviate(name)} must have a pose and an orientation, got {abbreviate(waypoint)}")
    pose, (w, x, y, z) = (_numbers(name, waypoint, key) for key in KEYS)
    place = carrier.carry([pose[:2]])[0].tolist()
    x, y, z, w = turn_quaternion(abbreviate(name), (x, y, z, w), carrier.turn_at(pose[:2]))
    return waypoint | {"pose": [*place, pose[2]], "orientation": [w, x, y, z]}


def _numbers(name: str, waypoint: dict[Any, Any], key: str) -> list[float]:
    label, numbers = f"the {key} of {abbreviate(name)}", waypoint.get(key)
    if not isinstance(numbers, list) or len(numbers) != len(KEYS[key]):
        raise InputError(f"{label} must be [{', '.join(KEYS[key])}], got {abbreviate(numbers)}")
    return [parse_finite(label, number) for number in numbers]
