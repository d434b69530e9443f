"""Floor plans drawn by rule, turned, rescaled and damaged, with the truth of what was done."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from tests import drawing

ROOMS = (  # x, y, w, h as fractions: a corridor, rooms on both sides, doors; no two alike
    (0.05, 0.44, 0.90, 0.11),
    (0.05, 0.08, 0.25, 0.35),
    (0.31, 0.18, 0.17, 0.25),
    (0.49, 0.05, 0.29, 0.38),
    (0.79, 0.22, 0.16, 0.21),
    (0.05, 0.56, 0.17, 0.24),
    (0.23, 0.56, 0.35, 0.36),
    (0.59, 0.56, 0.13, 0.20),
    (0.73, 0.56, 0.22, 0.29),
    (0.14, 0.42, 0.04, 0.03),
    (0.37, 0.42, 0.04, 0.03),
    (0.63, 0.42, 0.04, 0.03),
    (0.85, 0.42, 0.04, 0.03),
    (0.11, 0.54, 0.04, 0.03),
    (0.41, 0.54, 0.04, 0.03),
    (0.64, 0.54, 0.04, 0.03),
    (0.82, 0.54, 0.04, 0.03),
)


def floor_plan(height: int = 210, width: int = 300) -> OccupancyGrid:
    """Draw eight different rooms along a corridor: free space, walls of 2 cells, unknown outside."""
    free = np.zeros((height, width), np.uint8)
    for x, y, w, h in ROOMS:
        left, top = round(x * width), round(y * height)
        free[top : round((y + h) * height), left : round((x + w) * width)] = 1
    walls = cv2.dilate(free, np.ones((5, 5), np.uint8)) > free
    return OccupancyGrid(np.where(free > 0, FREE, np.where(walls, OCCUPIED, UNKNOWN)).astype(np.int8))


def stairs() -> NDArray[np.bool_]:
    """Draw free space of three blocks whose vertices make no parallel lines, the largest one open on two sides."""
    free = np.zeros((60, 60), np.bool_)
    for x, y, w, h in ((5, 22, 17, 8), (12, 31, 8, 8), (10, 23, 12, 12)):
        free[y : y + h, x : x + w] = True
    return free


def moved(grid: OccupancyGrid, degrees: float, scale: float = 1.0) -> tuple[OccupancyGrid, Similarity]:
    """Turn a map counter-clockwise to the eye and rescale it, nearest cell; also return its pixels -> new pixels."""
    height, width = grid.shape
    angle = -math.radians(degrees)
    cos, sin = abs(math.cos(angle)), abs(math.sin(angle))
    size = math.ceil(scale * (width * cos + height * sin)), math.ceil(scale * (width * sin + height * cos))
    linear = Similarity(scale, angle)
    u, v = linear.apply([(width - 1) / 2, (height - 1) / 2])
    truth = Similarity(scale, angle, (size[0] - 1) / 2 - float(u), (size[1] - 1) / 2 - float(v))
    return drawing.view(grid, truth.inverse(), size[::-1]), truth


def on_canvas(grid: OccupancyGrid, height: int, width: int) -> OccupancyGrid:
    """Cut or pad a map about its centre."""
    padded = np.pad(grid.occupancy, ((height, height), (width, width)), constant_values=UNKNOWN)
    top, left = ((have - want) // 2 for have, want in zip(padded.shape, (height, width), strict=True))
    return OccupancyGrid(padded[top : top + height, left : left + width])


def damaged(grid: OccupancyGrid, rng: np.random.Generator, *, salt: float = 0.01, flips: float = 0.04) -> OccupancyGrid:
    """Put salt into free space and flip cells beside walls."""
    cells = grid.occupancy.copy()
    cells[grid.free & (rng.random(cells.shape) < salt)] = OCCUPIED
    edge = cv2.morphologyEx(grid.free.view(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8)) > 0
    flipped: NDArray[np.bool_] = edge & (rng.random(cells.shape) < flips)
    cells[flipped] = np.where(grid.free[flipped], OCCUPIED, FREE)
    return OccupancyGrid(cells)


def placement_error(placement: Similarity, truth: Similarity, shape: tuple[int, int]) -> float:
    """RMSE of a placement over the corners of the image that it moves, in target pixels."""
    corners = np.array([[0, 0], [shape[1] - 1, 0], [0, shape[0] - 1], [shape[1] - 1, shape[0] - 1]], float)
    return float(np.sqrt(((placement.apply(corners) - truth.apply(corners)) ** 2).sum(axis=1).mean()))
