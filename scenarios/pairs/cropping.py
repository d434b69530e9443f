"""Cropping of maps to a size."""

from __future__ import annotations

import cv2
import numpy as np

from rectmerge.grid import UNKNOWN, OccupancyGrid
from scenarios.corruption.geometry import Size


def crop_to_known(grid: OccupancyGrid, size: Size) -> OccupancyGrid:
    """Cut the window of a size (width, height) that holds the most known cells; unknown where the map ends.

    Of equally good windows the one nearest to the map's middle is taken. The map frame stays where it is.
    """
    width, height = size
    pad_x, pad_y = max(0, width - grid.shape[1]), max(0, height - grid.shape[0])
    left, top = pad_x // 2, pad_y // 2
    padding = ((top, pad_y - top), (left, pad_x - left))
    cells = np.pad(grid.occupancy, padding, constant_values=UNKNOWN)
    sums = cv2.integral((cells != UNKNOWN).astype(np.uint8))
    counts = sums[height:, width:] - sums[:-height, width:] - sums[height:, :-width] + sums[:-height, :-width]
    rows, cols = np.nonzero(counts == counts.max())
    middle = (rows - (counts.shape[0] - 1) / 2) ** 2 + (cols - (counts.shape[1] - 1) / 2) ** 2
    row, col = int(rows[np.argmin(middle)]), int(cols[np.argmin(middle)])
    part = cells[row : row + height, col : col + width]
    corner = [col - left - 0.5, row - top + height - 0.5]  # pixel of the window's lower-left corner, in the old image
    x, y = grid.pixel_to_map(corner)
    return OccupancyGrid(part, grid.resolution, (float(x), float(y), grid.origin[2]))
