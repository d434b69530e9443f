"""Compiled loops of ray casting: edges in buckets, rays that walk from bucket to bucket, circles."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel

SLACK = 1e-9  # shares of an edge and of a bucket: no ray slips between two edges, no edge between two buckets


@kernel
def fill_buckets(edges: NDArray[np.float64], rows: int, cols: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Sort edges into the buckets they cross.

    `edges` (M, 4) are start x, y and extent x, y in buckets, bucket k spanning k..k+1. Bucket (row, col) holds rows
    first[row * cols + col] to first[row * cols + col + 1] of the second answer, which repeats the edges.
    """
    first = np.zeros(rows * cols + 1, dtype=np.int64)
    for m in range(edges.shape[0]):
        for row in range(*_span(edges[m, 1], edges[m, 3], rows)):
            for col in range(*_span(edges[m, 0], edges[m, 2], cols)):
                if _crosses(edges[m], row, col):
                    first[row * cols + col + 1] += 1
    first = np.cumsum(first)
    held = np.empty((first[-1], 4))
    last = first.copy()
    for m in range(edges.shape[0]):
        for row in range(*_span(edges[m, 1], edges[m, 3], rows)):
            for col in range(*_span(edges[m, 0], edges[m, 2], cols)):
                if _crosses(edges[m], row, col):
                    held[last[row * cols + col]] = edges[m]
                    last[row * cols + col] += 1
    return first, held


@kernel
def _span(start: float, extent: float, count: int) -> tuple[int, int]:
    low, high = min(start, start + extent), max(start, start + extent)
    return max(0, math.floor(low - SLACK)), min(count, math.floor(high + SLACK) + 1)


@kernel
def _crosses(edge: NDArray[np.float64], row: int, col: int) -> bool:
    """Return whether the line through an edge meets a bucket: its distance from the centre against half a bucket."""
    away = edge[2] * (row + 0.5 - edge[1]) - edge[3] * (col + 0.5 - edge[0])
    return bool(abs(away) <= (0.5 + SLACK) * (abs(edge[2]) + abs(edge[3])))


@kernel
def cast(
    x: float,
    y: float,
    along: NDArray[np.float64],
    reach: NDArray[np.float64],
    first: NDArray[np.int64],
    held: NDArray[np.float64],
    rows: int,
    cols: int,
) -> NDArray[np.float64]:
    """Intersect each ray with the edges of the buckets it crosses, the nearest first (Amanatides and Woo 1987).

    Rays start at (x, y) along unit vectors `along` (N, 2) and end at `reach` (N,), all in buckets; inf for no edge.
    """
    ranges = np.full(along.shape[0], np.inf)
    for n in range(along.shape[0]):
        best = _walk(x, y, along[n, 0], along[n, 1], reach[n], first, held, rows, cols)
        if best < reach[n]:
            ranges[n] = best
    return ranges


@kernel
def _walk(
    x: float,
    y: float,
    dx: float,
    dy: float,
    best: float,
    first: NDArray[np.int64],
    held: NDArray[np.float64],
    rows: int,
    cols: int,
) -> float:
    """Follow one ray until an edge is nearer than the next bucket; `best` at first is its reach."""
    per_x = abs(1.0 / dx) if dx != 0.0 else np.inf
    per_y = abs(1.0 / dy) if dy != 0.0 else np.inf
    at, leave = _within(x, y, dx, dy, rows, cols)
    if at > leave:
        return best
    col = min(max(math.floor(x + at * dx), 0), cols - 1)
    row = min(max(math.floor(y + at * dy), 0), rows - 1)
    step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    next_x = ((col + 1 - x) if dx > 0.0 else (x - col)) * per_x if dx != 0.0 else np.inf
    next_y = ((row + 1 - y) if dy > 0.0 else (y - row)) * per_y if dy != 0.0 else np.inf
    while at < best and 0 <= col < cols and 0 <= row < rows:
        bucket = row * cols + col
        for k in range(first[bucket], first[bucket + 1]):
            best = _meet(x, y, dx, dy, held[k, 0], held[k, 1], held[k, 2], held[k, 3], best)
        if next_x < next_y:
            at = next_x
            next_x += per_x
            col += step_x
        else:
            at = next_y
            next_y += per_y
            row += step_y
    return best


@kernel
def _within(x: float, y: float, dx: float, dy: float, rows: int, cols: int) -> tuple[float, float]:
    """Return the distances at which a ray enters and leaves the buckets; 0 to enter where it starts among them."""
    enter, leave = 0.0, np.inf
    for start, step, count in ((x, dx, cols), (y, dy, rows)):
        if step == 0.0:
            if start < 0.0 or start > count:
                leave = -1.0
            continue
        near, far = -start / step, (count - start) / step
        enter, leave = max(enter, min(near, far)), min(leave, max(near, far))
    return enter, leave


@kernel
def _meet(x: float, y: float, dx: float, dy: float, sx: float, sy: float, ex: float, ey: float, best: float) -> float:
    """Return the distance at which a ray meets an edge, or `best` where that is nearer."""
    cross = dx * ey - dy * ex
    if cross == 0.0:
        return best
    ax, ay = sx - x, sy - y
    share = (ax * dy - ay * dx) / cross
    if share < -SLACK or share > 1.0 + SLACK:
        return best
    distance = (ax * ey - ay * ex) / cross
    return distance if 0.0 < distance < best else best


@kernel
def meet_circles(
    x: float,
    y: float,
    along: NDArray[np.float64],
    centres: NDArray[np.float64],
    radius: float,
    ranges: NDArray[np.float64],
) -> None:
    """Shorten ranges, in place, to circles about `centres` (K, 2); rays from within one do not meet it."""
    for k in range(centres.shape[0]):
        ax, ay = centres[k, 0] - x, centres[k, 1] - y
        outside = ax * ax + ay * ay - radius * radius
        if outside <= 0.0:
            continue
        for n in range(along.shape[0]):
            ahead = ax * along[n, 0] + ay * along[n, 1]
            square = ahead * ahead - outside
            if ahead > 0.0 and square >= 0.0:
                ranges[n] = min(ranges[n], ahead - math.sqrt(square))
