"""Headings of map B turned to A's map frame, and their names in files."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

from rectmerge.errors import InputError
from rectmerge.transfer.carrier import DECIMALS

TURN = {  # a full turn in the unit of a heading, by its name
    **dict.fromkeys(("yaw", "theta", "heading"), math.tau),
    **dict.fromkeys(("yaw_deg", "theta_deg", "heading_deg"), 360.0),
}
PREFIXES = ("q", "orientation.", "orientation_")  # before x, y, z and w in the names of a quaternion's parts
QUATERNIONS = [[prefix + axis for axis in "xyzw"] for prefix in PREFIXES]
CARRIED = {*TURN, *(name for names in QUATERNIONS for name in names)}
LIKE_HEADINGS = re.compile(r"yaw|theta|heading|angle|orient|bearing|rotation")
Quaternion = tuple[float, float, float, float]  # x, y, z, w


def turn_headings(values: Mapping[str, Any], angle: float) -> dict[str, float]:
    """Turn the values named as headings in `TURN` and `QUATERNIONS`.

    Parameters
    ----------
    values
        Values by name, numbers or their text; upper case and blanks around a name make no difference.
    angle
        The turn, radians counter-clockwise.

    Returns
    -------
    dict
        The turned headings, by the names in `values`, without the empty ones.

    Raises
    ------
    InputError
        If a heading is not a finite number or surely not in radians, or a quaternion is incomplete.

    Examples
    --------
    >>> turn_headings({"Yaw_deg": 170, "speed": 1}, math.radians(20))
    {'Yaw_deg': -170.0}
    """
    names: dict[str, str] = {}
    for key in values:
        name = key.strip().lower()
        if name in CARRIED and name in names:
            raise InputError(f"{name} is given twice")
        names[name] = key
    turned = {}
    for name, full_turn in TURN.items():
        if name in names and not _is_empty(values[names[name]]):
            turned[names[name]] = _turn_angle(names[name], values[names[name]], angle, full_turn)
    for parts in QUATERNIONS:
        numbers = [values[names[part]] if part in names else None for part in parts]
        if not all(map(_is_empty, numbers)):
            quaternion = turn_quaternion(", ".join(parts), _complete_quaternion(parts, numbers), angle)
            turned |= {names[part]: number for part, number in zip(parts, quaternion, strict=True) if part in names}
    return turned


def turn_quaternion(name: str, quaternion: Quaternion, angle: float) -> Quaternion:
    """Turn a quaternion (x, y, z, w), level or tilted, about the vertical; its name is for messages.

    Raises
    ------
    InputError
        If it is zero, which is no rotation.
    """
    x, y, z, w = quaternion
    if math.hypot(*quaternion) < 1e-6:
        raise InputError(f"{name}: a quaternion of zeros is no heading")
    s, c = math.sin(angle / 2), math.cos(angle / 2)
    x, y, z, w = (round(n, DECIMALS) + 0.0 for n in (c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z))
    return x, y, z, w


def parse_finite(name: str, value: Any) -> float:
    """Parse a finite number, also from text, as YAML reads 1e-5 as text.

    Raises
    ------
    InputError
        If it is not a finite number.
    """
    with contextlib.suppress(ValueError, TypeError, OverflowError):
        if not isinstance(value, bool) and math.isfinite(number := float(value)):
            return number
    raise InputError(f"{name}: {abbreviate(value)} is not a finite number")


def abbreviate(value: object) -> str:
    """Return a value as text for a message, at most 40 characters."""
    return f"{value!r:.40}"


def unknown_headings(names: Iterable[str]) -> list[str]:
    """Return the names that look like a heading's but that `turn_headings` does not know."""
    return [name for name in names if LIKE_HEADINGS.search(name.lower()) and name.strip().lower() not in CARRIED]


def _is_empty(value: Any) -> bool:
    return value is None or (isinstance(value, str) and not value.strip())


def _turn_angle(name: str, value: Any, angle: float, full_turn: float) -> float:
    """Turn an angle and reduce it to half a turn either way, the upper end included."""
    number = parse_finite(name, value)
    if full_turn == math.tau and abs(number) > full_turn:
        raise InputError(f"{name}: {number:g} is more than a turn in radians; name it {name.strip()}_deg if in degrees")
    turned = round(math.remainder(number + angle * (full_turn / math.tau), full_turn), DECIMALS) + 0.0
    return turned if turned > -full_turn / 2 else turned + full_turn


def _complete_quaternion(names: list[str], values: list[Any]) -> Quaternion:
    """Parse z and w, and x and y where given; both of each pair are needed."""
    for i, j in ((0, 1), (2, 3)):
        if _is_empty(values[i]) != _is_empty(values[j]):
            raise InputError(f"{names[i]} and {names[j]} belong together, but one is missing")
    if _is_empty(values[2]):
        raise InputError(f"{names[0]} and {names[1]} are no heading without {names[2]} and {names[3]}")
    tilt = (0.0, 0.0) if _is_empty(values[0]) else tuple(parse_finite(names[i], values[i]) for i in (0, 1))
    return (tilt[0], tilt[1], parse_finite(names[2], values[2]), parse_finite(names[3], values[3]))
