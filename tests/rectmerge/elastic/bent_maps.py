"""Maps bent on purpose: a smooth displacement of known size, and the map that it makes of a building."""

from __future__ import annotations

import numpy as np

from rectmerge.elastic.lattice import Displacement, Lattice
from rectmerge.grid import UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from tests.drawing import building

ENLARGED = 4  # of the building, so that its rooms are some hundred cells wide as in maps


def large_building() -> OccupancyGrid:
    """Draw the building of `tests.drawing` with cells a quarter as large, 452 x 652 cells."""
    return OccupancyGrid(np.kron(building().occupancy, np.ones((ENLARGED, ENLARGED), np.int8)))


def random_displacement(seed: int, shape: tuple[int, int], *, spacing: float, size: float) -> Displacement:
    """Draw a smooth displacement over a map of a shape, with coefficients of a standard deviation, in cells."""
    height, width = shape
    lattice = Lattice.over(np.array([-0.5, -0.5]), np.array([width - 0.5, height - 0.5]), spacing)
    coefficients = np.random.default_rng(seed).normal(0, size, (lattice.node_count, 2))
    return Displacement(lattice, coefficients)


def bent_view(a: OccupancyGrid, pixels: Similarity, bend: Displacement, shape: tuple[int, int]) -> OccupancyGrid:
    """Read A at the cells of a new map B: B's pixel p shows A at ``S p + u(S p)``."""
    v, u = np.mgrid[: shape[0], : shape[1]]
    at = np.rint(bend.apply(pixels.apply(np.stack([u, v], axis=-1)))).astype(int)
    inside = (at >= 0).all(axis=-1) & (at[..., 0] < a.shape[1]) & (at[..., 1] < a.shape[0])
    read = a.occupancy[at[..., 1].clip(0, a.shape[0] - 1), at[..., 0].clip(0, a.shape[1] - 1)]
    return OccupancyGrid(np.where(inside, read, UNKNOWN).astype(np.int8))
