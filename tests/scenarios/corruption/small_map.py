"""A small_map map for the tests of corruptions."""

from __future__ import annotations

import numpy as np

from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid


def small_map() -> OccupancyGrid:
    """A room of 180 x 180 cells with walls two cells thick, in unknown space."""
    cells = np.full((200, 200), UNKNOWN, dtype=np.int8)
    cells[8:192, 8:192] = OCCUPIED
    cells[10:190, 10:190] = FREE
    return OccupancyGrid(cells, 0.05, (1.0, 2.0, 0.3))


def changed(before: OccupancyGrid, after: OccupancyGrid) -> np.ndarray:
    return before.occupancy != after.occupancy
