"""Random walks over placements that minimise the distances of cells of two maps to cells of the same value."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel

COORDINATES = 4  # of a placement: angle, ln scale, and the place (u, v) of the middle of B on A


@kernel
def distance_sums(
    points: NDArray[np.float64],
    same: NDArray[np.float32],
    other: NDArray[np.float32],
    cos: float,
    sin: float,
    u0: float,
    v0: float,
) -> tuple[float, float]:
    """Place points (N, 2) and return their mean distance to cells of their value, and agreeing less disagreeing cells.

    `same` and `other`, shape (H, W), hold each cell's distance to one of the points' value and to one of the opposite
    value. Beyond their border the Manhattan distance to the border is added. The second number is a share of N.
    """
    height, width = same.shape
    distance, agreement = 0.0, 0.0
    for k in range(len(points)):
        u = cos * points[k, 0] - sin * points[k, 1] + u0
        v = sin * points[k, 0] + cos * points[k, 1] + v0
        inside_u, inside_v = min(max(u, 0.0), width - 1.0), min(max(v, 0.0), height - 1.0)
        col, row = int(inside_u + 0.5), int(inside_v + 0.5)
        beyond = abs(u - inside_u) + abs(v - inside_v)
        distance += same[row, col] + beyond
        if beyond < 0.5:
            agreement += 1 if same[row, col] == 0 else -1 if other[row, col] == 0 else 0
    return distance / max(1, len(points)), agreement / max(1, len(points))


@kernel
def dissimilarity(
    at: NDArray[np.float64],
    cells_a: tuple[NDArray[np.float64], NDArray[np.float64]],
    cells_b: tuple[NDArray[np.float64], NDArray[np.float64]],
    maps_a: tuple[NDArray[np.float32], NDArray[np.float32]],
    maps_b: tuple[NDArray[np.float32], NDArray[np.float32]],
    middle: tuple[float, float],
    lock: float,
) -> float:
    """Sum the mean distances both ways over both values, and `lock` times disagreement less agreement."""
    scale = math.exp(at[1])
    cos, sin = scale * math.cos(at[0]), scale * math.sin(at[0])
    u0, v0 = at[2] - cos * middle[0] + sin * middle[1], at[3] - sin * middle[0] - cos * middle[1]
    back_cos, back_sin = cos / scale**2, -sin / scale**2
    back_u0, back_v0 = -back_cos * u0 + back_sin * v0, -back_sin * u0 - back_cos * v0
    total = 0.0
    for value in range(2):
        there, agree_there = distance_sums(cells_b[value], maps_a[value], maps_a[1 - value], cos, sin, u0, v0)
        back, agree_back = distance_sums(
            cells_a[value], maps_b[value], maps_b[1 - value], back_cos, back_sin, back_u0, back_v0
        )
        total += there + scale * back - lock * (agree_there + agree_back)
    return total


@kernel
def walk(
    history: NDArray[np.float64],
    noise: NDArray[np.float64],
    luck: NDArray[np.bool_],
    least: NDArray[np.float64],
    scale_bounds: tuple[float, float],
    cells_a: tuple[NDArray[np.float64], NDArray[np.float64]],
    cells_b: tuple[NDArray[np.float64], NDArray[np.float64]],
    maps_a: tuple[NDArray[np.float32], NDArray[np.float32]],
    maps_b: tuple[NDArray[np.float32], NDArray[np.float32]],
    middle: tuple[float, float],
    lock: float,
) -> tuple[NDArray[np.float64], float]:
    """Walk from the last of the accepted samples `history` (M, 4), which is overwritten; return the best and its value.

    A step is `noise` (K, 4) times the standard deviation of the last M accepted samples, at least `least` (4,); it is
    accepted where it is no worse, or by `luck` (K,).
    """
    count, next_slot = len(history), 0
    here = history[count - 1].copy()
    value = dissimilarity(here, cells_a, cells_b, maps_a, maps_b, middle, lock)
    best, best_value = here.copy(), value
    step, sample = np.empty(COORDINATES), np.empty(COORDINATES)
    renew = True
    for k in range(len(noise)):
        if renew:
            for i in range(COORDINATES):
                step[i] = max(least[i], history[:, i].std())
            renew = False
        for i in range(COORDINATES):
            sample[i] = here[i] + step[i] * noise[k, i]
        sample[1] = min(max(sample[1], scale_bounds[0]), scale_bounds[1])
        sample_value = dissimilarity(sample, cells_a, cells_b, maps_a, maps_b, middle, lock)
        if sample_value <= value or luck[k]:
            here[:] = sample
            value = sample_value
            history[next_slot] = sample
            next_slot = (next_slot + 1) % count
            renew = True
            if value < best_value:
                best[:] = here
                best_value = value
    return best, best_value
