"""Cholesky factorisation of a symmetric banded matrix, and the solution of its equations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def solve_banded(band: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve M x = right for a positive definite M, (n,); `band[j, d]` is the element (j + d, j) of M, (n, width + 1).

    Column by column, as LAPACK's pbtrf; a pivot that rounding has made negative is taken as tiny.
    """
    n, width = band.shape[0], band.shape[1] - 1
    factor, x, column = band.copy(), right.copy(), np.empty(width + 1)
    for j in range(n):
        pivot = math.sqrt(max(factor[j, 0], 1e-300))
        last = min(width, n - 1 - j)
        for d in range(last + 1):
            column[d] = factor[j, d] / pivot
            factor[j, d] = column[d]
        for d in range(1, last + 1):
            scale = column[d]
            for e in range(last + 1 - d):
                factor[j + d, e] -= scale * column[d + e]
        x[j] /= pivot
        for d in range(1, last + 1):
            x[j + d] -= column[d] * x[j]
    for j in range(n - 1, -1, -1):
        rest = x[j]
        for d in range(1, min(width, n - 1 - j) + 1):
            rest -= factor[j, d] * x[j + d]
        x[j] = rest / factor[j, 0]
    return x
