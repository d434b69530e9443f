"""Easy pairs for every method: views of one clean drawn building, with exact truth."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.pairs.pair import MapPair
from scenarios.pairs.random_rescale import turn_and_rescale

Window = tuple[int, int, int, int]  # x, y, w, h in cells of the plan
PLAN_CELLS = (164, 236)  # (H, W)
ROOMS: tuple[Window, ...] = (
    (8, 8, 74, 46),
    (85, 8, 50, 30),
    (138, 8, 40, 64),
    (181, 8, 47, 38),
    (8, 57, 38, 60),
    (49, 57, 86, 22),
    (85, 41, 50, 13),
    (181, 49, 47, 70),
    (49, 82, 52, 35),
    (104, 82, 74, 35),
    (138, 75, 40, 4),
    (8, 120, 94, 36),
    (105, 120, 44, 36),
    (152, 122, 76, 22),
)
DOORS: tuple[Window, ...] = (
    (82, 20, 3, 9),
    (135, 18, 3, 8),
    (178, 22, 3, 9),
    (24, 54, 9, 3),
    (64, 54, 9, 3),
    (100, 38, 9, 3),
    (118, 54, 9, 3),
    (200, 46, 9, 3),
    (46, 64, 3, 9),
    (66, 79, 9, 3),
    (101, 96, 3, 9),
    (150, 72, 9, 3),
    (160, 79, 9, 3),
    (178, 100, 3, 9),
    (20, 117, 9, 3),
    (120, 117, 9, 3),
    (102, 134, 3, 9),
    (149, 128, 3, 9),
    (205, 119, 9, 3),
)
WHOLE: Window = (0, 0, PLAN_CELLS[1], PLAN_CELLS[0])
PLAN_CELL_M = 0.05
MOST_CONTROL_POINTS = 400


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """View of the plan in one map.

    Parameters
    ----------
    window
        The part of the plan that the map shows.
    turn_deg
        Degrees, counter-clockwise to the eye.
    factor
        Cells of the map per cell of the plan.
    origin
        (x, y) of the map's lower-left corner, metres; None where the map has no resolution.
    """

    window: Window = WHOLE
    turn_deg: float = 0.0
    factor: float = 1.0
    origin: tuple[float, float] | None = None

    def draw(self, plan: OccupancyGrid) -> tuple[OccupancyGrid, Similarity]:
        """Draw the map; return it with the similarity that takes pixels of the plan to its own."""
        x, y, w, h = self.window
        part = OccupancyGrid(plan.occupancy[y : y + h, x : x + w])
        drawn, turned = turn_and_rescale(part, self.turn_deg, self.factor)
        if self.origin is not None:
            drawn = OccupancyGrid(drawn.occupancy, PLAN_CELL_M / self.factor, (*self.origin, 0.0))
        return drawn, turned @ Similarity(1.0, 0.0, -float(x), -float(y))


LEFT, RIGHT, MIDDLE = (0, 0, 180, 164), (46, 0, 190, 164), (40, 0, 140, 120)
VIEWS: dict[str, tuple[View, View]] = {
    "shifted": (View(window=LEFT, origin=(0.0, 0.0)), View(window=RIGHT, origin=(0.0, 0.0))),
    "turned": (View(window=LEFT), View(window=RIGHT, turn_deg=35.0)),
    "rescaled": (View(window=RIGHT), View(window=LEFT, factor=0.7)),
    "turned and rescaled": (
        View(turn_deg=20.0, origin=(0.0, 0.0)),
        View(window=LEFT, turn_deg=-142.0, factor=0.75, origin=(0.0, 0.0)),
    ),
    "B larger than A": (
        View(window=MIDDLE, origin=(-10.0, -5.0)),
        View(turn_deg=-70.0, factor=1.3, origin=(-1.0, -2.0)),
    ),
    "other origins": (
        View(window=LEFT, turn_deg=38.0, origin=(-3.0, 2.0)),
        View(window=RIGHT, turn_deg=158.0, factor=0.8, origin=(5.0, -7.0)),
    ),
}


@functools.cache
def easy_pairs() -> tuple[MapPair, ...]:
    """Draw the pairs of `VIEWS`; every method should accept each of them, and rightly."""
    plan = draw_plan()
    return tuple(_pair(name, plan, *views) for name, views in VIEWS.items())


def draw_plan() -> OccupancyGrid:
    """Draw a building of fourteen rooms without symmetry, with walls of two cells or three."""
    free = np.zeros(PLAN_CELLS, np.bool_)
    for x, y, w, h in (*ROOMS, *DOORS):
        free[y : y + h, x : x + w] = True
    around = cv2.dilate(free.view(np.uint8), np.ones((5, 5), np.uint8)) > 0
    return OccupancyGrid(np.where(free, FREE, np.where(around, OCCUPIED, UNKNOWN)).astype(np.int8))


def _pair(name: str, plan: OccupancyGrid, view_a: View, view_b: View) -> MapPair:
    (a, to_a), (b, to_b) = view_a.draw(plan), view_b.draw(plan)
    walls = _common_walls(plan, view_a.window, view_b.window)
    truth = to_a @ to_b.inverse()
    return MapPair(
        pair_id=name,
        a=a,
        b=b,
        related=True,
        pixels=truth,
        control_points=np.hstack([to_a.apply(walls), to_b.apply(walls)]),
        residual_px=0.0,
        suite="easy",
        place="plan",
        overlap=measure_agreement(a, b, truth).overlap,
    )


def _common_walls(plan: OccupancyGrid, *windows: Window) -> NDArray[np.float64]:
    """Return wall cells of the plan that lie in all windows, as (u, v) pixels, shape (N, 2), evenly chosen."""
    points = np.argwhere(plan.occupied)[:, ::-1].astype(np.float64)
    for x, y, w, h in windows:
        points = points[((points >= (x, y)) & (points < (x + w, y + h))).all(axis=1)]
    return points[:: -(-len(points) // MOST_CONTROL_POINTS)]
