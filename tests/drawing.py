"""Buildings drawn by hand, and their views under a known placement: truth that no code under test has made.

``python -m tests.drawing`` rewrites the committed maps: building_b and building_c are parts of building_a.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity

DATA = Path(__file__).parent / "data"
B_IN_A = Similarity(1.2, 0.5, 70.0, 20.0)  # building_b's pixels on building_a

C_IN_A = Similarity(0.9, 2.6, 115.0, 55.0)  # building_c's pixels on building_a

# Rooms and doors of an asymmetric building in cells: x, y, w, h of free space; everything around it is wall.
ROOMS = ((12, 12, 60, 38), (75, 12, 45, 25), (123, 12, 28, 52), (12, 53, 34, 47), (49, 53, 71, 20), (75, 40, 45, 10))
MORE_ROOMS = ((49, 76, 40, 24), (92, 76, 59, 24), (123, 67, 28, 6))
DOORS = ((72, 20, 3, 8), (120, 18, 3, 7), (30, 50, 8, 3), (60, 50, 8, 3), (95, 37, 8, 3), (100, 50, 8, 3))
MORE_DOORS = ((46, 60, 3, 8), (60, 73, 8, 3), (89, 84, 3, 8), (130, 64, 8, 3), (130, 73, 8, 3))


def building(*, resolution: float | None = None, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> OccupancyGrid:
    """Draw a clean building of nine rooms, 113 x 163 cells, with walls of one to three cells."""
    free = np.zeros((113, 163), np.bool_)
    for x, y, w, h in (*ROOMS, *MORE_ROOMS, *DOORS, *MORE_DOORS):
        free[y : y + h, x : x + w] = True
    return grid_of(free, resolution=resolution, origin=origin)


def grid_of(
    free: NDArray[np.bool_], *, resolution: float | None = None, origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> OccupancyGrid:
    """Surround free space by a wall one cell thick; the rest is unknown."""
    padded = np.pad(free, 1)
    around = np.zeros_like(free)
    for row in range(3):
        for col in range(3):
            around |= padded[row : row + free.shape[0], col : col + free.shape[1]]
    occupancy = np.where(free, FREE, np.where(around, OCCUPIED, UNKNOWN)).astype(np.int8)
    return OccupancyGrid(occupancy, resolution, origin)


def view(
    a: OccupancyGrid, pixels: Similarity, shape: tuple[int, int], *, resolution: float | None = None
) -> OccupancyGrid:
    """Read A at the cells of a new map B of `shape`, where `pixels` takes B's pixels to A's."""
    v, u = np.mgrid[: shape[0], : shape[1]]
    at = np.rint(pixels.apply(np.stack([u, v], axis=-1))).astype(int)
    inside = (at >= 0).all(axis=-1) & (at[..., 0] < a.shape[1]) & (at[..., 1] < a.shape[0])
    read = a.occupancy[at[..., 1].clip(0, a.shape[0] - 1), at[..., 0].clip(0, a.shape[1] - 1)]
    return OccupancyGrid(np.where(inside, read, UNKNOWN).astype(np.int8), resolution)


def tilted(degrees: float) -> tuple[OccupancyGrid, Similarity]:
    """Draw the building turned, on a canvas of 210 x 210 cells, and return where its pixels are on the upright one."""
    turn = Similarity(1.0, math.radians(degrees))
    tx, ty = np.array([81.0, 56.0]) - turn.apply([104.5, 104.5])
    pixels = Similarity(1.0, turn.angle, float(tx), float(ty))
    return view(building(), pixels, (210, 210)), pixels


if __name__ == "__main__":
    from rectmerge.io.map_file import write_map

    drawn = building(resolution=0.05, origin=(-2.0, -1.5, 0.0))
    write_map(drawn, DATA / "building_a.yaml")
    write_map(view(drawn, B_IN_A, (90, 110), resolution=0.06), DATA / "building_b.yaml")
    write_map(view(drawn, C_IN_A, (120, 130), resolution=0.045), DATA / "building_c.yaml")
