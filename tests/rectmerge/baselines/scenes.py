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


TRUTH = Similarity(1 / 1.3, 0.7, 75.0, -35.0)  # the view's pixels on the building, all of which it shows


def view() -> OccupancyGrid:
    """The building alone in cells 1 / 1.3 as large, turned."""
    return drawing.view(drawing.building(), TRUTH, (250, 260))


def corners_apart(pixels: Similarity, truth: Similarity) -> float:
    """The largest distance in cells of A between where two placements put the corners of the view's building."""
    corners = [[40, 40], [220, 40], [40, 210], [220, 210]]
    return float(np.hypot(*(pixels.apply(corners) - truth.apply(corners)).T).max())


def long_halls() -> OccupancyGrid:
    """Another building: three long halls one beside another."""
    free = np.zeros((120, 150), np.bool_)
    for x, y, w, h in ((5, 5, 30, 110), (38, 5, 60, 50), (101, 5, 44, 110), (35, 20, 3, 10), (98, 20, 3, 10)):
        free[y : y + h, x : x + w] = True
    return drawing.grid_of(free)


def other() -> OccupancyGrid:
    """Another building: halls in a row."""
    free = np.zeros((150, 150), np.bool_)
    for x in range(8, 130, 24):
        free[20:110, x : x + 21] = True
        free[60 + x // 4 : 68 + x // 4, x : x + 24] = True
    return drawing.grid_of(free)


def farthest(pixels: Similarity, truth: Similarity, grid: OccupancyGrid) -> float:
    """The largest distance, in cells of A, between where two placements put the free cells of a grid."""
    points = np.argwhere(grid.free)[:, ::-1]
    return float(np.linalg.norm(pixels.apply(points) - truth.apply(points), axis=1).max())
