"""Compiled loops of scan matching: an exact search of a window in two levels, and Gauss-Newton on a smooth field."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def search(
    field: NDArray[np.float32],
    best_near: NDArray[np.float32],
    block: int,
    points: NDArray[np.float64],
    guess: NDArray[np.float64],
    turns: NDArray[np.float64],
    half: int,
    shift_price: float,
    turn_price: float,
) -> NDArray[np.float64]:
    """Find the turn and whole-cell shift about a guess with the largest mean of a field under points.

    All lengths are in cells. `best_near[r, c]` is the largest value of `field[r : r + block, c : c + block]`, so a sum
    over it bounds a block of shifts. A candidate's value is the mean of the field under the points, less a price per
    squared cell and squared radian. Returns (column, row, yaw, value).
    """
    per_side = (2 * half + block) // block
    tiles = len(turns) * per_side * per_side
    cells = np.empty((len(turns), len(points), 2), dtype=np.int64)
    bounds = np.empty(tiles)
    for k in range(len(turns)):
        _place(points, guess[0], guess[1], guess[2] + turns[k], cells[k])
        for t in range(per_side * per_side):
            across, up = -half + block * (t % per_side), -half + block * (t // per_side)
            price = turn_price * turns[k] ** 2
            bounds[k * per_side * per_side + t] = _mean(best_near, cells[k], across, up) - price
    best = np.array([guess[0], guess[1], guess[2], -np.inf])
    for tile in np.argsort(-bounds):
        if bounds[tile] <= best[3]:
            break
        k, t = tile // (per_side * per_side), tile % (per_side * per_side)
        left, low = -half + block * (t % per_side), -half + block * (t // per_side)
        for up in range(low, min(low + block, half + 1)):
            for across in range(left, min(left + block, half + 1)):
                price = shift_price * (across * across + up * up) + turn_price * turns[k] ** 2
                value = _mean(field, cells[k], across, up) - price
                if value > best[3]:
                    best[0], best[1], best[2], best[3] = guess[0] + across, guess[1] + up, guess[2] + turns[k], value
    return best


@kernel
def _place(points: NDArray[np.float64], col: float, row: float, yaw: float, cells: NDArray[np.int64]) -> None:
    cos, sin = math.cos(yaw), math.sin(yaw)
    for n in range(len(points)):
        cells[n, 0] = math.floor(row + sin * points[n, 0] + cos * points[n, 1])
        cells[n, 1] = math.floor(col + cos * points[n, 0] - sin * points[n, 1])


@kernel
def _mean(field: NDArray[np.float32], cells: NDArray[np.int64], across: int, up: int) -> float:
    height, width = field.shape
    total = 0.0
    for n in range(len(cells)):
        row, col = cells[n, 0] + up, cells[n, 1] + across
        if 0 <= row < height and 0 <= col < width:
            total += field[row, col]
    return total / len(cells)


@kernel
def refine(
    field: NDArray[np.float32],
    points: NDArray[np.float64],
    start: NDArray[np.float64],
    guess: NDArray[np.float64],
    prior_weights: NDArray[np.float64],
    rounds: int,
    enough: float,
) -> NDArray[np.float64]:
    """Move a pose, in cells, so that the interpolated field under the points comes near 1 (damped Gauss-Newton).

    `prior_weights` (3,) weighs the squared distance to the guess in column, row and yaw. Ends after `rounds`, or when
    a step moves the farthest point by less than `enough` cells. Returns (column, row, yaw, mean of the field,
    conditioning): the least over the largest eigenvalue of the normal equations of the position.
    """
    pose, there = start.copy(), start.copy()
    farthest = 1.0
    for n in range(len(points)):
        farthest = max(farthest, math.sqrt(points[n, 0] ** 2 + points[n, 1] ** 2))
    system, other = np.empty(11), np.empty(11)
    _normal_equations(field, points, pose, guess, prior_weights, system)
    damping = 1e-3
    for _ in range(rounds):
        step = _solve(system, damping)
        for k in range(3):
            there[k] = pose[k] + step[k]
        _normal_equations(field, points, there, guess, prior_weights, other)
        if other[9] > system[9]:
            damping *= 10.0
            continue
        damping *= 0.1
        pose[:], system[:] = there, other
        if math.sqrt(step[0] ** 2 + step[1] ** 2) + farthest * abs(step[2]) < enough:
            break
    of_x, of_y = system[0] - prior_weights[0], system[3] - prior_weights[1]
    middle, apart = (of_x + of_y) / 2, math.hypot((of_x - of_y) / 2, system[1])
    conditioning = (middle - apart) / (middle + apart) if middle > 0 else 0.0
    return np.array([pose[0], pose[1], pose[2], system[10], conditioning])


@kernel
def _normal_equations(
    field: NDArray[np.float32],
    points: NDArray[np.float64],
    pose: NDArray[np.float64],
    guess: NDArray[np.float64],
    prior_weights: NDArray[np.float64],
    system: NDArray[np.float64],
) -> None:
    """Sum up J^T J as xx, xy, xt, yy, yt, tt; J^T e as x, y, t; the cost; and the field's mean."""
    height, width = field.shape
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    system[:] = 0.0
    for n in range(len(points)):
        across, up = cos * points[n, 0] - sin * points[n, 1], sin * points[n, 0] + cos * points[n, 1]
        x, y = pose[0] + across - 0.5, pose[1] + up - 0.5  # a cell's value stands at its centre
        c, r = math.floor(x), math.floor(y)
        if c < 0 or r < 0 or c >= width - 1 or r >= height - 1:
            system[9] += 1.0
            continue
        u, v = x - c, y - r
        f00, f01, f10, f11 = field[r, c], field[r, c + 1], field[r + 1, c], field[r + 1, c + 1]
        value = (1 - v) * ((1 - u) * f00 + u * f01) + v * ((1 - u) * f10 + u * f11)
        gx = (1 - v) * (f01 - f00) + v * (f11 - f10)
        gy = (1 - u) * (f10 - f00) + u * (f11 - f01)
        gt = across * gy - up * gx
        error = 1.0 - value
        system[0] += gx * gx
        system[1] += gx * gy
        system[2] += gx * gt
        system[3] += gy * gy
        system[4] += gy * gt
        system[5] += gt * gt
        system[6] += gx * error
        system[7] += gy * error
        system[8] += gt * error
        system[9] += error * error
        system[10] += value / len(points)
    for k, entry in enumerate((0, 3, 5)):
        system[entry] += prior_weights[k]
        system[6 + k] += prior_weights[k] * (guess[k] - pose[k])
        system[9] += prior_weights[k] * (guess[k] - pose[k]) ** 2


@kernel
def _solve(system: NDArray[np.float64], damping: float) -> tuple[float, float, float]:
    """Solve the symmetric 3 x 3 system, its diagonal enlarged, by its cofactors; no step where it is singular."""
    b, c, e = system[1], system[2], system[4]
    a, d, f = system[0] * (1 + damping), system[3] * (1 + damping), system[5] * (1 + damping)
    p, q, r = d * f - e * e, c * e - b * f, b * e - c * d
    det = a * p + b * q + c * r
    if det <= 1e-12 * a * d * f:
        return 0.0, 0.0, 0.0
    x = (p * system[6] + q * system[7] + r * system[8]) / det
    y = (q * system[6] + (a * f - c * c) * system[7] + (b * c - a * e) * system[8]) / det
    t = (r * system[6] + (b * c - a * e) * system[7] + (a * d - b * b) * system[8]) / det
    return x, y, t
