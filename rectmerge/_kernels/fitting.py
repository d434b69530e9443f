"""Gauss-Newton on placements (a, b, tx, ty): onto a distance field, and onto the surface of walls."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import NO, YES, kernel

MAX_STEP = 0.1  # radians, and log scale, in one Gauss-Newton step; by hand, no data
MIN_FACING_COS = 0.7  # of the angle between the normals of partners; by hand, no data


@kernel
def solve(matrix: NDArray[np.float64], vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve a small dense system by elimination with pivoting; a singular one gives huge numbers, not an error."""
    m, y = matrix.copy(), vector.copy()
    n = len(y)
    for i in range(n):
        p = i
        for r in range(i + 1, n):
            if abs(m[r, i]) > abs(m[p, i]):
                p = r
        for c in range(n):
            m[i, c], m[p, c] = m[p, c], m[i, c]
        y[i], y[p] = y[p], y[i]
        if m[i, i] == 0:
            m[i, i] = 1e-12
        for r in range(i + 1, n):
            f = m[r, i] / m[i, i]
            for c in range(i, n):
                m[r, c] -= f * m[i, c]
            y[r] -= f * y[i]
    for i in range(n - 1, -1, -1):
        for c in range(i + 1, n):
            y[i] -= m[i, c] * y[c]
        y[i] /= m[i, i]
    return y


@kernel
def inverse(placement: tuple[float, float, float, float]) -> tuple[float, float, float, float]:
    """Invert a placement."""
    a, b, tx, ty = placement
    square = a * a + b * b
    return a / square, -b / square, -(a * tx + b * ty) / square, (b * tx - a * ty) / square


@kernel
def slopes(
    to_other: tuple[float, float, float, float], x: float, y: float, gx: float, gy: float, backward: bool
) -> tuple[float, float, float, float]:
    """Return the slopes of a residual with gradient (gx, gy) in the turn, the log scale and the shift of a placement.

    `to_other` is the placement, or backward its inverse, and has taken a point to (x, y).
    """
    a, b, tx, ty = to_other
    if not backward:
        x, y = x - tx, y - ty
        return gy * x - gx * y, gx * x + gy * y, gx, gy
    return gx * y - gy * x, -(gx * x + gy * y), -gx * a - gy * b, gx * b - gy * a


@kernel
def add_normal_equations(
    matrix: NDArray[np.float64], vector: NDArray[np.float64], row: tuple[float, float, float, float], w: float, d: float
) -> None:
    """Add one weighted residual to the normal equations."""
    for i in range(4):
        vector[i] += w * row[i] * d
        for j in range(4):
            matrix[i, j] += w * row[i] * row[j]


@kernel
def add_field(
    matrix: NDArray[np.float64],
    vector: NDArray[np.float64],
    to_other: tuple[float, float, float, float],
    points: NDArray[np.float64],
    distance: NDArray[np.float32],
    known: NDArray[np.bool_],
    reach: float,
    weight: float,
    backward: bool,
) -> None:
    """Add the points' distances to the other map's walls, where it is known there and they are within reach."""
    height, width = distance.shape
    a, b, tx, ty = to_other
    sharpness = 1 / (reach * reach)
    for k in range(len(points)):
        x, y = a * points[k, 0] - b * points[k, 1] + tx, b * points[k, 0] + a * points[k, 1] + ty
        if x < 1 or y < 1 or x >= width - 2 or y >= height - 2:
            continue
        u, v = int(x), int(y)
        if not known[v, u]:
            continue
        p, q = x - u, y - v
        d00, d01, d10, d11 = distance[v, u], distance[v, u + 1], distance[v + 1, u], distance[v + 1, u + 1]
        d = (d00 * (1 - p) + d01 * p) * (1 - q) + (d10 * (1 - p) + d11 * p) * q
        if d >= reach:
            continue
        gx, gy = (d01 - d00) * (1 - q) + (d11 - d10) * q, (d10 - d00) * (1 - p) + (d11 - d01) * p
        w = weight * (1 - d * d * sharpness) ** 2  # Tukey's biweight
        add_normal_equations(matrix, vector, slopes(to_other, x, y, gx, gy, backward), w, d)


@kernel
def stepped(
    placement: tuple[float, float, float, float],
    step: NDArray[np.float64],
    longest: float,
    bounds: tuple[float, float],
) -> tuple[float, float, float, float]:
    """Take a limited step against the gradient, the scale kept within its bounds."""
    a, b, tx, ty = placement
    turn = min(max(-step[0], -MAX_STEP), MAX_STEP)
    grow = min(max(-step[1], -MAX_STEP), MAX_STEP)
    cos, sin = math.cos(turn) * math.exp(grow), math.sin(turn) * math.exp(grow)
    a, b = a * cos - b * sin, a * sin + b * cos
    scale = math.hypot(a, b)
    fit = min(max(scale, bounds[0]), bounds[1]) / scale
    dx, dy = min(max(-step[2], -longest), longest), min(max(-step[3], -longest), longest)
    return a * fit, b * fit, tx + dx, ty + dy


@kernel
def fit_to_fields(
    placements: NDArray[np.float64],
    points_b: NDArray[np.float64],
    distance_a: NDArray[np.float32],
    known_a: NDArray[np.bool_],
    points_a: NDArray[np.float64],
    distance_b: NDArray[np.float32],
    known_b: NDArray[np.bool_],
    reaches: NDArray[np.float64],
    bounds: tuple[float, float],
) -> None:
    """Refine placements in place, one Gauss-Newton step per reach: each map's walls onto the other's distance field."""
    matrix, vector = np.empty((4, 4)), np.empty(4)
    for i in range(len(placements)):
        p = (placements[i, 0], placements[i, 1], placements[i, 2], placements[i, 3])
        for reach in reaches:
            matrix[:] = 0
            vector[:] = 0
            scale = math.hypot(p[0], p[1])
            add_field(matrix, vector, p, points_b, distance_a, known_a, reach, 1.0, NO)
            add_field(matrix, vector, inverse(p), points_a, distance_b, known_b, reach / scale, scale * scale, YES)
            for k in range(4):
                matrix[k, k] += 1e-6 * matrix[k, k] + (1.0 if k < 2 else 1e-9)
            p = stepped(p, solve(matrix, vector), 3 * reach, bounds)
        placements[i, 0], placements[i, 1], placements[i, 2], placements[i, 3] = p  # a whole row takes 2 s to compile


@kernel
def nearest_facing(
    index: NDArray[np.int32], surface: NDArray[np.float64], x: float, y: float, nx: float, ny: float, reach: float
) -> int:
    """Find the nearest surface cell within reach that faces in about the same direction; -1 where there is none."""
    height, width = index.shape
    u, v = math.floor(x + 0.5), math.floor(y + 0.5)
    best, best_square = -1, reach * reach
    for ring in range(int(reach) + 2):
        if (ring - 0.5) ** 2 > best_square and ring > 0:
            break
        for i in range(max(0, v - ring), min(height, v + ring + 1)):
            edge = i == v - ring or i == v + ring
            step = 1 if edge or ring == 0 else 2 * ring
            for j in range(u - ring, u + ring + 1, step):
                if j < 0 or j >= width or index[i, j] < 0:
                    continue
                k = index[i, j]
                if surface[k, 2] * nx + surface[k, 3] * ny < MIN_FACING_COS:
                    continue
                square = (surface[k, 0] - x) ** 2 + (surface[k, 1] - y) ** 2
                if square < best_square:
                    best, best_square = k, square
    return best


@kernel
def add_surface(
    matrix: NDArray[np.float64],
    vector: NDArray[np.float64],
    to_other: tuple[float, float, float, float],
    points: NDArray[np.float64],
    index: NDArray[np.int32],
    surface: NDArray[np.float64],
    known: NDArray[np.bool_],
    reach: float,
    weight: float,
    backward: bool,
    stride: int,
) -> tuple[float, int, int]:
    """Add the distances of every `stride`-th surface point to the lines of the other map's surface that faces the same.

    Returns the weighted sum of squares, the number of matched points, and the number of those that match or fall on
    `known` cells.
    """
    height, width = index.shape
    a, b, tx, ty = to_other
    scale = math.hypot(a, b)
    cos, sin = a / scale, b / scale
    squares, matched, inside = 0.0, 0, 0
    for k in range(0, len(points), stride):
        x, y = a * points[k, 0] - b * points[k, 1] + tx, b * points[k, 0] + a * points[k, 1] + ty
        u, v = math.floor(x + 0.5), math.floor(y + 0.5)
        if u < 0 or v < 0 or u >= width or v >= height:
            continue
        nx, ny = cos * points[k, 2] - sin * points[k, 3], sin * points[k, 2] + cos * points[k, 3]
        at = nearest_facing(index, surface, x, y, nx, ny, reach)
        if at < 0:
            inside += known[v, u]
            continue
        inside += 1
        matched += 1
        gx, gy = surface[at, 2], surface[at, 3]
        d = gx * (x - surface[at, 0]) + gy * (y - surface[at, 1])
        w = weight * max(0.0, 1 - (d / reach) ** 2) ** 2
        squares += w * d * d
        add_normal_equations(matrix, vector, slopes(to_other, x, y, gx, gy, backward), w, d)
    return squares, matched, inside


@kernel
def set_equations(
    matrix: NDArray[np.float64],
    vector: NDArray[np.float64],
    placement: tuple[float, float, float, float],
    points_b: NDArray[np.float64],
    index_a: NDArray[np.int32],
    surface_a: NDArray[np.float64],
    known_a: NDArray[np.bool_],
    points_a: NDArray[np.float64],
    index_b: NDArray[np.int32],
    surface_b: NDArray[np.float64],
    known_b: NDArray[np.bool_],
    reach: float,
    stride: int,
) -> tuple[float, int, int]:
    """Set the normal equations to those of each map's surface on the other's; return the result of `add_surface`."""
    matrix[:] = 0
    vector[:] = 0
    scale = math.hypot(placement[0], placement[1])
    near = max(1.5, reach / scale)
    back = inverse(placement)
    on_a = add_surface(matrix, vector, placement, points_b, index_a, surface_a, known_a, reach, 1.0, NO, stride)
    on_b = add_surface(matrix, vector, back, points_a, index_b, surface_b, known_b, near, scale * scale, YES, stride)
    return on_a[0] + on_b[0], on_a[1] + on_b[1], on_a[2] + on_b[2]


@kernel
def fit_to_surfaces(
    placement: tuple[float, float, float, float],
    points_b: NDArray[np.float64],
    index_a: NDArray[np.int32],
    surface_a: NDArray[np.float64],
    known_a: NDArray[np.bool_],
    points_a: NDArray[np.float64],
    index_b: NDArray[np.int32],
    surface_b: NDArray[np.float64],
    known_b: NDArray[np.bool_],
    reaches: NDArray[np.float64],
    bounds: tuple[float, float],
    strides: NDArray[np.int64],
    least_matched: float,
) -> tuple[tuple[float, float, float, float], NDArray[np.float64], float, int, int]:
    """Refine one placement, a Gauss-Newton step per reach, each map's surface onto the other's.

    Of the points, every `strides[k]`-th is used in step k.
    Ends early where less than `least_matched` of the surface on known cells of the other map finds a partner.
    Returns the placement, the last normal matrix, its mean squared residual, and the points matched of those inside.
    """
    p = placement
    matrix, vector = np.zeros((4, 4)), np.zeros(4)
    squares, matched, inside = 0.0, 0, 0
    for step in range(len(reaches)):
        squares, matched, inside = set_equations(
            matrix, vector, p, points_b, index_a, surface_a, known_a, points_a, index_b, surface_b, known_b,
            reaches[step], strides[step],
        )  # fmt: skip
        if matched < least_matched * inside:
            break
        damped = matrix.copy()
        for k in range(4):
            damped[k, k] += 1e-9 * damped[k, k] + 1e-9
        p = stepped(p, solve(damped, vector), reaches[step], bounds)
    return p, matrix, squares / max(1, matched), matched, inside
