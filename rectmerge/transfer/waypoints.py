"""Waypoints as nav2's panel in RViz saves and loads them, carried to map A."""

from __future__ import annotations

from typing import Any

import yaml

from rectmerge.errors import InputError
from rectmerge.io.image_file import BROKEN
from rectmerge.similarity import Similarity
from rectmerge.transfer.poses import finite, moved, short, turned_quaternion

KEYS = {"pose": "xyz", "orientation": "wxyz"}  # the quaternion's w comes first


def carry_waypoints(text: str, b_to_a: Similarity) -> str:
    """Carry waypoints: of each its pose [x, y, z] and orientation [w, x, y, z]; whatever else is told stays.

    Raises
    ------
    InputError
        If it is no YAML of such waypoints.
    """
    try:
        told = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, *BROKEN) as error:
        raise InputError(" ".join(str(error).split())[:200] or "no valid YAML") from None
    waypoints = told.get("waypoints") if isinstance(told, dict) else None
    if not isinstance(waypoints, dict) or not waypoints:
        raise InputError("there must be waypoints by name, of each a pose [x, y, z] and an orientation [w, x, y, z]")
    carried = {name: _carried(str(name), one, b_to_a) for name, one in waypoints.items()}
    laid: str = yaml.safe_dump(
        told | {"waypoints": carried}, sort_keys=False, default_flow_style=None, allow_unicode=True
    )
    return laid


def _carried(name: str, told: Any, b_to_a: Similarity) -> dict[str, Any]:
    if not isinstance(told, dict):
        raise InputError(f"{short(name)} must have a pose and an orientation, got {short(told)}")
    pose, (w, x, y, z) = (_numbers(name, told, key) for key in KEYS)
    at = moved([pose[:2]], b_to_a)[0].tolist()
    x, y, z, w = turned_quaternion(short(name), (x, y, z, w), b_to_a.angle)
    return told | {"pose": [*at, pose[2]], "orientation": [w, x, y, z]}


def _numbers(name: str, told: dict[Any, Any], key: str) -> list[float]:
    numbers = told.get(key)
    if not isinstance(numbers, list) or len(numbers) != len(KEYS[key]):
        raise InputError(f"the {key} of {short(name)} must be [{', '.join(KEYS[key])}], got {short(numbers)}")
    return [finite(f"the {key} of {short(name)}", number) for number in numbers]
