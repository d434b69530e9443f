"""Algorithm 1: the maximal empty rectangle of a grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge.rectangles import Rectangle, largest_rectangle


def find_mer(free: NDArray[np.bool_]) -> Rectangle | None:
    """Find the maximal empty rectangle of a grid (Algorithm 1).

    Parameters
    ----------
    free
        Mask of free cells (the paper's Gx), shape (H, W).

    Returns
    -------
    Rectangle or None
        None where no cell is free.

    Raises
    ------
    InputError
        If `free` is not a 2-D mask with at least one cell.

    Notes
    -----
    Departs from the paper: the listing never pops T and resets neither k nor w; the prose is implemented instead, the
    largest rectangle under the histogram of each column. Ties, open in the paper, go to the smallest x, then the
    smallest bottom row, then the smallest top row. The survey itself is in `_kernels/rectangles.py` and `runs.py`.
    """
    return largest_rectangle(free)  # Alg. 1, lines 2-24
