"""Exact Euclidean distance on a grid, the same in every process."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def exact_distance(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Measure from each cell centre to that of the nearest cell of a mask, shape (H, W), in cells.

    Notes
    -----
    The last digit of OpenCV's distances depends on where its buffers happen to lie, which differs between processes.
    The square of a distance is a whole number, so it is rounded, and the root is taken anew: exact up to 2,000 cells,
    where a single-precision number still tells one square from the next.

    Examples
    --------
    >>> exact_distance(np.eye(3, dtype=np.bool_))[0].tolist()
    [0.0, 1.0, 1.4142135623730951]
    """
    distances = cv2.distanceTransform((~mask).view(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    exact: NDArray[np.float64] = np.sqrt(np.rint(np.square(distances, dtype=np.float64)))
    return exact
