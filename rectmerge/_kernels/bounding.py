"""Upper bounds of the gain of two maps' wall faces over boxes of placements.

A placement takes a point p of B to ``w (p - c) + m``: complex numbers, c the centre of B, ``w = exp(ln s + i angle)``.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel

ROUNDING = 1e-6  # cells added to the reach of a point, so that rounding makes no bound too low


@kernel
def lower_shares(
    boxes: NDArray[np.float64],
    quarters: NDArray[np.int64],
    shares: NDArray[np.int16],
    threshold: int,
    groups: NDArray[np.int64],
    faces: NDArray[np.float64],
    centre: tuple[float, float],
    gains_a: NDArray[np.int8],
    gains_b: NDArray[np.int8],
    levels: NDArray[np.int32],
    margin: int,
) -> None:
    """Lower each box's shares, the bounds of the gain of each group of faces, to the bounds within the box.

    Boxes are rows (angle, ln s, mu, mv, and the half widths of the angle, of ln s, and of both mu and mv). Groups are
    rows (first face, one past the last, their normal k, 1 for B's); faces are columns (u, v). `gains[l, k]` holds the
    highest gain of normal k in the square that begins at a cell and goes right and down, its side given by the level,
    with `margin` cells more on the left and on top; `levels[n]` is the level for sides up to n. Each quarter turn takes
    normal k of B to normal k + 1 of A. A box is dropped as soon as its sum falls below the threshold.
    """
    totals = np.zeros(len(boxes), np.int64)
    moves = np.empty((len(boxes), 2, 5))
    for i in range(len(boxes)):
        for g in range(len(groups)):
            totals[i] += shares[i, g]
        angle, log_scale, _, _, d_angle, d_log, d_shift = boxes[i]
        scale, grow = math.exp(log_scale), math.exp(d_log)
        cos, sin = math.cos(angle), math.sin(angle)
        along = max(grow - 1, 1 - math.cos(d_angle) / grow)  # of exp(d_log + i d_angle) - 1, in either direction
        across = grow * math.sin(d_angle)
        slant = min(math.sqrt(2.0), abs(cos) + abs(sin) + d_angle)
        moves[i, 0] = cos / scale, -sin / scale, along, across, d_shift * grow * slant / scale
        moves[i, 1] = cos * scale, sin * scale, along, across, d_shift
    for g in range(len(groups)):  # the outer loop, so that the gains of one group stay in the processor's cache
        first, end, normal, is_b = groups[g]
        gains = gains_a if is_b else gains_b
        for i in range(len(boxes)):
            if totals[i] < threshold:
                continue
            at = boxes[i, 2], boxes[i, 3]  # image of the centre
            quarter = quarters[i] if is_b else -quarters[i]
            gain = _highest_gain(
                faces[:, first:end], moves[i, is_b], centre if is_b else at, at if is_b else centre,
                gains, (normal + quarter) % 4, levels, margin,
            )  # fmt: skip
            if gain < shares[i, g]:
                totals[i] += gain - shares[i, g]
                shares[i, g] = gain


@kernel
def add_face_scores(
    placements: NDArray[np.float64],
    quarters: NDArray[np.int64],
    groups: NDArray[np.int64],
    faces: NDArray[np.float64],
    centre: tuple[float, float],
    gains_a: NDArray[np.int8],
    gains_b: NDArray[np.int8],
    margin: int,
    scores: NDArray[np.int64],
) -> None:
    """Add to each placement's score the gain of all faces, those of B in A and those of A in B.

    Placements are rows (angle, ln s, mu, mv), all else as in `lower_shares`; `gains[k]` is per cell for normal k.
    """
    for i in range(len(placements)):
        angle, log_scale, mu, mv = placements[i]
        scale = math.exp(log_scale)
        c, s = math.cos(angle), math.sin(angle)
        for first, end, normal, is_b in groups:
            gains = gains_a[(normal + quarters[i]) % 4] if is_b else gains_b[(normal - quarters[i]) % 4]
            last_u, last_v = float(gains.shape[1] - 1), float(gains.shape[0] - 1)
            for n in range(first, end):
                if is_b:
                    u, v = scale * (faces[0, n] - centre[0]), scale * (faces[1, n] - centre[1])
                    x, y = c * u - s * v + mu, s * u + c * v + mv
                else:
                    u, v = (faces[0, n] - mu) / scale, (faces[1, n] - mv) / scale
                    x, y = c * u + s * v + centre[0], c * v - s * u + centre[1]
                column = int(min(max(x + 0.5 + margin, 0.0), last_u))
                row = int(min(max(y + 0.5 + margin, 0.0), last_v))
                scores[i] += gains[row, column]


@kernel
def _highest_gain(
    faces: NDArray[np.float64],
    move: NDArray[np.float64],
    origin: tuple[float, float],
    target: tuple[float, float],
    gains: NDArray[np.int8],
    normal: int,
    levels: NDArray[np.int32],
    margin: int,
) -> int:
    """Sum the highest gains of faces within their reach in the box."""
    height, width = gains.shape[2], gains.shape[3]
    cells = gains.ravel()
    last_u, last_v = float(width - 1), float(height - 1)
    cos, sin, along, across, shift = move[0], move[1], move[2], move[3], move[4] + ROUNDING
    u0, v0 = target[0] + 0.5 + margin, target[1] + 0.5 + margin
    longest = np.int32(len(levels) - 1)
    total = 0
    for n in range(faces.shape[1]):
        u, v = faces[0, n] - origin[0], faces[1, n] - origin[1]
        x, y = cos * u - sin * v, sin * u + cos * v
        dx, dy = along * abs(x) + across * abs(y) + shift, along * abs(y) + across * abs(x) + shift
        x += u0
        y += v0
        left, top = np.int32(min(max(x - dx, 0.0), last_u)), np.int32(min(max(y - dy, 0.0), last_v))
        right, bottom = np.int32(min(max(x + dx, 0.0), last_u)), np.int32(min(max(y + dy, 0.0), last_v))
        level = levels[min(max(right - left, bottom - top) + np.int32(1), longest)]
        total += cells[((level * 4 + normal) * height + top) * width + left]
    return total
