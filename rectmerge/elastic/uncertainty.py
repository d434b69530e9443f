"""Uncertainty of a displacement: fits with a quarter of the squares left out, the jackknife."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.elastic.lattice import Displacement


def jackknife_std(left_out: tuple[Displacement, ...], points: ArrayLike) -> NDArray[np.float64]:
    """Return the standard deviation of displaced points, shape (...): the root of its sum over both axes.

    Notes
    -----
    M. H. Quenouille, Biometrika 1956, DOI 10.1093/biomet/43.3-4.353: of n estimates, each without one part of the data,
    the variance is (n - 1) / n times the sum of squares about their mean.
    """
    moves = np.stack([displacement.at(points) for displacement in left_out])
    squares = ((moves - moves.mean(axis=0)) ** 2).sum(axis=(0, -1))
    std: NDArray[np.float64] = math.sqrt((len(left_out) - 1) / len(left_out)) * np.sqrt(squares)
    return std
