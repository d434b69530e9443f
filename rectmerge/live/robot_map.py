"""Map of one robot as it grows: the newest one, and the version that was last looked at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from rectmerge.live.params import LiveParams

ON_THE_LATTICE = 0.1  # cells by which the corners of two versions may lie off each other's cells


@dataclass(slots=True, eq=False)
class RobotMap:
    """Map of one robot.

    Parameters
    ----------
    newest
        Newest map with free cells.
    considered
        Version that was last aligned with other maps; None before the first time.
    version
        Number of versions that were considered.
    fault
        Why the newest message is no map; empty where it is one.
    """

    newest: OccupancyGrid
    considered: OccupancyGrid | None = None
    version: int = 0
    fault: str = ""

    def consider(self, params: LiveParams) -> bool:
        """Make the newest map the considered one if it differs enough; return whether it does."""
        if self.considered is self.newest:
            return False
        if self.considered is not None and changed_share(self.considered, self.newest) < params.growth:
            return False
        self.considered = self.newest
        self.version += 1
        return True

    def has_begun_anew(self, params: LiveParams) -> bool:
        """Return whether the newest map has lost so much that the robot must have started again."""
        return self.considered is not None and _area(self.newest) < params.min_share_left * _area(self.considered)


def changed_share(before: OccupancyGrid, now: OccupancyGrid) -> float:
    """Return the cells that differ between two versions of a map, as a share of the free cells of the first.

    Versions whose cells do not lie on each other differ in all of them: the share is at least 1.
    """
    corner = now.map_to_pixel(before.pixel_to_map([0.0, 0.0]))
    offset = np.rint(corner)
    is_same_lattice = before.cell_size == now.cell_size and before.origin[2] == now.origin[2]
    if not is_same_lattice or np.abs(corner - offset).max() > ON_THE_LATTICE:
        return 1.0
    old, new = _known(before), _known(now)
    u, v = int(offset[0]), int(offset[1])
    height, width = old.shape
    top, left = max(0, v), max(0, u)
    bottom, right = min(new.shape[0], v + height), min(new.shape[1], u + width)
    if bottom <= top or right <= left:
        return 1.0
    part_old, part_new = old[top - v : bottom - v, left - u : right - u], new[top:bottom, left:right]
    outside = np.count_nonzero(old) - np.count_nonzero(part_old) + np.count_nonzero(new) - np.count_nonzero(part_new)
    differing = int(np.count_nonzero(part_old != part_new)) + int(outside)
    return differing / max(1, int(np.count_nonzero(before.free)))


def _known(grid: OccupancyGrid) -> NDArray[np.int8]:
    """Return 0 for unknown, 1 for free and 2 for occupied cells."""
    return grid.free.astype(np.int8) + 2 * grid.occupied.astype(np.int8)


def _area(grid: OccupancyGrid) -> float:
    return float(np.count_nonzero(grid.free)) * grid.cell_size**2
