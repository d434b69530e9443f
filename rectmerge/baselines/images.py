"""Images for the image-based baselines: of equal cells where the scale is known, and of limited size."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

LIKE_ONE = 1e-9  # a factor this close to 1 resizes nothing


class Resized(NamedTuple):
    """An image, shape (h, w), and the similarity from its pixels to those of its original."""

    image: NDArray[np.float32]
    to_grid: Similarity


def middle_scale(scale: tuple[float, float]) -> float:
    """Return the geometric mean of the bounds of the pixel scale: the scale that a rigid method assumes."""
    return math.sqrt(scale[0] * scale[1])


def working_factors(
    a: OccupancyGrid, b: OccupancyGrid, scale: tuple[float, float], longest_cells: int
) -> tuple[float, float]:
    """Return the factors by which A and B are resized: the middle scale becomes 1, no side is longer than allowed.

    Parameters
    ----------
    a, b
        The maps.
    scale
        Bounds of the pixel scale, cells of A per cell of B.
    longest_cells
        The longest side that either image may have.
    """
    middle = middle_scale(scale)
    shrink = min(1.0, longest_cells / max(*a.shape, middle * max(b.shape)))
    return shrink, shrink * middle


def resize(image: NDArray[np.float32], factor: float) -> Resized:
    """Resize an image with half-pixel centres; blur it first where it shrinks, so that thin walls survive.

    It makes grey images by any factor. `rectmerge.analysis.downscaling.Shrunk` counts cells in whole blocks instead,
    for methods that need an occupancy grid.

    Parameters
    ----------
    image
        Shape (H, W).
    factor
        New side over old side, above 0.
    """
    if abs(factor - 1) < LIKE_ONE:
        return Resized(image, Similarity())
    height, width = image.shape
    size = max(1, math.ceil(width * factor - 1e-9)), max(1, math.ceil(height * factor - 1e-9))
    offset = (1 / factor - 1) / 2
    to_grid = Similarity(1 / factor, 0.0, offset, offset)
    source = image if factor > 1 else cv2.GaussianBlur(image, (0, 0), 0.4 / factor, borderType=cv2.BORDER_REPLICATE)
    resized = cv2.warpAffine(
        source, to_grid.matrix, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_REPLICATE
    )
    return Resized(np.asarray(resized, np.float32), to_grid)
