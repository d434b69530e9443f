"""Slow oracles: what the compiled loops of the paper's algorithms have to agree with, written to be read."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray


def largest_area(free: NDArray[np.bool_]) -> int:
    """Try every rectangle."""
    return max((w * h for x, y, w, h in _free_rectangles(free)), default=0)


def maximal_rectangles(free: NDArray[np.bool_]) -> set[tuple[int, int, int, int]]:
    """Keep every free rectangle that grows on no side."""
    every = set(_free_rectangles(free))
    return {
        (x, y, w, h)
        for x, y, w, h in every
        if not {(x - 1, y, w + 1, h), (x, y - 1, w, h + 1), (x, y, w + 1, h), (x, y, w, h + 1)} & every
    }


def _free_rectangles(free: NDArray[np.bool_]) -> list[tuple[int, int, int, int]]:
    height, width = free.shape
    return [
        (x, y, w, h)
        for y, x in np.argwhere(free).tolist()
        for h in range(1, height - y + 1)
        for w in range(1, width - x + 1)
        if free[y : y + h, x : x + w].all()
    ]


def find_mer(free: NDArray[np.bool_]) -> tuple[int, int, int, int] | None:
    """Survey every column as Algorithm 1's prose has it; ties: smallest x, bottom row, top row."""
    height, width = free.shape
    cx = np.zeros((height + 1, width + 1), int)
    for x in range(width - 1, -1, -1):
        cx[:height, x] = np.where(free[:, x], cx[:height, x + 1] + 1, 0)  # eq. (2)
    best = None
    for x in range(width):
        open_rectangles: list[tuple[int, int]] = []  # (top row, width), widths ascending
        for y in range(height + 1):
            top = y
            while open_rectangles and open_rectangles[-1][1] > cx[y, x]:
                top, w = open_rectangles.pop()
                candidate = (-w * (y - top), x, y, top, w)
                best = candidate if best is None else min(best, candidate)
            if cx[y, x] and (not open_rectangles or open_rectangles[-1][1] < cx[y, x]):
                open_rectangles.append((top, int(cx[y, x])))
    if best is None:
        return None
    _, x, bottom, top, w = best
    return x, top, w, bottom - top


def rmap(free: NDArray[np.bool_]) -> list[tuple[int, int, int, int]]:
    """Survey, carve and repeat (Algorithm 2)."""
    left, carved = free.copy(), []
    while (box := find_mer(left)) is not None:
        x, y, w, h = box
        left[y : y + h, x : x + w] = False
        carved.append(box)
    return carved


def side_labels(labels: NDArray[np.int32], box: tuple[int, int, int, int], extra: int) -> list[set[int]]:
    """Labels along the four sides of a rectangle: up, down, left, right (eq. 3 and 4)."""
    x, y, w, h = box
    own = int(labels[y, x])
    height, width = labels.shape
    rows, cols = range(y, min(y + h + extra, height)), range(x, min(x + w + extra, width))
    return [
        {int(labels[v, u]) for v, u in cells if 0 <= v < height and 0 <= u < width} - {0, own}
        for cells in (
            [(y - 1, u) for u in cols],
            [(y + h, u) for u in cols],
            [(v, x - 1) for v in rows],
            [(v, x + w) for v in rows],
        )
    ]


def line_inliers(points: NDArray[np.float64], tolerance: float) -> list[int]:
    """Count the line segments inside the region of each line, one by one (Algorithm 3)."""
    pairs = list(itertools.combinations(range(len(points)), 2))

    def is_inside(k: int, p: int, q: int) -> bool:
        (x1, y1), (x2, y2), (x, y) = points[p], points[q], points[k]
        if abs(x2 - x1) < abs(y2 - y1):
            x1, y1, x2, y2, x, y = y1, x1, y2, x2, y, x
        on_line = y1 + (y2 - y1) / (x2 - x1) * (x - x1)
        return min(x1, x2) <= x <= max(x1, x2) and abs(y - on_line) <= tolerance

    return [sum(is_inside(r, p, q) and is_inside(s, p, q) for r, s in pairs) for p, q in pairs]


def triangle_costs(
    first: NDArray[np.int32], second: NDArray[np.int32], alike: NDArray[np.bool_], weights: tuple[float, ...]
) -> list[float]:
    """Compare every triangle with every corresponding one, both in the order of size (Algorithm 4)."""
    costs = []
    for triple in itertools.combinations(range(len(first)), 3):
        features = triangle_features(first[list(triple)])
        for partners in itertools.product(*(np.flatnonzero(alike[i]).tolist() for i in triple)):
            if features is None or not partners[0] < partners[1] < partners[2]:
                continue
            other = triangle_features(second[list(partners)])
            if other is not None:
                difference = features - other
                costs.append(float(difference @ np.diag(weights) @ difference))  # eq. (11)
    return costs


def triangle_features(boxes: NDArray[np.int32]) -> NDArray[np.float64] | None:
    """The feature vector of eq. 10; None where the three centres lie on one line."""
    centres = boxes[:, :2] + (boxes[:, 2:] - 1) / 2
    areas = boxes[:, 2] * boxes[:, 3]
    (ux, uy), (vx, vy) = centres[1] - centres[0], centres[2] - centres[0]
    if ux * vy == uy * vx:
        return None
    side_i, side_j, side_k = (math.dist(centres[m], centres[n]) for m, n in ((1, 2), (0, 2), (0, 1)))
    alpha = math.acos((side_i**2 + side_k**2 - side_j**2) / (2 * side_i * side_k))
    beta = math.acos((side_i**2 + side_j**2 - side_k**2) / (2 * side_i * side_j))
    return np.array([*(areas / side_i), math.degrees(alpha), math.degrees(beta)])
