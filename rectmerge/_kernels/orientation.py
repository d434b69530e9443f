"""Line segments between points of an edge, with the number of segments inside the region of each."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def line_inliers(points: NDArray[np.float64], tolerance: float) -> NDArray[np.float64]:
    """Return, for every pair p < q of points, the row (p, q, slope angle in [0, pi), segments inside its region)."""
    count = len(points)
    lines = np.empty((count * (count - 1) // 2, 4))  # eq. (7)
    row = 0
    for p in range(count):  # Alg. 3, lines 7-9
        for q in range(p + 1, count):
            dx, dy = points[q, 0] - points[p, 0], points[q, 1] - points[p, 1]
            major, minor = (0, 1) if abs(dx) >= abs(dy) else (1, 0)
            low, high = min(points[p, major], points[q, major]), max(points[p, major], points[q, major])
            slope = (dy / dx) if major == 0 else (dx / dy)  # Alg. 3, line 10
            inside = 0
            for k in range(count):
                along = points[k, major]
                if low <= along <= high:
                    offset = points[k, minor] - points[p, minor] - slope * (along - points[p, major])
                    inside += abs(offset) <= tolerance  # Alg. 3, line 11
            lines[row, 0], lines[row, 1] = p, q
            lines[row, 2] = math.atan2(dy, dx) % math.pi
            lines[row, 3] = inside * (inside - 1) // 2  # Alg. 3, lines 12-18
            row += 1
    return lines
