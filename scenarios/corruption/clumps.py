"""Corruptions that come in clumps and near walls, as those that robots leave in their maps."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

# source of all: maps of `real_places` and `real_lasers`, looked at; the strengths, which are fitted, are arguments
WALL_PATCH_CELLS, FLOOR_PATCH_CELLS = 3.0, 6.0  # standard deviations of the smooth fields that place patches
WITHIN_PATCHES = 0.5  # share of the cells of a patch that change
NEAR_WALLS = 0.9  # share of the clumps of specks, and of the clutter, whose middle lies near a wall
NEAR_CELLS, CLUMP_CELLS = 3.0, 3.0  # standard deviations: of a middle from its wall, and of a speck from its middle
SPECKS_PER_CLUMP = 2.0
MAX_LEG_CELLS = 4  # of the leg of a chair or a table
CLUTTER_CELLS = (1.2, 3.2)  # least and longest half axis of a piece of clutter

Mask = NDArray[np.bool_]


def thick_walls(grid: OccupancyGrid, share: float, rng: np.random.Generator) -> OccupancyGrid:
    """Turn a share of the cells that touch walls to occupied, in patches along the walls."""
    beside = _dilated(grid.occupied) & ~grid.occupied
    return _with(grid, _patches(beside, share, WALL_PATCH_CELLS, rng), OCCUPIED)


def broken_walls(grid: OccupancyGrid, share: float, rng: np.random.Generator) -> OccupancyGrid:
    """Turn a share of the occupied cells to unknown, in patches along the walls."""
    return _with(grid, _patches(grid.occupied, share, WALL_PATCH_CELLS, rng), UNKNOWN)


def pinholes(grid: OccupancyGrid, share: float, rng: np.random.Generator) -> OccupancyGrid:
    """Turn a share of the free cells to unknown, in patches of the floor."""
    return _with(grid, _patches(grid.free, share, FLOOR_PATCH_CELLS, rng), UNKNOWN)


def dense_scans(grid: OccupancyGrid, share: float, rng: np.random.Generator) -> OccupancyGrid:
    """Fill a share of the gaps of one or two unknown cells between rays, in patches, as further scans would."""
    gaps = cv2.morphologyEx(grid.free.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)).astype(np.bool_)
    return _with(grid, _patches(gaps & grid.unknown, share, FLOOR_PATCH_CELLS, rng, within=1.0), FREE)


def erased_legs(grid: OccupancyGrid, share: float, rng: np.random.Generator) -> OccupancyGrid:
    """Free a share of the occupied patches of at most four cells: legs that were missed, of chairs that were moved."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(grid.occupied.astype(np.uint8), connectivity=8)
    is_erased = (stats[:, cv2.CC_STAT_AREA] <= MAX_LEG_CELLS) & (rng.random(len(stats)) < share)
    is_erased[0] = False  # what is not occupied
    return _with(grid, is_erased[labels], FREE)


def speck_clumps(grid: OccupancyGrid, per_100_free: float, rng: np.random.Generator) -> OccupancyGrid:
    """Put specks of one to three cells on free cells, in clumps, most of them near walls.

    Parameters
    ----------
    grid
        The map.
    per_100_free
        Specks per 100 free cells, fewer in the end: some would touch a wall and are left out, some touch each other.
    rng
        Randomness of their places and shapes.
    """
    clumps = rng.poisson(per_100_free * int(grid.free.sum()) / 100 / SPECKS_PER_CLUMP)
    middles = _middles(grid, int(clumps), rng)
    places = np.repeat(middles, rng.geometric(1 / SPECKS_PER_CLUMP, len(middles)), axis=0)
    places = np.rint(places + rng.normal(0.0, CLUMP_CELLS, places.shape)).astype(int)
    further = places + rng.integers(-1, 2, places.shape)  # the cell itself, too: specks of one cell
    mark = np.zeros(grid.shape, np.bool_)
    for cells in (places, further):
        inside = ((cells >= 0) & (cells < grid.shape)).all(axis=1)
        mark[tuple(cells[inside].T)] = True
    return _with(grid, mark & grid.free & ~_dilated(grid.occupied), OCCUPIED)


def clutter(grid: OccupancyGrid, per_10_000_free: float, rng: np.random.Generator) -> OccupancyGrid:
    """Put ragged patches of 4 to 30 cells on the floor, most of them near walls: bags, bins, shoes, feet of furniture.

    Parameters
    ----------
    grid
        The map.
    per_10_000_free
        Patches per 10,000 free cells.
    rng
        Randomness of their places and shapes.
    """
    count = int(rng.poisson(per_10_000_free * int(grid.free.sum()) / 10_000))
    drawn = np.zeros(grid.shape, np.uint8)
    for row, col in np.rint(_middles(grid, count, rng)).astype(int).tolist():
        axes = np.rint(rng.uniform(*CLUTTER_CELLS, 2)).astype(int).tolist()
        cv2.ellipse(drawn, (col, row), axes, float(rng.uniform(0, 180)), 0, 360, 1, -1)
    ragged = drawn.astype(np.bool_) & (rng.random(grid.shape) < 0.85)
    return _with(grid, ragged & grid.free, OCCUPIED)


def _middles(grid: OccupancyGrid, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw middles of clumps, (N, 2), (row, col): most near walls, the rest anywhere on the floor."""
    floor, walls = np.argwhere(grid.free), np.argwhere(grid.occupied)
    if not len(floor):
        return np.zeros((0, 2))
    near = int(rng.binomial(count, NEAR_WALLS)) if len(walls) else 0
    by_walls = walls[rng.integers(len(walls), size=near)] if near else np.zeros((0, 2))
    by_walls = by_walls + rng.normal(0.0, NEAR_CELLS, by_walls.shape)
    return np.concatenate([by_walls, floor[rng.integers(len(floor), size=count - near)]])


def _patches(
    mask: Mask, share: float, cells: float, rng: np.random.Generator, *, within: float = WITHIN_PATCHES
) -> Mask:
    """Choose about a share of a mask, cell by cell within the patches where a smooth random field is highest."""
    field = cv2.GaussianBlur(rng.standard_normal(mask.shape).astype(np.float32), (0, 0), cells)
    share = min(1.0, max(0.0, share))
    within = max(within, share)
    chosen: Mask = mask & (rng.random(mask.shape) < within)
    if share < within and mask.any():
        chosen &= field > np.quantile(field[mask], 1 - share / within)
    return chosen


def _dilated(mask: Mask) -> Mask:
    return cv2.dilate(mask.view(np.uint8), np.ones((3, 3), np.uint8)).astype(np.bool_)


def _with(grid: OccupancyGrid, mask: Mask, value: int) -> OccupancyGrid:
    return OccupancyGrid(np.where(mask, value, grid.occupancy).astype(np.int8), grid.resolution, grid.origin)
