"""Collision avoidance of two robots: blocked paths, and refuges beside them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.motion.driving import CELL_M, costs_from, disc_mask, path_from_start

NEAR_M = 2.0  # a robot further away blocks no path
AHEAD_CELLS = 15  # points of a path, about one per cell, that must be free
IN_THE_WAY_M = 0.5  # between a path and the other robot's centre
BERTH_M = 0.6  # clearance of a detour around the other robot
ASIDE_M = 0.7  # between a refuge and the other robot's path
PATH_LEFT_FREE = 60  # points of the path of the other robot that a refuge keeps clear of


def is_in_the_way(path: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Return whether a robot at a point (2,) stands on the first part of a path (N, 2)."""
    ahead = path[:AHEAD_CELLS]
    return bool(len(ahead)) and bool(np.hypot(ahead[:, 0] - other[0], ahead[:, 1] - other[1]).min() < IN_THE_WAY_M)


def find_refuge(
    prices: NDArray[np.float64],
    position: NDArray[np.float64],
    other: NDArray[np.float64],
    others_path: NDArray[np.float64],
) -> NDArray[np.float64] | None:
    """Plan the path to the nearest place off the path of another robot.

    Parameters
    ----------
    prices
        As `DriveField.prices` gives them, shape (H, W).
    position, other
        Positions of both robots, (2,).
    others_path
        Path of the other robot, shape (N, 2).

    Returns
    -------
    NDArray or None
        Waypoints (N, 2); None where there is no such place.
    """
    free = np.where(disc_mask(prices.shape, other, IN_THE_WAY_M), np.inf, prices)
    costs = costs_from(free, position)
    refuge = np.where(disc_mask(prices.shape, other, BERTH_M + ASIDE_M), np.inf, costs)
    for point in others_path[: PATH_LEFT_FREE : round(0.3 / CELL_M)]:
        refuge[disc_mask(prices.shape, point, ASIDE_M)] = np.inf
    cell = divmod(int(np.argmin(refuge)), refuge.shape[1])
    return path_from_start(costs, cell) if np.isfinite(refuge[cell]) else None
