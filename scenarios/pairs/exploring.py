"""Finished maps shown as they might have grown: from one place outwards, along the free space."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import UNKNOWN, OccupancyGrid

WALL_CELLS = 3  # walls are one to three cells thick: so far beyond the free space that is shown
NEIGHBOURS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


def explore(grid: OccupancyGrid, versions: int, seed: int) -> Iterator[OccupancyGrid]:
    """Yield a map as it grows: each version shows an equal share more of the free space, the last one all.

    Free cells are shown in the order of their way from a drawn free cell, with what is known within three cells of
    them. What cannot be reached comes with the last version.

    Parameters
    ----------
    grid
        The finished map; it has a free cell.
    versions
        Number of versions.
    seed
        Draws the cell.
    """
    steps = steps_from(grid.free, seed)
    ends = np.quantile(steps[grid.free & (steps >= 0)], np.arange(1, versions) / versions)
    for end in ends:
        shown = grid.free & (steps >= 0) & (steps <= end)
        near = cv2.dilate(shown.astype(np.uint8), np.ones((2 * WALL_CELLS + 1,) * 2, np.uint8)).astype(bool)
        yield replace(grid, occupancy=np.where(shown | (near & ~grid.free), grid.occupancy, UNKNOWN))
    yield grid


def steps_from(free: NDArray[np.bool_], seed: int) -> NDArray[np.int32]:
    """Return the steps over free cells from a drawn one to each cell; -1 where no way leads.

    The cell is drawn from the largest connected part.
    """
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=4)
    rows, cols = np.nonzero(labels == 1 + np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    start = np.random.default_rng(seed).integers(len(rows))
    steps = np.full(free.shape, -1, dtype=np.int32)
    front = np.zeros(free.shape, dtype=np.uint8)
    front[rows[start], cols[start]] = 1
    step, is_growing = 0, True
    while is_growing:
        reached = (front > 0) & (steps < 0)
        steps[reached] = step
        step, is_growing = step + 1, bool(reached.any())
        front = np.where(free, cv2.dilate(front, NEIGHBOURS), 0).astype(np.uint8)
    return steps
