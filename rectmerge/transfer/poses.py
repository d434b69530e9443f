"""Places and headings of map B taken to A's map frame: numbers, and which names in a file tell a heading."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity

TURN = {  # a whole turn, by the name of a heading
    **dict.fromkeys(("yaw", "theta", "heading"), math.tau),
    **dict.fromkeys(("yaw_deg", "theta_deg", "heading_deg"), 360.0),
}
BEFORE = ("q", "orientation.", "orientation_")  # what stands before x, y, z and w in the names of a quaternion's parts
QUATERNIONS = [[before + axis for axis in "xyzw"] for before in BEFORE]
CARRIED = {*TURN, *(name for names in QUATERNIONS for name in names)}
LIKE_HEADINGS = re.compile(r"yaw|theta|heading|angle|orient|bearing|rotation")
DECIMALS = 9
Quaternion = tuple[float, float, float, float]  # x, y, z, w


def moved(points: ArrayLike, b_to_a: Similarity) -> NDArray[np.float64]:
    """Carry points, shape (N, 2), to A's map frame.

    Raises
    ------
    InputError
        If one comes out as no finite number.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        carried = b_to_a.apply(np.asarray(points, np.float64).reshape(-1, 2)).round(DECIMALS)
    if not np.isfinite(carried).all():
        raise InputError("a coordinate is not a finite number, or too large to be carried")
    return carried


def turned(told: Mapping[str, Any], angle: float) -> dict[str, float]:
    """Turn whatever tells a heading by its name, as `TURN` and `QUATERNIONS` list them.

    Parameters
    ----------
    told
        Values by name, numbers or their text; upper case and blanks around a name make no difference.
    angle
        By how much, radians counter-clockwise.

    Returns
    -------
    dict
        The turned values, by the names in `told`; what is no heading, or empty, is not among them.

    Raises
    ------
    InputError
        If a heading is no finite number or surely not in radians, or a quaternion is not whole.

    Examples
    --------
    >>> turned({"Yaw_deg": 170, "speed": 1}, math.radians(20))
    {'Yaw_deg': -170.0}
    """
    names: dict[str, str] = {}
    for key in told:
        name = key.strip().lower()
        if name in CARRIED and name in names:
            raise InputError(f"{name} is told twice")
        names[name] = key
    found = {}
    for name, whole in TURN.items():
        if name in names and not _is_empty(told[names[name]]):
            found[names[name]] = _turned_angle(names[name], told[names[name]], angle, whole)
    for parts in QUATERNIONS:
        values = [told[names[part]] if part in names else None for part in parts]
        if not all(map(_is_empty, values)):
            new = turned_quaternion(", ".join(parts), _whole_quaternion(parts, values), angle)
            found |= {names[part]: number for part, number in zip(parts, new, strict=True) if part in names}
    return found


def turned_quaternion(name: str, turn: Quaternion, angle: float) -> Quaternion:
    """Turn a quaternion (x, y, z, w) about the vertical, whatever it tilts; its name is for messages.

    Raises
    ------
    InputError
        If it is zero, which is no rotation.
    """
    x, y, z, w = turn
    if math.hypot(*turn) < 1e-6:
        raise InputError(f"{name}: a quaternion of zeros is no heading")
    s, c = math.sin(angle / 2), math.cos(angle / 2)
    x, y, z, w = (round(n, DECIMALS) + 0.0 for n in (c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z))
    return x, y, z, w


def finite(name: str, value: Any) -> float:
    """Read a finite number; text counts, too, for YAML takes 1e-5 for text.

    Raises
    ------
    InputError
        If it is none.
    """
    with contextlib.suppress(ValueError, TypeError, OverflowError):
        if not isinstance(value, bool) and math.isfinite(number := float(value)):
            return number
    raise InputError(f"{name}: {short(value)} is not a finite number")


def short(value: object) -> str:
    """Show a value in a message."""
    return f"{value!r:.40}"


def left_alone(names: Iterable[str]) -> list[str]:
    """Return those names that look like a heading's but are none that `turned` knows."""
    return [name for name in names if LIKE_HEADINGS.search(name.lower()) and name.strip().lower() not in CARRIED]


def _is_empty(value: Any) -> bool:
    return value is None or (isinstance(value, str) and not value.strip())


def _turned_angle(name: str, value: Any, angle: float, whole: float) -> float:
    """Turn an angle and bring it to half a turn either way, the upper end included."""
    number = finite(name, value)
    if whole == math.tau and abs(number) > whole:
        raise InputError(f"{name}: {number:g} is more than a turn in radians; name it {name.strip()}_deg if in degrees")
    new = round(math.remainder(number + angle * (whole / math.tau), whole), DECIMALS) + 0.0
    return new if new > -whole / 2 else new + whole


def _whole_quaternion(names: list[str], values: list[Any]) -> Quaternion:
    """Read z and w, and x and y where they are told; both of each are needed."""
    for one, other in ((0, 1), (2, 3)):
        if _is_empty(values[one]) != _is_empty(values[other]):
            raise InputError(f"{names[one]} and {names[other]} belong together, but one is missing")
    if _is_empty(values[2]):
        raise InputError(f"{names[0]} and {names[1]} are no heading without {names[2]} and {names[3]}")
    tilt = (0.0, 0.0) if _is_empty(values[0]) else (finite(names[0], values[0]), finite(names[1], values[1]))
    return (*tilt, finite(names[2], values[2]), finite(names[3], values[3]))
