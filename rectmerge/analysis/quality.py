"""Accuracy of a map in itself: specks, and the thickness and straightness of its walls."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.wall_quality import coherence_at, thickness_at
from rectmerge.analysis.overlap import cells_of
from rectmerge.grid import OccupancyGrid

# source of the three: hand, no data
REACH_CELLS = 5  # half the side of the square in which straightness is measured
SAMPLED_CELLS = 300  # evenly spaced wall cells, on which thickness and straightness are measured; trades time
COHERENT = 0.8  # least coherence of a straight wall: 1 along a line, about 0 at a corner or in a cloud of points


@dataclass(frozen=True, slots=True)
class MapQuality:
    """Accuracy of one map; a figure is None where the map has no walls to measure it on.

    Parameters
    ----------
    speckle
        Share of the known cells without a neighbour (of eight) of the same value, 0..1. A clean map has 0.
    wall_thickness_cells
        Median thickness of the walls, in cells. A scanner's noise and double walls increase it.
    straightness
        Share of the wall cells around which, over 11 cells, the walls run along one line, 0..1. Corners, ends and
        doors count as not straight: clean large rooms have about 0.9, small ones 0.4, a cloud of points 0.
    """

    speckle: float
    wall_thickness_cells: float | None
    straightness: float | None

    def as_dict(self) -> dict[str, float]:
        """Return the measured figures, by name."""
        return {name: value for name, value in dataclasses.asdict(self).items() if value is not None}


def measure_quality(grid: OccupancyGrid) -> MapQuality:
    """Measure the accuracy of a map from its cells alone.

    Examples
    --------
    >>> occupancy = np.zeros((40, 40), np.int8)
    >>> occupancy[10:13] = 100
    >>> measure_quality(OccupancyGrid(occupancy)).as_dict()
    {'speckle': 0.0, 'wall_thickness_cells': 3.0, 'straightness': 0.8}
    """
    free, occupied = grid.free, grid.occupied
    known = int(np.count_nonzero(free)) + int(np.count_nonzero(occupied))
    lone_free, lone_walls = _alone(free), _alone(occupied)
    walls = occupied & ~lone_walls
    cells = cells_of(walls, SAMPLED_CELLS)
    return MapQuality(
        speckle=int(np.count_nonzero(lone_free) + np.count_nonzero(lone_walls)) / max(1, known),
        wall_thickness_cells=float(np.median(thickness_at(walls, cells))) if len(cells) else None,
        straightness=float((coherence_at(walls, cells, REACH_CELLS) >= COHERENT).mean()) if len(cells) else None,
    )


def _alone(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mark the cells of a mask without a neighbour in it, corners included."""
    around = cv2.boxFilter(mask.view(np.uint8), -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
    alone: NDArray[np.bool_] = mask & (around == 1)
    return alone
