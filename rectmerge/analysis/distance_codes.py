"""Codes of the distance to walls, one byte a cell, as indices into tables of likelihoods."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

# Between bins of the distance: half a cell where walls match, wider where they only miss. Source: hand, no data; the
# models of `robust` are calibrated on these bins.
EDGES_CELLS = np.array([*np.arange(0, 8, 0.5), 8, 10, 12, 16, 24, np.inf])
BINS = len(EDGES_CELLS) - 1
BIN_OF_HALF_CELL = (np.searchsorted(EDGES_CELLS, np.arange(0, 24.5, 0.5), side="right") - 1).astype(np.uint8)
_BINS_OF_BYTES = np.pad(BIN_OF_HALF_CELL, (0, 256 - len(BIN_OF_HALF_CELL)), mode="edge")
IN_UNKNOWN, ON_BORDER = 32, 64  # added to a bin where nothing is known; the code of the border


def distance_codes(distance: NDArray[np.float32], known: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Code each cell's distance to a wall, shape (h, w): its bin, `IN_UNKNOWN` more where a wall contradicts nothing.

    The border is `ON_BORDER` and stands for everything beyond.
    """
    half_cells = np.minimum(2 * distance, len(BIN_OF_HALF_CELL) - 1).astype(np.uint8)
    codes = np.asarray(cv2.LUT(half_cells, _BINS_OF_BYTES), np.uint8)
    codes[~known] += IN_UNKNOWN
    codes[[0, -1], :] = codes[:, [0, -1]] = ON_BORDER
    return codes


def distance_to(mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Measure from each cell to the nearest cell of a mask, shape (h, w), in cells; far away where it has none."""
    if not mask.any():
        return np.full(mask.shape, EDGES_CELLS[-2] + 1, np.float32)
    return np.asarray(cv2.distanceTransform((~mask).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5), np.float32)
