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
def precedes(cost: float, labels: NDArray[np.int64], other_cost: float, other: NDArray[np.int64]) -> bool:
    """Check if a set of triangles costs less than another, or as much and comes first in the listing's loops."""
    if cost != other_cost:
        return cost < other_cost
    for n in range(6):
        if labels[n] != other[n]:
            return bool(labels[n] < other[n])
    return False


@kernel
def insert(cost: float, labels: NDArray[np.int64], costs: NDArray[np.float64], vertices: NDArray[np.int64]) -> None:
    """Enter a set of triangles into the sorted list of the best ones, where it belongs there."""
    slot = len(costs)
    while slot > 0 and precedes(cost, labels, costs[slot - 1], vertices[slot - 1]):
        slot -= 1
    for n in range(len(costs) - 1, slot, -1):
        costs[n], vertices[n] = costs[n - 1], vertices[n - 1]
    if slot < len(costs):
        costs[slot], vertices[slot] = cost, labels


@kernel
def complete(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    starts: NDArray[np.int64],
    partners: NDArray[np.int64],
    weights: NDArray[np.float64],
    labels: NDArray[np.int64],
    distances: tuple[float, float],
    cost_jk: float,
    costs: NDArray[np.float64],
    vertices: NDArray[np.int64],
) -> int:
    """Complete pairs (j, k), (f, g) by all i < j and their partners e < f; return the number of comparisons."""
    j, k, f, g = labels[1], labels[2], labels[4], labels[5]
    d, d2 = distances
    steps = 0
    for i in range(j):
        if is_degenerate(first[i], first[j], first[k]):
            continue
        alpha, beta = -1.0, -1.0
        for e in partners[starts[i] : starts[i + 1]]:
            if e >= f:
                break
            steps += 1
            cost = cost_jk + weights[0] * (first[i, 2] / d - second[e, 2] / d2) ** 2  # eq. (10)
            if cost > costs[-1] or is_degenerate(second[e], second[f], second[g]):
                continue
            if alpha < 0:
                alpha = vertex_angle(first[j], first[i], first[k])  # Alg. 4, line 8
                beta = vertex_angle(first[k], first[i], first[j])
            cost += weights[3] * (alpha - vertex_angle(second[f], second[e], second[g])) ** 2  # eq. (11)
            cost += weights[4] * (beta - vertex_angle(second[g], second[e], second[f])) ** 2
            if cost <= costs[-1]:
                labels[0], labels[3] = i, e
                insert(cost, labels, costs, vertices)  # Alg. 4, line 13
    return steps


@kernel
def best_triangles(
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    starts: NDArray[np.int64],
    partners: NDArray[np.int64],
    weights: NDArray[np.float64],
    max_comparisons: int,
    costs: NDArray[np.float64],
    vertices: NDArray[np.int64],
) -> bool:
    """Fill `costs` (K,) and `vertices` (K, 6) with the K best i < j < k and partners e < f < g; check for a cut search.

    `first` and `second` hold rows (u, v, area) of both maps, largest first, and `partners` ascend. The pairs (j, k),
    (f, g) fix two terms of the cost and the two distances; the third vertices add terms that are never negative.
    """
    costs[:], vertices[:] = np.inf, -1
    labels = np.empty(6, np.int64)
    steps = 0
    for k in range(len(first) - 1, 1, -1):  # Alg. 4, lines 6-7
        for j in range(k - 1, 0, -1):
            d = math.hypot(first[j, 0] - first[k, 0], first[j, 1] - first[k, 1])
            for g in partners[starts[k] : starts[k + 1]]:  # Alg. 4, lines 9-10
                for f in partners[starts[j] : starts[j + 1]]:
                    if f >= g:
                        break
                    steps += 1
                    d2 = math.hypot(second[f, 0] - second[g, 0], second[f, 1] - second[g, 1])
                    if d == 0 or d2 == 0:
                        continue
                    cost_jk = weights[1] * (first[j, 2] / d - second[f, 2] / d2) ** 2  # Alg. 4, lines 11-12
                    cost_jk += weights[2] * (first[k, 2] / d - second[g, 2] / d2) ** 2
                    if cost_jk > costs[-1]:
                        continue
                    labels[1], labels[2], labels[4], labels[5] = j, k, f, g
                    steps += complete(
                        first, second, starts, partners, weights, labels, (d, d2), cost_jk, costs, vertices
                    )
                if steps > max_comparisons:
                    return True
    return False
