"""Hypotheses of placements: every pair of rectangles that could be the same room, in four quarter turns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.placements import pair_by_both_sides, pair_by_one_side
from rectmerge.robust.features import Frame
from rectmerge.robust.params import ProposeParams


def propose(
    frames_a: Sequence[Frame], frames_b: Sequence[Frame], scale_bounds: tuple[float, float], params: ProposeParams
) -> NDArray[np.float64]:
    """List placements of B on A from pairs of rectangles, shape (N, 4), rows (a, b, tx, ty) of the working grids.

    Parameters
    ----------
    frames_a, frames_b
        Rectangles of both maps in their orthogonal frames.
    scale_bounds
        Bounds of the scale between the working grids.
    params
        Parameters of the stage.
    """
    log_bounds = (math.log(scale_bounds[0]) - params.scale_slack, math.log(scale_bounds[1]) + params.scale_slack)
    placements = np.empty((params.max_hypotheses, 4))
    pairs = [(a, b, k) for a, b in product(frames_a, frames_b) for k in range(4) if len(a.boxes) and len(b.boxes)]
    count = 0
    for tolerance in params.aspect_tolerances if params.use_two_sided else ():
        count = 0
        for a, b, quarter in pairs:
            turn = a.angle - b.angle + quarter * math.pi / 2
            count = pair_by_both_sides(
                a.boxes, b.boxes, turn, quarter % 2 == 1, log_bounds, tolerance, placements, count
            )
        if count >= params.enough_hypotheses:
            break
    if count < params.plenty_hypotheses:
        for a, b, quarter in pairs:
            share = min(1.0, math.sqrt(params.max_one_sided_pairs / (len(pairs) * len(a.boxes) * len(b.boxes))))
            m, n = (max(params.min_one_sided, int(share * len(frame.boxes))) for frame in (a, b))
            count = pair_by_one_side(
                a.boxes[:m], b.boxes[:n], a.has_wall[:m], b.has_wall[:n], a.angle, b.angle, quarter,
                log_bounds, params.aspect_tolerances[0], placements, count,
            )  # fmt: skip
    return placements[:count].copy()
