"""Witness of walls: what the walls of two maps say of one placement, without a search."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from rectmerge.fleet.complex_similarity import ComplexSimilarity
from rectmerge.grid import OccupancyGrid
from rectmerge.robust.params import Params
from rectmerge.robust.prepared_map import PreparedMap
from rectmerge.robust.ranking import rank
from rectmerge.robust.refinement import to_working
from rectmerge.robust.working_pair import WorkingPair

SCALE_SLACK = 1.05  # by which the refinement of a placement may change its scale, either way


class WallWitness:
    """Walls of some maps, which are prepared when they are first asked for.

    Parameters
    ----------
    grids
        The maps.
    """

    def __init__(self, grids: Sequence[OccupancyGrid]) -> None:
        self._grids = grids
        self._prepared: dict[int, PreparedMap] = {}

    def log_odds(self, pair: tuple[int, int], placement: ComplexSimilarity) -> float:
        """Return the log-odds that a placement of a pair's second map on its first is right, were there no other.

        It is the plausibility of `rectmerge.robust`, to which walls on solid floor of the other map count against a
        placement, whatever method it comes from. Minus infinity where a map has no walls.
        """
        fixed, moving = (self._map(index) for index in pair)
        if fixed.features is None or moving.features is None:
            return -math.inf
        scale = placement.scale
        bounds = scale / SCALE_SLACK, scale * SCALE_SLACK
        working = WorkingPair.from_maps(fixed, moving, bounds, np.random.default_rng(0), fixed.params)
        return rank(working, to_working(placement.to_similarity(), working.a, working.b)[None]).best

    def _map(self, index: int) -> PreparedMap:
        if index not in self._prepared:
            self._prepared[index] = PreparedMap.from_grid(self._grids[index], Params())
        return self._prepared[index]
