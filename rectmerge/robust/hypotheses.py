"""Placements worth a look: every pair of rectangles that could be the same room, in four quarter turns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.placements import pair_by_both_sides, pair_by_one_side
from rectmerge.robust.features import Frame

TOLERANCES = (0.05, 0.1, 0.2, 0.4)  # of the log of the aspect, wider where few pairs agree
ENOUGH = 3000  # hypotheses to stop widening the tolerance
PLENTY = 8000  # hypotheses to do without pairs that agree in one extent only
MOST = 400_000
ONE_SIDED_PAIRS = 40_000  # rectangle pairs compared in one extent
SCALE_SLACK = 0.03  # log scale: the search looks a little beyond its bounds, refinement comes back


def propose(
    frames_a: Sequence[Frame], frames_b: Sequence[Frame], scale_bounds: tuple[float, float]
) -> NDArray[np.float64]:
    """List placements of B on A from pairs of rectangles, shape (N, 4), rows (a, b, tx, ty) of the working grids.

    Parameters
    ----------
    frames_a, frames_b
        Rectangles of both maps in their orthogonal frames.
    scale_bounds
        Bounds of the scale between the working grids.
    """
    log_bounds = (math.log(scale_bounds[0]) - SCALE_SLACK, math.log(scale_bounds[1]) + SCALE_SLACK)
    found = np.empty((MOST, 4))
    pairs = [(a, b, k) for a, b in product(frames_a, frames_b) for k in range(4) if len(a.boxes) and len(b.boxes)]
    count = 0
    for tolerance in TOLERANCES:
        count = 0
        for a, b, quarter in pairs:
            turn = a.angle - b.angle + quarter * math.pi / 2
            count = pair_by_both_sides(a.boxes, b.boxes, turn, quarter % 2 == 1, log_bounds, tolerance, found, count)
        if count >= ENOUGH:
            break
    if count < PLENTY:
        for a, b, quarter in pairs:
            share = min(1.0, math.sqrt(ONE_SIDED_PAIRS / (len(pairs) * len(a.boxes) * len(b.boxes))))
            m, n = max(10, int(share * len(a.boxes))), max(10, int(share * len(b.boxes)))
            count = pair_by_one_side(
                a.boxes[:m], b.boxes[:n], a.has_wall[:m], b.has_wall[:n], a.angle, b.angle, quarter,
                log_bounds, TOLERANCES[0], found, count,
            )  # fmt: skip
    return found[:count].copy()
