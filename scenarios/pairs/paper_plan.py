"""Two maps of a simple environment like that of the paper's figure 2, turned and of different scale."""

from __future__ import annotations

import cv2
import numpy as np

from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.pairs.random_rescale import turn_and_rescale

PLAN_CELLS = (96, 132)  # (H, W)
SPACES = (  # x, y, w, h in cells: rooms, then doors
    (8, 8, 52, 34),
    (66, 8, 30, 22),
    (8, 48, 26, 40),
    (40, 48, 56, 18),
    (102, 8, 22, 60),
    (60, 18, 6, 8),
    (96, 14, 6, 8),
    (16, 42, 8, 6),
    (48, 42, 8, 6),
    (34, 54, 6, 8),
    (96, 52, 6, 8),
    (70, 66, 8, 6),
)
NOOK = ((44, 72), (94, 72), (94, 88))  # a triangular space: corners (x, y)
TURNS_DEG = (27.0, 225.0)  # of maps A and B, counter-clockwise: the paper's
RATIO = 1.1429  # map A is so many times larger: the paper's


def simple_maps() -> tuple[OccupancyGrid, OccupancyGrid, Similarity]:
    """Draw maps A and B of the simple environment; return them with the true similarity from B's pixels to A's."""
    plan = _draw_plan()
    a, to_a = turn_and_rescale(plan, TURNS_DEG[0], 1.0)
    b, to_b = turn_and_rescale(plan, TURNS_DEG[1], 1.0 / RATIO)
    return a, b, to_a @ to_b.inverse()


def _draw_plan() -> OccupancyGrid:
    free = np.zeros(PLAN_CELLS, np.uint8)
    for x, y, w, h in SPACES:
        free[y : y + h, x : x + w] = 1
    cv2.fillPoly(free, [np.array(NOOK)], (1,))
    walls = cv2.dilate(free, np.ones((5, 5), np.uint8)) > free
    return OccupancyGrid(np.where(free > 0, FREE, np.where(walls, OCCUPIED, UNKNOWN)).astype(np.int8))
