"""Walls that the merged map of two shows twice: beside each other, where one map or the other is bent."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.exact_distance import exact_distance
from rectmerge.analysis.overlap import CONFLICT_REACH_CELLS, MAX_WALL_CELLS, cells_of
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

# source of both: hand, no data
REACH_SHARE = 0.03  # of the diagonal of A's walls, within which a wall of the other map is taken for the same wall
MIN_REACH_CELLS = 6.0  # for small maps


def double_wall_share(a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity) -> float | None:
    """Measure the share of the common walls of two maps that their merged map shows twice.

    Parameters
    ----------
    a, b
        The two maps.
    pixels
        From B's pixels to A's.

    Returns
    -------
    float or None
        0..1: of the wall cells of either map with a wall of the other within 3 % of the diagonal of A's walls, those
        that lie more than 2 cells of A from it. None where there are no such cells.

    Examples
    --------
    >>> occupancy = np.zeros((60, 60), np.int8)
    >>> occupancy[[10, 40]] = 100
    >>> room = OccupancyGrid(occupancy)
    >>> double_wall_share(room, room, Similarity()), double_wall_share(room, room, Similarity(ty=4.0))
    (0.0, 1.0)
    """
    walls_a, walls_b = (cells_of(grid.occupied, MAX_WALL_CELLS)[:, ::-1] for grid in (a, b))
    if not (len(walls_a) and len(walls_b)):
        return None
    reach = max(MIN_REACH_CELLS, REACH_SHARE * float(np.hypot(*np.ptp(walls_a, axis=0))))
    back = pixels.inverse()
    of_b = _distances(a, pixels.apply(walls_b))
    of_a = _distances(b, back.apply(walls_a)) * pixels.scale
    distances = np.concatenate([of_a, of_b])
    common = distances[distances <= reach]
    return float((common > CONFLICT_REACH_CELLS).mean()) if len(common) else None


def _distances(grid: OccupancyGrid, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance of pixel points, (N, 2), to the nearest wall of a map; infinite outside it."""
    to_wall = exact_distance(grid.occupied)
    u, v = np.rint(points).astype(np.intp).T
    height, width = grid.shape
    inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
    distances = to_wall[v.clip(0, height - 1), u.clip(0, width - 1)]
    return np.where(inside, distances, np.inf)
