"""Loops of a correlation by FFT: sums of products of spectra, and the highest peaks of an image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def sum_products(a: NDArray[np.float32], b: NDArray[np.float32], quarter: int, total: NDArray[np.float32]) -> None:
    """Sum the products of spectra of squares, shape (K, n, n, 2), of `a` with conjugate ones of `b`, into (n, n, 2).

    The images of `b` are turned by some quarters first, from u towards v, about the first cell: spectrum k of `b` then
    meets spectrum k + quarter of `a`.
    """
    count, side = a.shape[0], a.shape[1]
    for v in range(side):
        back_v = (side - v) % side
        for u in range(side):
            back_u = (side - u) % side
            row, col = v, u
            if quarter == 1:
                row, col = back_u, v
            elif quarter == 2:
                row, col = back_v, back_u
            elif quarter == 3:
                row, col = u, back_v
            real, imaginary = np.float32(0.0), np.float32(0.0)
            for k in range(count):
                on = (k + quarter) % count
                ar, ai, br, bi = a[on, v, u, 0], a[on, v, u, 1], b[k, row, col, 0], b[k, row, col, 1]
                real += ar * br + ai * bi
                imaginary += ai * br - ar * bi
            total[v, u, 0], total[v, u, 1] = real, imaginary


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
