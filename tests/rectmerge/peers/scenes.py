"""The drawn building seen twice, the second time in other cells, turned and from elsewhere; and another building."""

from __future__ import annotations

import math

import numpy as np

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from tests import drawing


def upright() -> OccupancyGrid:
    """The building with unknown space around it."""
    return drawing.view(drawing.building(), Similarity(1.0, 0.0, -10.0, -20.0), (160, 190))


def turned(scale: float, degrees: float, size: int = 280) -> tuple[OccupancyGrid, Similarity]:
    """The building in cells `scale` as large, turned, and the pixel similarity to `upright`."""
    turn = Similarity(scale, math.radians(degrees))
    tx, ty = np.array([91.0, 76.0]) - turn.apply([size / 2, size / 2])
    truth = Similarity(scale, turn.angle, float(tx), float(ty))
    return drawing.view(upright(), truth, (size, size)), truth


def other() -> OccupancyGrid:
    """Another building: halls in a row."""
    free = np.zeros((150, 150), np.bool_)
    for x in range(8, 130, 24):
        free[20:110, x : x + 21] = True
        free[60 + x // 4 : 68 + x // 4, x : x + 24] = True
    return drawing.grid_of(free)


def farthest(found: Similarity, truth: Similarity, grid: OccupancyGrid) -> float:
    """The largest distance, in cells of A, between where two placements put the free cells of a grid."""
    points = np.argwhere(grid.free)[:, ::-1]
    return float(np.linalg.norm(found.apply(points) - truth.apply(points), axis=1).max())
