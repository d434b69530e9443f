"""Loops of a correlation by FFT: sums of products of spectra, and the highest peaks of an image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def sum_products(
    a: NDArray[np.complex64],
    b: NDArray[np.complex64],
    quarter: int,
    turns_rows: bool,
    turns_cols: bool,
    total: NDArray[np.complex64],
) -> None:
    """Sum the products of spectra of squares, shape (4, n, n), of `a` with conjugate ones of `b`, into (n, n).

    Spectrum k of `b` meets spectrum k + quarter of `a`. The rows and the columns of `b` may be turned about the first.
    """
    side = a.shape[1]
    a0, a1, a2, a3 = a[quarter % 4], a[(quarter + 1) % 4], a[(quarter + 2) % 4], a[(quarter + 3) % 4]
    for v in range(side):
        row = (side - v) % side if turns_rows else v
        b0, b1, b2, b3 = b[0, row], b[1, row], b[2, row], b[3, row]
        if turns_cols:
            total[v, 0] = (
                a0[v, 0] * b0[0].conjugate()
                + a1[v, 0] * b1[0].conjugate()
                + a2[v, 0] * b2[0].conjugate()
                + a3[v, 0] * b3[0].conjugate()
            )
            for u in range(1, side):
                back = side - u
                total[v, u] = (
                    a0[v, u] * b0[back].conjugate()
                    + a1[v, u] * b1[back].conjugate()
                    + a2[v, u] * b2[back].conjugate()
                    + a3[v, u] * b3[back].conjugate()
                )
        else:
            for u in range(side):
                total[v, u] = (
                    a0[v, u] * b0[u].conjugate()
                    + a1[v, u] * b1[u].conjugate()
                    + a2[v, u] * b2[u].conjugate()
                    + a3[v, u] * b3[u].conjugate()
                )


@kernel
def highest_peaks(scores: NDArray[np.float32], cells: NDArray[np.int64], values: NDArray[np.float32]) -> int:
    """Find the highest local maxima of an image, highest first, as cells (row by row) and values; return their number.

    `cells` and `values` have the length of the most that are kept; of equal ones the first comes first.
    """
    height, width = scores.shape
    most, count = len(cells), 0
    for v in range(height):
        for u in range(width):
            value = scores[v, u]
            if count == most and value <= values[most - 1]:
                continue
            is_peak = True
            for y in range(max(0, v - 1), min(height, v + 2)):
                for x in range(max(0, u - 1), min(width, u + 2)):
                    is_peak = is_peak and scores[y, x] <= value
            if not is_peak:
                continue
            at = count if count < most else most - 1
            while at > 0 and values[at - 1] < value:
                cells[at], values[at] = cells[at - 1], values[at - 1]
                at -= 1
            cells[at], values[at] = v * width + u, value
            count = min(most, count + 1)
    return count
