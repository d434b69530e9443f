"""Even noise of cells in three strengths, `cells-1` to `cells-3`: the noise of the suite `headline`.

Salt lies evenly on the floor, unlike the specks of real maps: a property of these levels, which results of versions
before 0.2 rest on. `scenarios.corruption.noise_levels` has the levels that are fitted to real maps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from scenarios.corruption.cells import blobs, double_walls, salt, spurious_rays, wall_dropout, wall_edge_flips
from sim.missions.mission_log import RobotLog
from sim.sensors.lidar import Lidar

SALT, EDGE_FLIPS, WALL_DROPOUT = 0.01, 0.04, 0.03  # shares at strength 1
DOUBLE_WALLS, SPURIOUS_RAYS_PER_CELL, BLOBS_PER_CELL = 0.05, 1e-4, 3e-5  # at strength 2, per known cell; less has none


@dataclass(frozen=True, slots=True)
class CellNoise:
    """Even noise of the cells, on top of the scanner's.

    Parameters
    ----------
    strength
        Factor of the scanner's noise. 0: exact ranges and cells. 1: salt on 1 % of the free cells, 4 % of the cells
        beside walls flipped, 3 % of the wall cells lost. 2: twice that, spurious rays, double walls on 5 % of the
        walls, blobs. 4: twice again.
    """

    strength: float

    def of_one_map(self, _: np.random.Generator) -> CellNoise:
        """Return the noise itself: all maps have the same."""
        return self

    def read_out(self, log: RobotLog, lidar: Lidar, rng: np.random.Generator) -> NDArray[np.float64]:
        """Report the ranges of a log, shape (S, B), metres: inf where nothing is in reach, nan where lost."""
        if self.strength == 0:
            return lidar.limit(log.ranges)
        return lidar.observe(log.ranges, log.glass, rng, level=self.strength)

    def least_evidence(self, hit: float, miss: float) -> float:
        """Return the log-odds up to which a cell stays unknown: none."""
        return 0.0

    def add(self, grid: OccupancyGrid, rng: np.random.Generator) -> OccupancyGrid:
        """Corrupt the cells of a map; the same map and generator give the same cells."""
        strength = self.strength
        if strength == 0:
            return grid
        if strength >= 2:
            known = int((~grid.unknown).sum())
            grid = double_walls(grid, DOUBLE_WALLS * strength / 2, rng)
            grid = spurious_rays(grid, round(SPURIOUS_RAYS_PER_CELL * known * strength / 2), rng)
            grid = blobs(grid, round(BLOBS_PER_CELL * known * strength / 2), rng)
        grid = wall_dropout(grid, WALL_DROPOUT * strength, rng)
        grid = wall_edge_flips(grid, EDGE_FLIPS * strength, rng)
        return salt(grid, SALT * strength, rng)
