"""Compiled loops of loop closure: the linear system of a pose graph."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def solve_profile(system: NDArray[np.float64], right: NDArray[np.float64]) -> bool:
    """Solve a symmetric positive definite system in place by Cholesky; False where it is not positive definite.

    Only the lower triangle is read, each row from its first entry that is not zero: a chain of poses with few loops has
    short rows, and what lies before them stays zero. `right` becomes the solution, `system` the factor.
    """
    size = len(right)
    first = np.empty(size, dtype=np.int64)
    for i in range(size):
        first[i] = i
        for j in range(i):
            if system[i, j] != 0.0:
                first[i] = j
                break
        for j in range(first[i], i + 1):
            value = system[i, j]
            for k in range(max(first[i], first[j]), j):
                value -= system[i, k] * system[j, k]
            if j < i:
                system[i, j] = value / system[j, j]
            elif value > 1e-9 * system[i, i]:
                system[i, i] = math.sqrt(value)
            else:
                return False
        for k in range(first[i], i):
            right[i] -= system[i, k] * right[k]
        right[i] /= system[i, i]
    for i in range(size - 1, -1, -1):
        right[i] /= system[i, i]
        for k in range(first[i], i):
            right[k] -= system[i, k] * right[i]
    return True
