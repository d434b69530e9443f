"""Greys that map savers write, and files in which they do not mean what their thresholds say."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import FREE, OccupancyGrid
from rectmerge.io.dialects import FREE_GREY, UNKNOWN_GREY, Dialect, Legend, occupancy_table
from rectmerge.io.image_file import OPAQUE, Pixels, grey_counts

MAX_STRAY_SHARE = 0.05  # pixels of 204 and 206 for each of 205: fewer are strokes of an editor, more are shading
NEARLY_ALL = 0.95  # free share of a map's cells that no finished map has
MOST = 0.5  # share of the pixels of the grey that may be unknown space
LIGHTER_SHARE = 0.001  # least share of lighter pixels, which then are the free ones


def turns_unknown_free(legend: Legend, pixels: Pixels, dialect: Dialect) -> bool:
    """Detect the 205 trap: the savers' grey for unknown, read as free, in an image with their grey for free."""
    if legend.mode == "raw" or legend.negate or dialect == "cartographer":
        return False
    if occupancy_table(legend, dialect)[UNKNOWN_GREY] != FREE:
        return False
    counts = _counts(pixels)
    stray = counts[UNKNOWN_GREY - 1] + counts[UNKNOWN_GREY + 1]
    return bool(counts[FREE_GREY] and counts[UNKNOWN_GREY] and stray <= MAX_STRAY_SHARE * counts[UNKNOWN_GREY])


def doubtful_grey(pixels: Pixels, grid: OccupancyGrid) -> int | None:
    """Return the grey of most pixels where nearly all of a map reads free, and lighter pixels may be the free ones."""
    if float(grid.free.mean()) <= NEARLY_ALL:
        return None
    counts = _counts(pixels)
    grey = int(counts.argmax())
    total = max(1, int(counts.sum()))
    is_most = counts[grey] > MOST * total and counts[grey + 1 :].sum() > LIGHTER_SHARE * total
    return grey if is_most else None


def _counts(pixels: Pixels) -> NDArray[np.int64]:
    """Return the number of opaque pixels of each grey, shape (256,)."""
    return grey_counts(pixels.luma, None if pixels.alpha is None else pixels.alpha == OPAQUE)
