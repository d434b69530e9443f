"""Rows of rooms along a corridor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim.floorplans.drafting import Gap, Pen
from sim.floorplans.shapes import Points

THROUGH = 0.25  # share of the neighbours that a door joins


def cut_widths(rng: np.random.Generator, low: float, high: float, count: int, narrowest: float) -> Points:
    """Cut a span into rooms of unequal width and return the count + 1 ends."""
    spare = max(0.0, high - low - count * narrowest)
    widths = narrowest + spare * rng.dirichlet(np.full(count, 3.0))
    return np.linspace(low, high, count + 1) if spare == 0.0 else low + np.concatenate([[0.0], np.cumsum(widths)])


def draw_row(
    pen: Pen,
    start: Points,
    end: Points,
    depth: float,
    cuts: Sequence[float] | Points,
    names: Sequence[str],
    corridor: str,
    *,
    reach: tuple[float, float] | None = None,
    doors: Sequence[Gap] = (),
) -> None:
    """Draw rooms side by side, to the left of a wall from start to end that divides them from a corridor.

    Parameters
    ----------
    pen
        Draws the rooms, the wall, and the partitions between the rooms, but not the other walls.
    start, end
        Ends (2,) of the corridor's wall.
    depth
        Depth of the rooms, metres.
    cuts
        Starts of the rooms and the end of the last, metres along the wall, which may be shorter than the row.
    names
        Names of the rooms, one fewer than cuts.
    corridor
        Name of the corridor.
    reach
        Stretch of the wall along the corridor, if not all of it.
    doors
        One for each room, in metres from its start, instead of random ones; then there are none between rooms.
    """
    along = (end - start) / np.hypot(*(end - start))
    inward = np.array([-along[1], along[0]]) * depth
    near = start + np.asarray(cuts)[:, None] * along  # (N + 1, 2)
    far = near + inward
    low, high = reach or (cuts[0], cuts[-1])
    for k, name in enumerate(names):
        pen.room(name, [near[k], near[k + 1], far[k + 1], far[k]])
        begin = float(cuts[k])
        stretch = max(begin, low) - begin, min(float(cuts[k + 1]), high) - begin
        pen.wall([near[k], near[k + 1]], [doors[k]] if doors else pen.door(*stretch, name, corridor))
    for k in range(1, len(names)):
        draw_partition(pen, near[k], far[k], names[k - 1], names[k], may_have_door=not doors)


def draw_partition(pen: Pen, near: Points, far: Points, first: str, second: str, *, may_have_door: bool) -> None:
    """Draw the wall between two neighbours, with a door in one of four."""
    has_door = may_have_door and pen.rng.random() < THROUGH
    length = float(np.hypot(*(far - near)))
    pen.wall([near, far], pen.door(0.5, length - 0.5, first, second, is_needed=False) if has_door else [])
