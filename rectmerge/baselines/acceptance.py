"""Cell agreement of two maps under a placement: Carpin's acceptance index, and the share of shared walls."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

SAMPLED_CELLS = 80_000  # an evenly spaced choice of more of A's cells says the same
FREE, OCCUPIED = 1, 2  # bits: "and" of two codes is above 0 where they agree; 0 is unknown
Codes = NDArray[np.uint8]


class CellComparison:
    """Two maps prepared for a comparison cell by cell under several placements.

    Parameters
    ----------
    a, b
        The maps; placements take pixels of B to pixels of A.
    """

    def __init__(self, a: OccupancyGrid, b: OccupancyGrid) -> None:
        self._step = max(1, round(math.sqrt(a.occupancy.size / SAMPLED_CELLS)))
        self._a = np.ascontiguousarray(_codes(a)[:: self._step, :: self._step])
        self._b = _codes(b)
        self._walls_a, self._near_a = _walls(self._a)
        self._area_a = int(np.count_nonzero(self._walls_a))
        self._area_b = int(np.count_nonzero(b.occupied)) / self._step**2

    def acceptance_index(self, pixels: Similarity) -> float:
        """Return agree / (agree + disagree) over the cells that both maps know, 0..1; 0 where there is none.

        Notes
        -----
        S. Carpin, "Fast and accurate map merging for multi-robot systems", 2008, DOI 10.1007/s10514-008-9097-4.
        """
        on_a = self._placed(pixels)
        agree = cv2.countNonZero(cv2.bitwise_and(self._a, on_a))
        known = cv2.countNonZero(cv2.min(self._a, on_a))
        return agree / max(1, known)

    def known_share(self, pixels: Similarity) -> float:
        """Return the share of the smaller map that is known in both, 0..1."""
        both = cv2.countNonZero(cv2.min(self._a, self._placed(pixels)))
        known_b = cv2.countNonZero(self._b) * pixels.scale**2 / self._step**2
        return min(1.0, both / max(1.0, min(cv2.countNonZero(self._a), known_b)))

    def shared_walls(self, pixels: Similarity) -> float:
        """Return the share of both maps' occupied cells that lie on or next to one of the other map, 0..1.

        Occupied cells where the other map is unknown count as not shared. So a small overlap scores low, and so does a
        map shrunk into the other's free space.
        """
        walls_b, near_b = _walls(self._placed(pixels))
        matched_a = cv2.countNonZero(cv2.bitwise_and(self._walls_a, near_b))
        matched_b = cv2.countNonZero(cv2.bitwise_and(walls_b, self._near_a))
        return min(1.0, (matched_a + matched_b) / max(1.0, self._area_a + self._area_b * pixels.scale**2))

    def _placed(self, pixels: Similarity) -> Codes:
        """Return the codes of B at A's sampled cells."""
        placed = cv2.warpAffine(self._b, pixels.matrix / self._step, self._a.shape[::-1], flags=cv2.INTER_NEAREST)
        return np.asarray(placed, np.uint8)


def _codes(grid: OccupancyGrid) -> Codes:
    return np.where(grid.occupied, OCCUPIED, np.where(grid.free, FREE, 0)).astype(np.uint8)


def _walls(codes: Codes) -> tuple[Codes, Codes]:
    """Return the occupied cells, and these with their eight neighbours."""
    walls = (codes == OCCUPIED).view(np.uint8)
    return walls, np.asarray(cv2.dilate(walls, np.ones((3, 3), np.uint8)), np.uint8)
