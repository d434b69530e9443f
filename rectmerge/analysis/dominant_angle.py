"""The dominant orientation of a map, from the projection profiles of its wall cells."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid

STEPS_DEG = (1.0, 0.25, 0.05)
MAX_WALL_CELLS = 20_000  # of larger maps an evenly spaced sample


def dominant_angle(grid: OccupancyGrid) -> float:
    """Find the direction of most walls, modulo a quarter turn.

    Parameters
    ----------
    grid
        The map.

    Returns
    -------
    float
        Radians in [0, pi/2), counter-clockwise to the eye from the image's horizontal, to 0.05 degrees. Turning the
        image clockwise by it makes the walls orthogonal.

    Raises
    ------
    InputError
        If the map has no wall: no free cell borders on an occupied or unknown one.

    Notes
    -----
    Wall cells (occupied next to free; where nothing is occupied, the outline of the free space) are projected on both
    axes of a turned frame. Walls along an axis pile up in few bins: the energy of the profiles, the sum of squared
    counts, is greatest there. Searched at 1, 0.25 and 0.05 degrees. This finds the one direction of a map as given, for
    the paper's method. `rectmerge.robust.directions.dominant_angles` lists several on the working grid of its search.
    """
    points = wall_points(grid)
    if len(points) == 0:
        raise InputError("the map has no wall: no free cell borders on an occupied or unknown one")
    points = points[:: -(-len(points) // MAX_WALL_CELLS)]
    points -= points.mean(axis=0)
    best, reach = 45.0, 45.0
    for step in STEPS_DEG:
        angles = best + step * np.arange(-math.ceil(reach / step), math.ceil(reach / step) + 1)
        best = float(angles[np.argmax([_energy(points, math.radians(angle)) for angle in angles])])
        reach = step
    return math.radians(best % 90.0) % (math.pi / 2)


def wall_points(grid: OccupancyGrid) -> NDArray[np.float64]:
    """Return wall cells, shape (N, 2), as (u, v) pixels: occupied ones next to free, else the free outline."""
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    near_free = cv2.dilate(grid.free.view(np.uint8), cross) > 0
    walls = grid.occupied & near_free
    if not walls.any():
        walls = ~grid.free & near_free
    return np.argwhere(walls)[:, ::-1].astype(np.float64)


def _energy(points: NDArray[np.float64], angle: float) -> float:
    """Sum the squared counts of both profiles in a frame turned counter-clockwise to the eye."""
    cos, sin = math.cos(angle), math.sin(angle)
    energy = 0.0
    for profile in (points @ (cos, -sin), points @ (sin, cos)):
        # counts shared between the two nearest bins: a profile must not depend on where bins begin
        low = np.floor(profile).astype(np.int64)
        share = profile - low
        low -= low.min()
        counts = np.bincount(low, 1 - share, low.max() + 2) + np.bincount(low + 1, share, low.max() + 2)
        energy += float(counts @ counts)
    return energy
