"""Placements as rows (a, b, tx, ty), (x, y) to (a x - b y + tx, b x + a y + ty): proposals, scores, suppression."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel

SIDE_ERROR_CELLS = 0.7  # of a rectangle's side, added to the tolerance; by hand, no data
MIN_SIDE_VARIANCE = 4e-4  # of the log scale by one side; by hand, no data
ENDS = np.array([2, 0, 3, 1])  # the quarter turns from +x to the sides left, right, top, bottom
SIDES = np.array([1, 3, 0, 2])  # and back: the side at 0, 1, 2, 3 quarter turns (v down)


@kernel
def suppress(rectangles: NDArray[np.int32], order: NDArray[np.int64], iou: float, keep: int) -> NDArray[np.int64]:
    """Keep the first rectangles (x, y, w, h) in `order` that overlap no kept one by more than `iou`."""
    kept = np.empty(keep, np.int64)
    count = 0
    for i in order:
        x, y, w, h = rectangles[i]
        taken = False
        for k in kept[:count]:
            u, v, p, q = rectangles[k]
            across, down = min(x + w, u + p) - max(x, u), min(y + h, v + q) - max(y, v)
            if across > 0 and down > 0 and across * down > iou * (w * h + p * q - across * down):
                taken = True
                break
        if not taken:
            kept[count] = i
            count += 1
            if count == keep:
                break
    return kept[:count]


@kernel
def pair_by_both_sides(
    boxes_a: NDArray[np.float64],
    boxes_b: NDArray[np.float64],
    turn: float,
    swapped: bool,
    log_bounds: tuple[float, float],
    tolerance: float,
    rows: NDArray[np.float64],
    count: int,
) -> int:
    """Append the placements by rectangle pairs (cx, cy, w, h) of like aspect: scale from sides, shift from centres."""
    cos, sin = math.cos(turn), math.sin(turn)
    for i in range(len(boxes_a)):
        wa, ha = boxes_a[i, 2], boxes_a[i, 3]
        for j in range(len(boxes_b)):
            wb, hb = (boxes_b[j, 3], boxes_b[j, 2]) if swapped else (boxes_b[j, 2], boxes_b[j, 3])
            by_width, by_height = math.log(wa / wb), math.log(ha / hb)
            # a side is known to about a cell, so the log of a ratio of sides to the sum of their inverses
            doubt_w, doubt_h = 1 / wa + 1 / wb, 1 / ha + 1 / hb
            if abs(by_width - by_height) > tolerance + SIDE_ERROR_CELLS * (doubt_w + doubt_h):
                continue
            trust_w, trust_h = 1 / (doubt_w**2 + MIN_SIDE_VARIANCE), 1 / (doubt_h**2 + MIN_SIDE_VARIANCE)
            log_scale = (by_width * trust_w + by_height * trust_h) / (trust_w + trust_h)
            if log_scale < log_bounds[0] or log_scale > log_bounds[1]:
                continue
            if count == len(rows):
                return count
            a, b = math.exp(log_scale) * cos, math.exp(log_scale) * sin
            rows[count, 0], rows[count, 1] = a, b
            rows[count, 2] = boxes_a[i, 0] - a * boxes_b[j, 0] + b * boxes_b[j, 1]
            rows[count, 3] = boxes_a[i, 1] - b * boxes_b[j, 0] - a * boxes_b[j, 1]
            count += 1
    return count


@kernel
def pair_by_one_side(
    boxes_a: NDArray[np.float64],
    boxes_b: NDArray[np.float64],
    walls_a: NDArray[np.bool_],
    walls_b: NDArray[np.bool_],
    angle_a: float,
    angle_b: float,
    quarter: int,
    log_bounds: tuple[float, float],
    tolerance: float,
    rows: NDArray[np.float64],
    count: int,
) -> int:
    """Append the placements by rectangle pairs that agree in one extent only: scale from it, one other wall matched.

    A side that ends in the unknown is a lower bound, not a length: the extent used ends in walls on both maps, and so
    does the side matched across it. Sides are left, right, top, bottom in each map's aligned frame.
    """
    turn = angle_a - angle_b + quarter * math.pi / 2
    cos, sin = math.cos(turn), math.sin(turn)
    side_b = np.empty(4, np.int64)
    for side in range(4):
        side_b[side] = SIDES[(ENDS[side] - quarter) % 4]
    for i in range(len(boxes_a)):
        for j in range(len(boxes_b)):
            for axis in range(2):
                axis_b = (axis + quarter) % 2
                along_a, across_a = boxes_a[i, 2 + axis], boxes_a[i, 3 - axis]
                along_b, across_b = boxes_b[j, 2 + axis_b], boxes_b[j, 3 - axis_b]
                one, other = 2 * axis, 2 * axis + 1
                if not (
                    walls_a[i, one] and walls_a[i, other] and walls_b[j, side_b[one]] and walls_b[j, side_b[other]]
                ):
                    continue
                log_scale = math.log(along_a / along_b)
                if log_scale < log_bounds[0] or log_scale > log_bounds[1]:
                    continue
                doubt = 1 / along_a + 1 / along_b + 1 / across_a + 1 / across_b
                if abs(math.log(across_a / across_b) - log_scale) <= tolerance + SIDE_ERROR_CELLS * doubt:
                    continue  # these agree in both extents
                scale = math.exp(log_scale)
                for end in range(2):
                    side = 2 * (1 - axis) + end
                    if not (walls_a[i, side] and walls_b[j, side_b[side]]):
                        continue
                    if count == len(rows):
                        return count
                    shift = (end - 0.5) * (across_a - scale * across_b)
                    dx, dy = (0.0, shift) if axis == 0 else (shift, 0.0)
                    x = boxes_a[i, 0] + math.cos(angle_a) * dx - math.sin(angle_a) * dy
                    y = boxes_a[i, 1] + math.sin(angle_a) * dx + math.cos(angle_a) * dy
                    a, b = scale * cos, scale * sin
                    rows[count, 0], rows[count, 1] = a, b
                    rows[count, 2] = x - a * boxes_b[j, 0] + b * boxes_b[j, 1]
                    rows[count, 3] = y - b * boxes_b[j, 0] - a * boxes_b[j, 1]
                    count += 1
    return count


@kernel
def invert(placements: NDArray[np.float64]) -> NDArray[np.float64]:
    """Invert placements, shape (N, 4)."""
    back = np.empty_like(placements)
    for i in range(len(placements)):
        a, b, tx, ty = placements[i]
        square = a * a + b * b
        back[i, 0], back[i, 1] = a / square, -b / square
        back[i, 2] = -(a * tx + b * ty) / square
        back[i, 3] = (b * tx - a * ty) / square
    return back


@kernel
def add_scores(
    placements: NDArray[np.float64],
    points: NDArray[np.float32],
    field: NDArray[np.int32],
    scores: NDArray[np.int64],
) -> None:
    """Add to each placement's score the sum of the field where its points, shape (2, N), fall.

    The field is 0 along its border, which stands for everything beyond. Whole numbers, because their sums do not
    depend on the order in which a machine adds them.
    """
    height, width = field.shape
    cells = field.ravel()
    last_u, last_v = np.float32(width - 1), np.float32(height - 1)
    row = np.int32(width)
    for i in range(len(placements)):
        a, b = np.float32(placements[i, 0]), np.float32(placements[i, 1])
        tx, ty = np.float32(placements[i, 2] + 0.5), np.float32(placements[i, 3] + 0.5)
        total = np.int32(0)
        for k in range(points.shape[1]):
            x = a * points[0, k] - b * points[1, k] + tx
            y = b * points[0, k] + a * points[1, k] + ty
            x = min(max(x, np.float32(0)), last_u)
            y = min(max(y, np.float32(0)), last_v)
            total += cells[np.int32(y) * row + np.int32(x)]
        scores[i] += total


@kernel
def add_bent_scores(
    placements: NDArray[np.float64],
    points: NDArray[np.float32],
    starts: NDArray[np.int64],
    padded: NDArray[np.int32],
    reach: int,
    step: int,
    cost: int,
    fixed_cost: int,
    scores: NDArray[np.int64],
) -> None:
    """Add scores as `add_scores` does, where each block of points may shift, at a cost per point and squared cell.

    Block k holds the points from starts[k] to starts[k + 1]; shifts go to `reach` cells in steps of `step`, and any
    shift costs `fixed_cost` besides. The field is padded with zeros by twice `reach` cells.
    """
    row = np.int32(padded.shape[1])
    cells = padded.ravel()
    margin = np.float32(2 * reach)
    first_cell = np.float32(reach)
    last_u, last_v = np.float32(padded.shape[1] - reach - 1), np.float32(padded.shape[0] - reach - 1)
    at = np.empty(points.shape[1], np.int32)
    for i in range(len(placements)):
        a, b = np.float32(placements[i, 0]), np.float32(placements[i, 1])
        tx, ty = np.float32(placements[i, 2] + 0.5) + margin, np.float32(placements[i, 3] + 0.5) + margin
        for k in range(points.shape[1]):
            x = a * points[0, k] - b * points[1, k] + tx
            y = b * points[0, k] + a * points[1, k] + ty
            x = min(max(x, first_cell), last_u)
            y = min(max(y, first_cell), last_v)
            at[k] = np.int32(y) * row + np.int32(x)
        for block in range(len(starts) - 1):
            first, end = starts[block], starts[block + 1]
            best = np.int64(-(1 << 62))
            for dy in range(-reach, reach + 1, step):
                for dx in range(-reach, reach + 1, step):
                    shift = np.int32(dy * row + dx)
                    total = np.int32(0)
                    for k in range(first, end):
                        total += cells[at[k] + shift]
                    price = cost * (dx * dx + dy * dy) * (end - first) + (fixed_cost if dx != 0 or dy != 0 else 0)
                    best = max(best, np.int64(total) - price)
            scores[i] += best


@kernel
def distinct(
    placements: NDArray[np.float64], landmarks: NDArray[np.float64], apart: float, keep: int
) -> NDArray[np.int64]:
    """Keep the first placements that move some landmark by at least `apart` from where each kept one puts it."""
    kept = np.empty(keep, np.int64)
    places = np.empty((keep, len(landmarks), 2))
    mine = np.empty((len(landmarks), 2))
    count = 0
    for i in range(len(placements)):
        a, b, tx, ty = placements[i]
        for k in range(len(landmarks)):
            mine[k, 0] = a * landmarks[k, 0] - b * landmarks[k, 1] + tx
            mine[k, 1] = b * landmarks[k, 0] + a * landmarks[k, 1] + ty
        new = True
        for j in range(count):
            moved = 0.0
            for k in range(len(landmarks)):
                moved = max(moved, abs(mine[k, 0] - places[j, k, 0]), abs(mine[k, 1] - places[j, k, 1]))
            if moved < apart:
                new = False
                break
        if new:
            kept[count] = i
            for k in range(len(landmarks)):  # the assignment of a whole row takes 3 s to compile
                places[count, k, 0], places[count, k, 1] = mine[k, 0], mine[k, 1]
            count += 1
            if count == keep:
                break
    return kept[:count]
