"""Map image turned and rescaled, with the exact similarity from the pixels of the original."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import LONGEST_SIDE_CELLS, MOST_CELLS, UNKNOWN
from rectmerge.similarity import Similarity

ResampleFrom = Literal["original", "previous"]


class CanvasError(InputError):
    """Error of an image that would be too large once turned or rescaled; raised before resampling."""


@dataclass(frozen=True, slots=True, eq=False)
class PlacedImage:
    """Image of a map as turned and rescaled by Algorithm 5.

    Parameters
    ----------
    cells
        Shape (H, W), occupancy -1..100.
    pose
        From the pixels of the original image to those of `cells`.
    original
        The image as given.
    """

    cells: NDArray[np.int8]
    pose: Similarity
    original: NDArray[np.int8]

    @classmethod
    def from_cells(cls, cells: NDArray[np.int8]) -> PlacedImage:
        """Start from an image as given."""
        return cls(cells, Similarity(), cells)

    def turned(self, angle: float, resample_from: ResampleFrom = "original") -> PlacedImage:
        """Turn the image about its centre, counter-clockwise to the eye, on a canvas that holds all of it.

        Quarter turns move cells and resample nothing.

        Raises
        ------
        CanvasError
            If the canvas would be too large.
        """
        height, width = self.cells.shape
        quarters = angle / (math.pi / 2)
        if abs(quarters - round(quarters)) < 1e-12:
            cells = np.ascontiguousarray(np.rot90(self.cells, round(quarters)))
            step = _about_centres(-round(quarters) * math.pi / 2, self.cells.shape, cells.shape)
            return replace(self, cells=cells, pose=step @ self.pose)
        cos, sin = abs(math.cos(angle)), abs(math.sin(angle))
        size = math.ceil(height * cos + width * sin - 1e-9), math.ceil(width * cos + height * sin - 1e-9)
        return self._moved(_about_centres(-angle, self.cells.shape, size), size, resample_from)

    def rescaled(self, ratio: float, resample_from: ResampleFrom = "original") -> PlacedImage:
        """Make the image `ratio` times as large, with half-pixel centres.

        Raises
        ------
        CanvasError
            If the image would be too large.
        """
        if ratio == 1:
            return self
        height, width = self.cells.shape
        size = max(1, math.ceil(height * ratio - 1e-9)), max(1, math.ceil(width * ratio - 1e-9))
        offset = (ratio - 1) / 2
        return self._moved(Similarity(ratio, 0.0, offset, offset), size, resample_from)

    def _moved(self, step: Similarity, size: tuple[int, int], resample_from: ResampleFrom) -> PlacedImage:
        height, width = size
        if height * width > MOST_CELLS or max(*size, *self.original.shape) > LONGEST_SIDE_CELLS:
            raise CanvasError(f"its image would grow to {width} x {height} cells")
        pose = step @ self.pose
        source, move = (self.original, pose) if resample_from == "original" else (self.cells, step)
        cells = _resample(source, move, size)
        return replace(self, cells=cells, pose=pose)


def _about_centres(angle: float, before: tuple[int, ...], after: tuple[int, ...]) -> Similarity:
    """Return the turn by an angle in the pixel frame that takes the centre of one canvas to that of the other."""
    x, y = Similarity(1.0, angle).apply([(before[1] - 1) / 2, (before[0] - 1) / 2])
    return Similarity(1.0, angle, (after[1] - 1) / 2 - float(x), (after[0] - 1) / 2 - float(y))


def _resample(source: NDArray[np.int8], move: Similarity, size: tuple[int, int]) -> NDArray[np.int8]:
    """Read the source at every pixel of a new canvas: nearest cell, unknown outside."""
    cells = cv2.warpAffine(
        source.view(np.uint8),
        move.inverse().matrix,
        size[::-1],
        flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=(float(np.uint8(UNKNOWN % 256)),),
    )
    return np.asarray(cells, np.uint8).view(np.int8)
