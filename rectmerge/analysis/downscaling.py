"""Maps shrunk by whole blocks of cells to a size that a search can afford, with the similarity back to their pixels."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True, eq=False)
class Shrunk:
    """A map cut to its known cells, with one cell for each block of its cells.

    Parameters
    ----------
    grid
        The shrunk map. A block with an occupied cell is occupied; else it is free where half of it is.
    to_given
        From its pixels to those of the map as given; its scale is the side of a block.

    Notes
    -----
    `rectmerge.baselines.images.resize` makes grey images by any factor instead, for methods that work on images.
    """

    grid: OccupancyGrid
    to_given: Similarity

    @classmethod
    def from_grid(cls, grid: OccupancyGrid, most_cells: int) -> Shrunk:
        """Shrink a map with a known cell until no side is longer than `most_cells`."""
        left, top, width, height = cv2.boundingRect((~grid.unknown).view(np.uint8))
        cut = (slice(top, top + height), slice(left, left + width))
        side = -(-max(width, height) // most_cells)
        occupied, free = _count(grid.occupied[cut], side), _count(grid.free[cut], side)
        cells = np.where(occupied > 0, OCCUPIED, np.where(2 * free >= side**2, FREE, UNKNOWN)).astype(np.int8)
        middle = (side - 1) / 2
        return cls(OccupancyGrid(cells), Similarity(float(side), 0.0, left + middle, top + middle))


def shrunk_bounds(scale: tuple[float, float], a: Shrunk, b: Shrunk) -> tuple[float, float]:
    """Return the bounds of the pixel scale between two shrunk maps, from those between the maps as given."""
    ratio = b.to_given.scale / a.to_given.scale
    return scale[0] * ratio, scale[1] * ratio


def between_given(pixels: Similarity, a: Shrunk, b: Shrunk) -> Similarity:
    """Return the placement of the maps as given, from that of the shrunk ones."""
    return a.to_given @ pixels @ b.to_given.inverse()


def _count(mask: NDArray[np.bool_], side: int) -> NDArray[np.int64]:
    """Count the cells of a mask in blocks of a side; the last row and column are padded."""
    padded = np.pad(mask, [(0, -length % side) for length in mask.shape])
    height, width = padded.shape
    counts: NDArray[np.int64] = padded.reshape(height // side, side, width // side, side).sum(axis=(1, 3))
    return counts
