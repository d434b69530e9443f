"""How accurate a map is in itself: specks, the thickness of its walls and how straight they run."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid

WINDOW_CELLS = 11  # walls are judged straight over this length
COHERENT = 0.8  # of the structure tensor: 1 along a line, about 0 at a corner or in a cloud of points


@dataclass(frozen=True, slots=True)
class MapQuality:
    """A map's own accuracy; a figure is None where the map has no walls to measure it on.

    Parameters
    ----------
    speckle
        Share of the known cells of which no neighbour (of eight) is of the same kind, 0..1. A clean map has 0.
    wall_thickness_cells
        Median thickness of the walls, in cells. A scanner's noise and double walls make it grow.
    straightness
        Share of the wall cells around which, over 11 cells, the walls run along one line, 0..1. Corners, ends and
        doors count as not straight: large rooms drawn clean have about 0.9, small ones 0.4, a cloud of points 0.
    """

    speckle: float
    wall_thickness_cells: float | None
    straightness: float | None

    def as_dict(self) -> dict[str, float]:
        """Return the figures that could be measured, by name."""
        return {name: value for name, value in dataclasses.asdict(self).items() if value is not None}


def measure_quality(grid: OccupancyGrid) -> MapQuality:
    """Measure a map's own accuracy from its cells; nothing else is known of it.

    Examples
    --------
    >>> occupancy = np.zeros((40, 40), np.int8)
    >>> occupancy[10:13] = 100
    >>> measure_quality(OccupancyGrid(occupancy)).as_dict()
    {'speckle': 0.0, 'wall_thickness_cells': 3.0, 'straightness': 0.8}
    """
    free, occupied = grid.free, grid.occupied
    isolated_free, isolated_walls = _isolated(free), _isolated(occupied)
    known = int(free.sum() + occupied.sum())
    walls = _cropped(occupied & ~isolated_walls)
    has_walls = bool(walls.any())
    return MapQuality(
        speckle=float(isolated_free.sum() + isolated_walls.sum()) / max(1, known),
        wall_thickness_cells=_thickness(walls) if has_walls else None,
        straightness=_straightness(walls) if has_walls else None,
    )


def _isolated(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    ring = np.ones((3, 3), np.uint8)
    ring[1, 1] = 0
    neighbours = cv2.dilate(mask.view(np.uint8), ring, borderType=cv2.BORDER_CONSTANT, borderValue=0)
    isolated: NDArray[np.bool_] = mask & (neighbours == 0)
    return isolated


def _cropped(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cut a mask to its content: most of a map's canvas has no walls."""
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return mask[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1] if len(rows) else mask[:0, :0]


def _thickness(walls: NDArray[np.bool_]) -> float:
    """Median thickness along the ridges of the distance to the walls' edges, at half cells so that even widths show."""
    halves = np.pad(walls.view(np.uint8).repeat(2, axis=0).repeat(2, axis=1), 1)
    distance = cv2.distanceTransform(halves, cv2.DIST_L2, cv2.DIST_MASK_5)  # w on the ridge of a wall w cells thick
    ridge = (halves > 0) & (distance >= cv2.dilate(distance, np.ones((3, 3), np.uint8)))
    return float(np.median(distance[ridge]))


def _straightness(walls: NDArray[np.bool_]) -> float:
    padded = np.pad(walls.astype(np.float32), WINDOW_CELLS)
    soft = cv2.GaussianBlur(padded, (0, 0), 1.0)
    dx, dy = cv2.Sobel(soft, cv2.CV_32F, 1, 0), cv2.Sobel(soft, cv2.CV_32F, 0, 1)
    xx, yy, xy = (cv2.blur(p, (WINDOW_CELLS, WINDOW_CELLS)) for p in (dx * dx, dy * dy, dx * dy))
    at_walls = padded > 0
    xx, yy, xy = xx[at_walls], yy[at_walls], xy[at_walls]  # (N,)
    coherence = np.hypot(xx - yy, 2 * xy) / np.maximum(xx + yy, 1e-9)
    return float((coherence >= COHERENT).mean())
