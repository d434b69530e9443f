"""Corruptions that change cells and move no point."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.exact_distance import exact_distance
from rectmerge.errors import InputError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

PATCH_CELLS = 24  # double walls come in patches of about this size


def salt(grid: OccupancyGrid, share: float, rng: np.random.Generator) -> OccupancyGrid:
    """Turn a share of the free cells, chosen one by one, to occupied."""
    return _with_values(grid, _random_subset(grid.free, share, rng), OCCUPIED)


def wall_dropout(grid: OccupancyGrid, share: float, rng: np.random.Generator) -> OccupancyGrid:
    """Turn a share of the occupied cells, chosen one by one, to unknown."""
    return _with_values(grid, _random_subset(grid.occupied, share, rng), UNKNOWN)


def wall_edge_flips(grid: OccupancyGrid, share: float, rng: np.random.Generator) -> OccupancyGrid:
    """Flip a share of the cells where free space and walls touch: free to occupied and occupied to free."""
    near_free, near_wall = _dilated(grid.free), _dilated(grid.occupied)
    flipped = _random_subset((grid.free & near_wall) | (grid.occupied & near_free), share, rng)
    return _with_values(grid, flipped, np.where(grid.free, OCCUPIED, FREE))


def double_walls(grid: OccupancyGrid, share: float, rng: np.random.Generator) -> OccupancyGrid:
    """Draw a share of the walls, in patches, a second time, two to four cells aside, as a misplaced scan causes."""
    _check_share(share)
    walls = np.argwhere(grid.occupied)  # (N, 2)
    cells = grid.occupancy.copy()
    drawn, wanted = 0, share * len(walls)
    while drawn < wanted:
        near = np.abs(walls - walls[rng.integers(len(walls))]).max(axis=1) <= PATCH_CELLS // 2
        angle, reach = rng.uniform(0, 2 * np.pi), rng.uniform(2, 4)
        ghost = walls[near] + np.rint([reach * np.sin(angle), reach * np.cos(angle)]).astype(int)
        inside = ((ghost >= 0) & (ghost < grid.shape)).all(axis=1)
        cells[tuple(ghost[inside].T)] = OCCUPIED
        drawn += int(near.sum())
    return OccupancyGrid(cells, grid.resolution, grid.origin)


def spurious_rays(grid: OccupancyGrid, count: int, rng: np.random.Generator) -> OccupancyGrid:
    """Draw thin free rays, 20 to 80 cells long, from free cells through everything, as glass and mirrors cause."""
    starts = np.argwhere(grid.free)
    cells = np.ascontiguousarray(grid.occupancy).copy()
    for _ in range(count if len(starts) else 0):
        row, col = starts[rng.integers(len(starts))]
        angle, reach = rng.uniform(0, 2 * np.pi), rng.uniform(20, 80)
        end = (int(col + reach * np.cos(angle)), int(row + reach * np.sin(angle)))
        mark = cv2.line(np.zeros(grid.shape, np.uint8), (int(col), int(row)), end, 1)
        cells[mark.astype(np.bool_)] = FREE
    return OccupancyGrid(cells, grid.resolution, grid.origin)


def blobs(grid: OccupancyGrid, count: int, rng: np.random.Generator) -> OccupancyGrid:
    """Put occupied or unknown discs of 2 to 5 cells radius on free cells, as people and unseen corners cause."""
    starts = np.argwhere(grid.free)
    cells = grid.occupancy.copy()
    rows, cols = np.indices(grid.shape)
    for _ in range(count if len(starts) else 0):
        row, col = starts[rng.integers(len(starts))]
        radius, value = rng.uniform(2, 5), OCCUPIED if rng.random() < 0.5 else UNKNOWN
        cells[(rows - row) ** 2 + (cols - col) ** 2 <= radius**2] = value
    return OccupancyGrid(cells, grid.resolution, grid.origin)


def erosion(grid: OccupancyGrid, cells: float) -> OccupancyGrid:
    """Erode the walls by `cells` on every side; walls up to twice as thick vanish.

    Removed cells turn free where free space is as near, else unknown.
    """
    free, unknown = (_within(mask, cells) for mask in (grid.free, grid.unknown))
    return _with_values(grid, grid.occupied & (free | unknown), np.where(free, FREE, UNKNOWN))


def dilation(grid: OccupancyGrid, cells: float) -> OccupancyGrid:
    """Add `cells` to every side of the walls, over free and unknown space alike."""
    return _with_values(grid, _within(grid.occupied, cells), OCCUPIED)


def _random_subset(mask: NDArray[np.bool_], share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Choose each cell of a mask with probability `share`."""
    _check_share(share)
    picked: NDArray[np.bool_] = mask & (rng.random(mask.shape) < share)
    return picked


def _check_share(share: float) -> None:
    if not 0 <= share <= 1:
        raise InputError(f"a share must lie in 0..1, got {share}")


def _dilated(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the cells that a mask covers or touches, corners included."""
    return cv2.dilate(mask.view(np.uint8), np.ones((3, 3), np.uint8)).astype(np.bool_)


def _within(mask: NDArray[np.bool_], cells: float) -> NDArray[np.bool_]:
    """Return the cells whose centres lie within a distance, in cells, of the centre of a cell of the mask."""
    if not mask.any():
        return mask
    near: NDArray[np.bool_] = exact_distance(mask) <= cells
    return near


def _with_values(grid: OccupancyGrid, mask: NDArray[np.bool_], value: int | NDArray[np.int64]) -> OccupancyGrid:
    """Return the grid with other values under a mask."""
    return OccupancyGrid(np.where(mask, value, grid.occupancy).astype(np.int8), grid.resolution, grid.origin)
