"""Maps that grow: a drawn building that becomes known from the left to the right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rectmerge.grid import UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from tests import drawing

A = drawing.building(resolution=0.05, origin=(-2.0, -1.5, 0.0))
B_IN_A = Similarity(1.0, 0.5, 65.0, -18.0)  # B's pixels on A's
B = drawing.view(A, B_IN_A, (120, 130), resolution=0.05)
SHARES = (0.2, 0.7, 0.85, 1.0)


def known_part(grid: OccupancyGrid, share: float) -> OccupancyGrid:
    """Return a map of which only the left share of the known columns is known."""
    columns = np.flatnonzero((grid.occupancy != UNKNOWN).any(axis=0))
    end = columns[0] + round(share * (columns[-1] - columns[0] + 1))
    occupancy = grid.occupancy.copy()
    occupancy[:, end:] = UNKNOWN
    return replace(grid, occupancy=occupancy)


def growing(grid: OccupancyGrid, shares: tuple[float, ...] = SHARES) -> list[OccupancyGrid]:
    """Return versions of a map, each larger than the one before."""
    return [known_part(grid, share) for share in shares]
