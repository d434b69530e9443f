"""Connections of labelled rectangles: the labels along each side."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def side_labels(
    labels: NDArray[np.int32], rectangles: NDArray[np.int32], extra: int, starts: NDArray[np.int64]
) -> NDArray[np.int32]:
    """List the labels along the four sides (up, down, left, right) of every rectangle, ascending and unique.

    `extra` cells are read beyond the end of each side (one in the printed eq. 3). Side d of rectangle i is the returned
    slice starts[4 i + d] to starts[4 i + d + 1].
    """
    height, width = labels.shape
    room = 0
    for i in range(len(rectangles)):
        room += 2 * (rectangles[i, 2] + rectangles[i, 3] + 2 * extra)
    listed = np.empty(room, np.int32)
    seen = np.full(len(rectangles) + 1, -1)
    count = 0
    for i in range(len(rectangles)):
        x, y, w, h = rectangles[i]
        for side in range(4):
            begin = count
            starts[4 * i + side] = begin
            is_row = side < 2
            fixed = y - 1 if side == 0 else y + h if side == 1 else x - 1 if side == 2 else x + w  # eq. (3)
            first = x if is_row else y
            length = (w if is_row else h) + extra
            last = min(first + length, width if is_row else height)
            if fixed < 0 or fixed >= (height if is_row else width):
                continue
            for k in range(first, last):
                label = labels[fixed, k] if is_row else labels[k, fixed]
                if label > 0 and label != i + 1 and seen[label] != 4 * i + side:  # eq. (4)
                    seen[label] = 4 * i + side
                    listed[count] = label
                    count += 1
            listed[begin:count].sort()
    starts[4 * len(rectangles)] = count
    return listed[:count]
