"""Displacement of a map between two placements of it, and the tolerance of a placement by hand."""

from __future__ import annotations

import numpy as np

from rectmerge.analysis.overlap import cells_of
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

SAMPLED_CELLS = 2000
HAND_TOLERANCE = 0.1  # of the RMS radius of B's free space
MIN_HAND_TOLERANCE_CELLS = 5.0


def displacement_cells(b: OccupancyGrid, placement: Similarity, other: Similarity) -> float:
    """Return the RMS distance, in A's cells, between two placements of B's free space."""
    cells = cells_of(b.free, SAMPLED_CELLS)[:, ::-1]
    return float(np.sqrt(((placement.apply(cells) - other.apply(cells)) ** 2).sum(axis=1).mean()))


def hand_tolerance_cells(b: OccupancyGrid, placement: Similarity) -> float:
    """Return the displacement, in A's cells, within which a placement by hand counts as the given one."""
    cells = cells_of(b.free, SAMPLED_CELLS)
    radius = float(np.sqrt(((cells - cells.mean(axis=0)) ** 2).sum(axis=1).mean()))
    return max(MIN_HAND_TOLERANCE_CELLS, HAND_TOLERANCE * radius * placement.scale)
