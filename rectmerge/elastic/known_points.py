"""Displacement through known points: the bend of a map where its truth, or marks by hand, are given."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.banded import solve_banded
from rectmerge._kernels.spline_lattice import add_pulls
from rectmerge.elastic.lattice import Displacement, Lattice
from rectmerge.elastic.params import FitParams
from rectmerge.elastic.smoothness import smoothness


def fit_to_points(
    points: NDArray[np.float64],
    targets: NDArray[np.float64],
    *,
    std_cells: float = 1.0,
    params: FitParams | None = None,
) -> Displacement:
    """Fit the displacement that takes points to their targets, against the prior of `rm.unbend`.

    Parameters
    ----------
    points, targets
        Shape (N, 2), N >= 2, in the pixels of A; the points not all equal.
    std_cells
        Standard deviation of the targets, in cells of A.
    params
        The prior and the lattice; None is the default.
    """
    params = params or FitParams()
    low, high = points.min(axis=0), points.max(axis=0)
    diagonal = float(np.hypot(*(high - low)))
    lattice = Lattice.over(low, high, params.spacing * diagonal)
    band, right = smoothness(lattice, params.patch * diagonal, params), np.zeros(2 * lattice.node_count)
    weights = np.full(len(points), 1 / (2 * std_cells**2))
    stiffness = np.stack([weights, np.zeros_like(weights), weights], axis=1)
    none = Displacement.none(lattice)
    add_pulls(
        band, right, none.coefficients, lattice.corner, lattice.spacing, lattice.counts, lattice.steps,
        np.ascontiguousarray(points), stiffness, weights[:, np.newaxis] * (targets - points),
    )  # fmt: skip
    return Displacement(lattice, solve_banded(band, right).reshape(-1, 2))
