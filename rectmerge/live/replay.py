"""Recorded maps played back through the live merger, as fast as it can, on the recording's own clock."""

from __future__ import annotations

import heapq
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from rectmerge.errors import InputError, RectMergeError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.bag_file import bag_maps
from rectmerge.live.merger import LiveMerger
from rectmerge.live.publication import Publication
from rectmerge.live.robot_names import PATTERN, robot_of


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """Step of the live merger in a recording.

    Parameters
    ----------
    time_s
        Seconds since the first map.
    published
        What the node would have published then.
    """

    time_s: float
    published: Publication


def replay(
    bags: Sequence[str | os.PathLike[str]],
    merger: LiveMerger,
    *,
    period_s: float = 1.0,
    pattern: str = PATTERN,
) -> Iterator[Step]:
    """Play recorded maps to a merger; yield a step for each period in which a map came.

    Parameters
    ----------
    bags
        Recordings, of one clock. The maps of each period are put to the merger together, the newest of each robot.
    merger
        The merger.
    period_s
        Seconds of the recording between two steps.
    pattern
        Topics of the robots' maps; see `rectmerge.live.robot_names.robot_of`.

    Raises
    ------
    MapFileError
        If a bag cannot be read.
    InputError
        If no topic is of the pattern, or the pattern holds no robot.
    """
    maps = heapq.merge(*map(bag_maps, bags), key=lambda each: each[0])
    return play(maps, merger, period_s=period_s, pattern=pattern)


def play(
    maps: Iterable[tuple[float, str, OccupancyGrid | RectMergeError]],
    merger: LiveMerger,
    *,
    period_s: float = 1.0,
    pattern: str = PATTERN,
) -> Iterator[Step]:
    """Play maps in the order of their time, each with its second and its topic, as `replay` does those of bags."""
    start, due, is_waiting = None, 0.0, False
    topics = set()
    for time, topic, newest in maps:
        topics.add(topic)
        robot = robot_of(topic, pattern)
        if robot is None:
            continue
        if start is None:
            start, due = time, time + period_s
        if time >= due:
            if is_waiting:
                yield Step(due - start, merger.step())
            due += period_s * ((time - due) // period_s + 1)
        merger.update(robot, newest)
        is_waiting = True
    if start is None:
        raise InputError(f"no topic is like {pattern}: the maps are on {', '.join(sorted(topics)) or 'none'}")
    yield Step(due - start, merger.step())
