"""Fringe of unknown cells between the free space of a map and its walls.

Mappers that are sure of a wall only where its middle is, and map savers that keep what lies between two thresholds as
unknown, draw walls that nowhere border on free space.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import FREE, UNKNOWN

# source of both: real_places, where maps of three places have a share of 0.98 to 1, of a fourth 0.81 to 0.95, of all
# others at most 0.81; 4 cells give the same verdicts
REACH_CELLS = 5  # widest fringe, about a quarter of a metre at the usual resolution
MIN_SHARE = 0.9  # of the walls near free space that stand apart from it


def without_fringe(values: NDArray[np.int8], walls: NDArray[np.bool_]) -> NDArray[np.int8]:
    """Take the unknown cells between walls and free space as free, where nearly all walls have such a fringe.

    Parameters
    ----------
    values
        -1 unknown, 0 free, 100 occupied, shape (H, W).
    walls
        The occupied cells that are no specks, shape (H, W).

    Returns
    -------
    ndarray
        The cells, shape (H, W): the same object where the map has no fringe.
    """
    # what an opening leaves: free specks inside a wall are no free space beside it
    free = cv2.morphologyEx((values == FREE).view(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)).view(np.bool_)
    near = _dilated(free, REACH_CELLS)
    beside = walls & _dilated(free, 1)
    apart = walls & near & ~_dilated(beside, REACH_CELLS + 1)
    count = np.count_nonzero(apart)
    if count == 0 or count < MIN_SHARE * (count + np.count_nonzero(beside)):
        return values
    return np.where((values == UNKNOWN) & near & _dilated(apart, REACH_CELLS), np.int8(FREE), values)


def _dilated(mask: NDArray[np.bool_], cells: int) -> NDArray[np.bool_]:
    """Grow a mask by cells, corners included."""
    return cv2.dilate(mask.view(np.uint8), np.ones((2 * cells + 1, 2 * cells + 1), np.uint8)).view(np.bool_)
