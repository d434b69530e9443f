"""Noise levels 0 to 3 of the cells, the same for every suite."""

from __future__ import annotations

import numpy as np

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from scenarios.corruption.cells import blobs, double_walls, salt, spurious_rays, wall_dropout, wall_edge_flips

NOISE_LEVELS = (0, 1, 2, 3)
SALT, EDGE_FLIPS, WALL_DROPOUT = 0.01, 0.04, 0.03  # shares at level 1; each further level doubles them
DOUBLE_WALLS, SPURIOUS_RAYS_PER_CELL, BLOBS_PER_CELL = 0.05, 1e-4, 3e-5  # at level 2, per known cell; level 3 doubles


def add_noise(grid: OccupancyGrid, level: int, rng: np.random.Generator) -> OccupancyGrid:
    """Corrupt the cells of a map by a noise level.

    Parameters
    ----------
    grid
        The map built from the scanner's readings.
    level
        0: untouched. 1: salt on 1 % of free cells, 4 % of the cells beside walls flipped, 3 % of wall cells lost.
        2: twice that, spurious rays, double walls on 5 % of the walls, blobs. 3: twice again.
    rng
        The same map, level and generator give the same cells.

    Raises
    ------
    InputError
        If there is no such level.
    """
    strength = noise_strength(level)
    if strength == 0:
        return grid
    if level >= 2:
        known = int((~grid.unknown).sum())
        grid = double_walls(grid, DOUBLE_WALLS * strength / 2, rng)
        grid = spurious_rays(grid, round(SPURIOUS_RAYS_PER_CELL * known * strength / 2), rng)
        grid = blobs(grid, round(BLOBS_PER_CELL * known * strength / 2), rng)
    grid = wall_dropout(grid, WALL_DROPOUT * strength, rng)
    grid = wall_edge_flips(grid, EDGE_FLIPS * strength, rng)
    return salt(grid, SALT * strength, rng)


def noise_strength(level: int) -> float:
    """Return 0, 1, 2, 4 for the noise levels 0 to 3, the factor of the shares of level 1 and of the scanner's noise.

    Raises
    ------
    InputError
        If there is no such level.
    """
    if level not in NOISE_LEVELS:
        raise InputError(f"noise must be one of {', '.join(map(str, NOISE_LEVELS))}, got {level!r}")
    return 0.0 if level == 0 else 2.0 ** (level - 1)
