"""Look-ups of wall faces: normals averaged over neighbours, and the nearest face that looks the same way."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def smooth_normals(
    index: NDArray[np.int32], cells: NDArray[np.int64], normals: NDArray[np.float64], reach: int, min_cos: float
) -> NDArray[np.float64]:
    """Average unit normals over the faces of a square that look about the same way, (N, 2); unit length.

    `index`, (H, W), has the number of the face in each cell, -1 elsewhere; `cells`, (N, 2), its (u, v).
    """
    height, width = index.shape
    smooth = np.empty_like(normals)
    for i in range(len(cells)):
        u, v = cells[i]
        x = y = 0.0
        for row in range(max(0, v - reach), min(height, v + reach + 1)):
            for col in range(max(0, u - reach), min(width, u + reach + 1)):
                j = index[row, col]
                if j >= 0 and normals[j, 0] * normals[i, 0] + normals[j, 1] * normals[i, 1] > min_cos:
                    x += normals[j, 0]
                    y += normals[j, 1]
        length = math.hypot(x, y)
        smooth[i, 0], smooth[i, 1] = x / length, y / length
    return smooth


@kernel
def direction_bin(x: float, y: float, bins: int) -> int:
    """Return the bin of a direction, 0 from the first axis on."""
    return math.floor((math.atan2(y, x) / math.tau) % 1.0 * bins) % bins


@kernel
def nearest_facing(
    labels: NDArray[np.int32], factor: float, points: NDArray[np.float64], normals: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Look up the number of the nearest face that looks like each normal, (N,); -1 outside the map.

    `labels`, (bins, h, w), on cells `factor` times as large as the map's.
    """
    bins, height, width = labels.shape
    found = np.full(len(points), -1, np.int64)
    for i in range(len(points)):
        u, v = math.floor(points[i, 0] / factor + 0.5), math.floor(points[i, 1] / factor + 0.5)
        if 0 <= u < width and 0 <= v < height:
            found[i] = labels[direction_bin(normals[i, 0], normals[i, 1], bins), int(v), int(u)]
    return found
