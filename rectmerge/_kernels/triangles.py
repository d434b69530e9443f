"""Exhaustive comparison of the triangles of two maps, pruned where a partial cost exceeds the least one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def vertex_angle(vertex: NDArray[np.float64], p: NDArray[np.float64], q: NDArray[np.float64]) -> float:
    """Return the unsigned angle at a vertex, in degrees."""
    ax, ay, bx, by = p[0] - vertex[0], p[1] - vertex[1], q[0] - vertex[0], q[1] - vertex[1]
    return math.degrees(abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by)))


@kernel
def is_degenerate(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> bool:
    """Check if three points lie on one line."""
    return bool((b[0] - a[0]) * (c[1] - a[1]) == (b[1] - a[1]) * (c[0] - a[0]))


@kernel
def precedes(i: int, j: int, k: int, e: int, f: int, g: int, vertices: NDArray[np.int64]) -> bool:
    """Check if a set of triangles comes before `vertices` in the order of the listing's loops."""
    labels = (i, j, k, e, f, g)
    for n in range(6):
        if labels[n] != vertices[n]:
            return bool(labels[n] < vertices[n])
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
    vertices: NDArray[np.int64],
) -> tuple[float, int]:
    """Complete pairs (j, k), (f, g) by all i < j and their partners e; return the least cost and the comparisons."""
    j, k, f, g = fixed
    d, d2 = distances
    steps = 0
    for i in range(j):
        if is_degenerate(first[i], first[j], first[k]):
            continue
        alpha, beta = -1.0, -1.0
        for e in partners[starts[i] : starts[i + 1]]:
            steps += 1
            cost = cost_jk + weights[0] * (first[i, 2] / d - second[e, 2] / d2) ** 2  # eq. (10)
            if cost > best or e in (f, g) or is_degenerate(second[e], second[f], second[g]):
                continue
            if alpha < 0:
                alpha = vertex_angle(first[j], first[i], first[k])  # Alg. 4, line 8
                beta = vertex_angle(first[k], first[i], first[j])
            cost += weights[3] * (alpha - vertex_angle(second[f], second[e], second[g])) ** 2  # eq. (11)
            cost += weights[4] * (beta - vertex_angle(second[g], second[e], second[f])) ** 2
            if cost < best or (cost == best and precedes(i, j, k, e, f, g, vertices)):  # Alg. 4, line 17
                best = cost
                vertices[0], vertices[1], vertices[2] = i, j, k
                vertices[3], vertices[4], vertices[5] = e, f, g
    return best, steps


@kernel
def best_triangles(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    starts: NDArray[np.int64],
    partners: NDArray[np.int64],
    weights: NDArray[np.float64],
    max_comparisons: int,
) -> tuple[float, NDArray[np.int64], bool]:
    """Find i < j < k and their partners e, f, g with the least cost; also if `max_comparisons` cut the search.

    `first` and `second` hold rows (u, v, area) of both maps. The pairs (j, k), (f, g) fix two terms of the cost and
    the two distances; the third vertices add terms that are never negative.
    """
    count = len(first)
    best, vertices = np.inf, np.full(6, -1)
    steps = 0
    for k in range(count - 1, 1, -1):  # Alg. 4, lines 6-7
        for j in range(k - 1, 0, -1):
            d = math.hypot(first[j, 0] - first[k, 0], first[j, 1] - first[k, 1])
            for g in partners[starts[k] : starts[k + 1]]:  # Alg. 4, lines 9-10
                for f in partners[starts[j] : starts[j + 1]]:
                    steps += 1
                    d2 = math.hypot(second[f, 0] - second[g, 0], second[f, 1] - second[g, 1])
                    if f == g or d == 0 or d2 == 0:
                        continue
                    cost_jk = weights[1] * (first[j, 2] / d - second[f, 2] / d2) ** 2  # Alg. 4, lines 11-12
                    cost_jk += weights[2] * (first[k, 2] / d - second[g, 2] / d2) ** 2
                    if cost_jk > best:
                        continue
                    best, more = best_third(
                        first, second, starts, partners, weights, (j, k, f, g), (d, d2), cost_jk, best, vertices
                    )
                    steps += more
                if steps > max_comparisons:
                    return best, vertices, True
    return best, vertices, False
