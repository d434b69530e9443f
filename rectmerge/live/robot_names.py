"""Names of robots, from the topics of their maps."""

from __future__ import annotations

import re

from rectmerge.errors import InputError

PLACEHOLDER = "ROBOT"
PATTERN = f"/{PLACEHOLDER}/map"  # of topics, unless another is given


def robot_of(topic: str, pattern: str = PATTERN) -> str | None:
    """Return the robot whose map is on a topic, None where the topic is not of the pattern.

    Parameters
    ----------
    topic
        Full name of the topic.
    pattern
        Full name with `ROBOT` in place of the robot's name, which may hold slashes.

    Raises
    ------
    InputError
        If the pattern does not hold `ROBOT` once.

    Examples
    --------
    >>> robot_of("/robot1/map")
    'robot1'
    >>> robot_of("/fleet/a7/local_map", "/fleet/ROBOT/local_map")
    'a7'
    >>> robot_of("/map") is None
    True
    """
    if pattern.count(PLACEHOLDER) != 1 or not pattern.startswith("/"):
        raise InputError(f"{pattern!r}: name topics with {PLACEHOLDER} in place of the robot, as in {PATTERN}")
    before, after = map(re.escape, pattern.split(PLACEHOLDER))
    match = re.fullmatch(f"{before}(.+){after}", topic)
    return match[1] if match else None
