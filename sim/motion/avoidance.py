"""How two robots get past each other: who is in whose way, and where one steps aside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.motion.driving import CELL_M, costs_from, disc, way_up

NEAR_M = 2.0  # a robot further away is in nobody's way
AHEAD_CELLS = 15  # of its path, about one cell per point, a robot keeps free
IN_THE_WAY_M = 0.5  # between a path and the other robot's centre
BERTH_M = 0.6  # what is left to the other robot when a way round it is planned
ASIDE_M = 0.7  # between a refuge and the other robot's path
PATH_LEFT_FREE = 60  # points of the other's path, to which a refuge keeps its distance


def is_in_the_way(path: NDArray[np.float64], other: NDArray[np.float64]) -> bool:
    """Whether a robot at a point (2,) stands on the first part of a path (N, 2)."""
    ahead = path[:AHEAD_CELLS]
    return bool(len(ahead)) and bool(np.hypot(ahead[:, 0] - other[0], ahead[:, 1] - other[1]).min() < IN_THE_WAY_M)


def find_refuge(
    prices: NDArray[np.float64],
    position: NDArray[np.float64],
    other: NDArray[np.float64],
    others_path: NDArray[np.float64],
) -> NDArray[np.float64] | None:
    """Plan the way to the nearest place where a robot is not in another's way.

    Parameters
    ----------
    prices
        As `DriveField.prices` gives them, shape (H, W).
    position, other
        Where both robots are, (2,).
    others_path
        Where the other is going, shape (N, 2).

    Returns
    -------
    NDArray or None
        Waypoints (N, 2); None where there is no such place.
    """
    free = np.where(disc(prices.shape, other, IN_THE_WAY_M), np.inf, prices)
    costs = costs_from(free, position)
    refuge = np.where(disc(prices.shape, other, BERTH_M + ASIDE_M), np.inf, costs)
    for point in others_path[: PATH_LEFT_FREE : round(0.3 / CELL_M)]:
        refuge[disc(prices.shape, point, ASIDE_M)] = np.inf
    cell = divmod(int(np.argmin(refuge)), refuge.shape[1])
    return way_up(costs, cell) if np.isfinite(refuge[cell]) else None
