"""Pairs of drawn maps and their fits on the cells."""

import math

import numpy as np

from rectmerge.analysis.trinary_map import MapCells
from rectmerge.robust.params import Params
from rectmerge.robust.refinement import Fit, Surface, fit_surfaces
from rectmerge.similarity import Similarity
from tests.rectmerge.robust import plans

PARAMS = Params()
EXACT = PARAMS.exact


def nudged(
    similarity: Similarity, turn: float, grow: float, shift: tuple[float, float], about: np.ndarray
) -> Similarity:
    """Turn and grow about a point (of the source), then shift."""
    at = similarity.apply(about)
    linear = Similarity(math.exp(grow), turn)
    tx, ty = at - linear.apply(at) + shift
    return Similarity(linear.scale, linear.angle, float(tx), float(ty)) @ similarity


def views(
    noise: int = 0, *, seed: int = 0, walls: tuple[int, int] = (1, 1), scale: float = 1.25
) -> tuple[plans.PlanView, plans.PlanView]:
    rooms = plans.office(seed)
    a = plans.see(rooms, degrees=17, window=(-8, -8, 250, 236), wall_cells=walls[0], noise=noise, seed=1)
    b = plans.see(rooms, degrees=141, scale=scale, window=(60, -8, 248, 236), wall_cells=walls[1], noise=noise, seed=2)
    return a, b


def fitted(start: np.ndarray, a: plans.PlanView, b: plans.PlanView, bounds: tuple[float, float] = (0.5, 2.0)) -> Fit:
    surfaces = (
        Surface.from_cells(MapCells.from_values(a.grid.occupancy)),
        Surface.from_cells(MapCells.from_values(b.grid.occupancy)),
    )
    return fit_surfaces(start, *surfaces, bounds, EXACT, points=EXACT.surface_points)
