"""Counts of the distance codes of one map at the wall points of the other, per placement."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def count_codes(
    placements: NDArray[np.float64],
    quarters: NDArray[np.int64],
    points: NDArray[np.float64],
    kinds: NDArray[np.uint8],
    codes: NDArray[np.uint8],
    counts: NDArray[np.int32],
) -> None:
    """Count, for each placement and kind of face, the codes at the points' faces: counts (N, kinds, codes).

    `kinds` (P, W) says which kind of face, from 1, a point has in each of W directions; 0 where it has none. A
    placement turns direction k into direction k + quarters of the other map, whose codes are `codes` (W, h, w). Points
    outside the other map are not counted.
    """
    directions, height, width = codes.shape
    for i in range(len(placements)):
        a, b = placements[i, 0], placements[i, 1]
        tx, ty = placements[i, 2] + 0.5, placements[i, 3] + 0.5
        for n in range(len(points)):
            x = a * points[n, 0] - b * points[n, 1] + tx
            y = b * points[n, 0] + a * points[n, 1] + ty
            if x < 0 or y < 0 or x >= width or y >= height:
                continue
            u, v = int(x), int(y)
            for k in range(directions):
                if kinds[n, k]:
                    counts[i, kinds[n, k] - 1, codes[(k + quarters[i]) % directions, v, u]] += 1
