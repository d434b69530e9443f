"""Wall agreement of two images under a placement, which verifies a hypothesis of the repaired method."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.dominant_angle import wall_points
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True, eq=False)
class WallImage:
    """Walls of an image, prepared for the comparison with another.

    Parameters
    ----------
    walls
        Wall cells (u, v), shape (N, 2).
    distance
        Distance of each cell to the nearest occupied one, shape (H, W), in cells.
    is_free
        Mask of free cells, shape (H, W).
    """

    walls: NDArray[np.float64]
    distance: NDArray[np.float32]
    is_free: NDArray[np.bool_]

    @classmethod
    def from_cells(cls, cells: NDArray[np.int8], *, max_walls: int) -> WallImage:
        """Prepare an image, with about `max_walls` evenly spaced wall cells of it."""
        grid = OccupancyGrid(cells)
        walls = wall_points(grid)
        distance = cv2.distanceTransform((~grid.occupied).view(np.uint8), cv2.DIST_L2, 3)
        return cls(walls[:: -(-len(walls) // max_walls) or 1], np.asarray(distance, np.float32), grid.free)

    def agreement_on(self, other: WallImage, pixels: Similarity, reach_cells: float) -> float:
        """Return the share of walls within `reach_cells` of the other's walls, less the share in its open space."""
        u, v = np.rint(pixels.apply(self.walls)).astype(np.intp).T
        height, width = other.distance.shape
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        cells = v[inside], u[inside]
        is_near = other.distance[cells] <= reach_cells
        balance = np.count_nonzero(is_near) - np.count_nonzero(~is_near & other.is_free[cells])
        return float(balance) / max(1, len(self.walls))


def wall_agreement(a: WallImage, b: WallImage, pixels: Similarity, *, reach_cells: float) -> float:
    """Return the agreement of walls both ways, from -2 to 2; `pixels` takes pixels of B to pixels of A.

    Examples
    --------
    >>> room = WallImage.from_cells(np.pad(np.zeros((8, 9), np.int8), 1, constant_values=100), max_walls=99)
    >>> wall_agreement(room, room, Similarity(), reach_cells=1)
    2.0
    """
    return b.agreement_on(a, pixels, reach_cells) + a.agreement_on(b, pixels.inverse(), reach_cells)
