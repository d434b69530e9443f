"""Measures of one pair: overlap, accuracy of the maps, and the bending that no similarity removes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.quality import measure_quality
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import control_point_rmse, known_extent

EXACT_BELOW_PX = 1e-3  # a residual below this is rounding: there is nothing for an affine map to remove


def measure_pair(pair: MapPair) -> dict[str, float]:
    """Measure a pair by its maps and its truth.

    Returns
    -------
    dict
        ``overlap``; ``wall_cells``, the mean of both maps' median wall thickness, in cells; ``speckle`` of the map that
        has more; and where the truth is not exact ``residual``, the residual over L, and ``affine``, the share of
        it that the best affine map removes.
    """
    maps = [measure_quality(grid) for grid in (pair.a, pair.b)]
    measures = {"overlap": pair.overlap or 0.0, "speckle": max(quality.speckle for quality in maps)}
    measures["wall_cells"] = float(np.mean([quality.wall_thickness_cells or 0.0 for quality in maps]))
    points = pair.control_points
    if points is not None and pair.residual_px is not None and pair.residual_px > EXACT_BELOW_PX:
        measures["residual"] = pair.residual_px / known_extent(pair.a)
        measures["affine"] = 1.0 - affine_rmse(points) / pair.residual_px
    return measures


def affine_rmse(points: NDArray[np.float64]) -> float:
    """Return the RMSE of the best affine map on control points (N, 4), in A's pixels."""
    from_b = np.column_stack([points[:, 2:], np.ones(len(points))])
    matrix = np.linalg.lstsq(from_b, points[:, :2], rcond=None)[0].T
    return control_point_rmse(matrix, points)
