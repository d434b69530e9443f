"""The exhaustive comparison of triangles of two maps, pruned where a partial cost cannot win."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def vertex_angle(at: NDArray[np.float64], one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the unsigned angle at a vertex, in degrees."""
    ax, ay, bx, by = one[0] - at[0], one[1] - at[1], other[0] - at[0], other[1] - at[1]
    return math.degrees(abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by)))


@kernel
def is_degenerate(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> bool:
    """Tell whether three points lie on one line."""
    return bool((b[0] - a[0]) * (c[1] - a[1]) == (b[1] - a[1]) * (c[0] - a[0]))


@kernel
def precedes(i: int, j: int, k: int, e: int, f: int, g: int, found: NDArray[np.int64]) -> bool:
    """Tell whether a set of triangles comes before `found` in the order of the listing's loops."""
    here = (i, j, k, e, f, g)
    for n in range(6):
        if here[n] != found[n]:
            return bool(here[n] < found[n])
    return False


@kernel
def best_third(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    starts: NDArray[np.int64],
    partners: NDArray[np.int64],
    weights: NDArray[np.float64],
    fixed: tuple[int, int, int, int],
    distances: tuple[float, float],
    cost_jk: float,
    best: float,
    found: NDArray[np.int64],
) -> tuple[float, int]:
    """Try all i < j with their partners e beside a pair of sides (j, k), (f, g); return the best cost and the steps."""
    j, k, f, g = fixed
    d, d2 = distances
    steps = 0
    for i in range(j):
        if is_degenerate(first[i], first[j], first[k]):
            continue
        alpha, beta = -1.0, -1.0
        for e in partners[starts[i] : starts[i + 1]]:
            steps += 1
            cost = cost_jk + weights[0] * (first[i, 2] / d - second[e, 2] / d2) ** 2
            if cost > best or e in (f, g) or is_degenerate(second[e], second[f], second[g]):
                continue
            if alpha < 0:
                alpha = vertex_angle(first[j], first[i], first[k])
                beta = vertex_angle(first[k], first[i], first[j])
            cost += weights[3] * (alpha - vertex_angle(second[f], second[e], second[g])) ** 2
            cost += weights[4] * (beta - vertex_angle(second[g], second[e], second[f])) ** 2
            if cost < best or (cost == best and precedes(i, j, k, e, f, g, found)):
                best = cost
                found[0], found[1], found[2] = i, j, k
                found[3], found[4], found[5] = e, f, g
    return best, steps


@kernel
def best_triangles(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    starts: NDArray[np.int64],
    partners: NDArray[np.int64],
    weights: NDArray[np.float64],
    most_steps: int,
) -> tuple[float, NDArray[np.int64], bool]:
    """Find i < j < k and their partners e, f, g with the least cost; also whether `most_steps` cut the search.

    `first` and `second` hold rows (u, v, area) of both maps. The pairs (j, k), (f, g) fix two terms of the cost and
    the two distances; the third vertices add terms that are never negative.
    """
    count = len(first)
    best, found = np.inf, np.full(6, -1)
    steps = 0
    for k in range(count - 1, 1, -1):
        for j in range(k - 1, 0, -1):
            d = math.hypot(first[j, 0] - first[k, 0], first[j, 1] - first[k, 1])
            for g in partners[starts[k] : starts[k + 1]]:
                for f in partners[starts[j] : starts[j + 1]]:
                    steps += 1
                    d2 = math.hypot(second[f, 0] - second[g, 0], second[f, 1] - second[g, 1])
                    if f == g or d == 0 or d2 == 0:
                        continue
                    cost_jk = weights[1] * (first[j, 2] / d - second[f, 2] / d2) ** 2
                    cost_jk += weights[2] * (first[k, 2] / d - second[g, 2] / d2) ** 2
                    if cost_jk > best:
                        continue
                    best, more = best_third(
                        first, second, starts, partners, weights, (j, k, f, g), (d, d2), cost_jk, best, found
                    )
                    steps += more
                if steps > most_steps:
                    return best, found, True
    return best, found, False
