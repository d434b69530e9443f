"""Displacement on a lattice of uniform cubic B-splines: values, gradients, inverse, and springs that pull on it.

A lattice is (corner x, corner y, spacing, nx, ny); node (ix, iy) has the row `ix * step_x + iy * step_y` of the
coefficients, shape (nx * ny, 2). Beyond the lattice the displacement stays as on its edge.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.compiling import kernel


@kernel
def patch(at: float, corner: float, spacing: float, count: int) -> tuple[int, float, bool]:
    """Return the first of the four splines at a coordinate, the place between them (0..1), and if it is inside."""
    g = (at - corner) / spacing
    if not g > 0.0:  # not a number, too
        return 0, 0.0, g == 0.0
    if g >= count - 3:
        return count - 4, 1.0, g == count - 3
    first = int(g)
    return first, g - first, True


@kernel
def values(t: float, out: NDArray[np.float64]) -> None:
    s = 1.0 - t
    out[0] = s * s * s / 6
    out[1] = (3 * t * t * t - 6 * t * t + 4) / 6
    out[2] = (3 * s * s * s - 6 * s * s + 4) / 6
    out[3] = t * t * t / 6


@kernel
def slopes(t: float, out: NDArray[np.float64]) -> None:
    s = 1.0 - t
    out[0] = -s * s / 2
    out[1] = (3 * t * t - 4 * t) / 2
    out[2] = (4 * s - 3 * s * s) / 2
    out[3] = t * t / 2


@kernel
def displace(
    coefficients: NDArray[np.float64], corner: tuple[float, float], spacing: float, counts: tuple[int, int],
    steps: tuple[int, int], points: NDArray[np.float64],
) -> NDArray[np.float64]:  # fmt: skip
    """Return the displacement at points, (N, 2)."""
    moves = np.zeros_like(points)
    wx, wy = np.empty(4), np.empty(4)
    for i in range(len(points)):
        ix, tx, _ = patch(points[i, 0], corner[0], spacing, counts[0])
        iy, ty, _ = patch(points[i, 1], corner[1], spacing, counts[1])
        values(tx, wx)
        values(ty, wy)
        for q in range(4):
            for p in range(4):
                node = (ix + p) * steps[0] + (iy + q) * steps[1]
                moves[i, 0] += wy[q] * wx[p] * coefficients[node, 0]
                moves[i, 1] += wy[q] * wx[p] * coefficients[node, 1]
    return moves


@kernel
def displace_with_gradient(
    coefficients: NDArray[np.float64], corner: tuple[float, float], spacing: float, counts: tuple[int, int],
    steps: tuple[int, int], x: float, y: float, out: NDArray[np.float64],
) -> None:  # fmt: skip
    """Write u, v, du/dx, du/dy, dv/dx, dv/dy of one point into `out`, (6,)."""
    wx, wy, sx, sy = np.empty(4), np.empty(4), np.empty(4), np.empty(4)
    ix, tx, is_inside_x = patch(x, corner[0], spacing, counts[0])
    iy, ty, is_inside_y = patch(y, corner[1], spacing, counts[1])
    values(tx, wx)
    values(ty, wy)
    slopes(tx, sx)
    slopes(ty, sy)
    out[:] = 0.0
    for q in range(4):
        for p in range(4):
            node = (ix + p) * steps[0] + (iy + q) * steps[1]
            value = wy[q] * wx[p]
            along = wy[q] * sx[p] / spacing if is_inside_x else 0.0
            down = sy[q] * wx[p] / spacing if is_inside_y else 0.0
            for k in range(2):
                c = coefficients[node, k]
                out[k] += value * c
                out[2 + 2 * k] += along * c
                out[3 + 2 * k] += down * c


@kernel
def gradients(
    coefficients: NDArray[np.float64], corner: tuple[float, float], spacing: float, counts: tuple[int, int],
    steps: tuple[int, int], points: NDArray[np.float64],
) -> NDArray[np.float64]:  # fmt: skip
    """Return the gradient of the displacement at points: d u_i / d x_j, (N, 2, 2)."""
    found = np.empty((len(points), 2, 2))
    row = np.empty(6)
    for i in range(len(points)):
        displace_with_gradient(coefficients, corner, spacing, counts, steps, points[i, 0], points[i, 1], row)
        found[i, 0, 0], found[i, 0, 1], found[i, 1, 0], found[i, 1, 1] = row[2], row[3], row[4], row[5]
    return found


@kernel
def undo(
    coefficients: NDArray[np.float64], corner: tuple[float, float], spacing: float, counts: tuple[int, int],
    steps: tuple[int, int], targets: NDArray[np.float64], tolerance: float, most: int,
) -> NDArray[np.float64]:  # fmt: skip
    """Return the points that the displacement takes to `targets`, (N, 2), by Newton's steps, at most `most` each."""
    points = targets - displace(coefficients, corner, spacing, counts, steps, targets)
    row = np.empty(6)
    for i in range(len(points)):
        for _ in range(most):
            displace_with_gradient(coefficients, corner, spacing, counts, steps, points[i, 0], points[i, 1], row)
            rx, ry = targets[i, 0] - points[i, 0] - row[0], targets[i, 1] - points[i, 1] - row[1]
            if rx * rx + ry * ry <= tolerance * tolerance:
                break
            a, b, c, d = 1.0 + row[2], row[3], row[4], 1.0 + row[5]
            determinant = a * d - b * c
            if determinant < 0.1:  # folded here: the plain fixed-point step
                a, b, c, d, determinant = 1.0, 0.0, 0.0, 1.0, 1.0
            points[i, 0] += (d * rx - b * ry) / determinant
            points[i, 1] += (a * ry - c * rx) / determinant
    return points


@kernel
def wall_pulls(
    offsets: NDArray[np.float64], normals: NDArray[np.float64], is_pulled: NDArray[np.bool_], reach: float,
    across_weight: float, along_weight: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:  # fmt: skip
    """Return the pulls of partners across and along walls, with Tukey's weights, as `add_pulls` takes them.

    `offsets` (N, 2) lead to the partners, `normals` (N, 2) point across the walls; a distance of `reach` or more pulls
    no longer.
    """
    stiffness, force = np.zeros((len(offsets), 3)), np.zeros((len(offsets), 2))
    for i in range(len(offsets)):
        if not is_pulled[i]:
            continue
        for k in range(2):
            x, y, weight = normals[i, 0], normals[i, 1], across_weight
            if k == 1:
                x, y, weight = -y, x, along_weight
            distance = offsets[i, 0] * x + offsets[i, 1] * y
            share = max(0.0, 1.0 - (distance / reach) ** 2)
            weight *= share * share
            stiffness[i, 0] += weight * x * x
            stiffness[i, 1] += weight * x * y
            stiffness[i, 2] += weight * y * y
            force[i, 0] += weight * distance * x
            force[i, 1] += weight * distance * y
    return stiffness, force


@kernel
def add_pulls(
    band: NDArray[np.float64], right: NDArray[np.float64], coefficients: NDArray[np.float64],
    corner: tuple[float, float], spacing: float, counts: tuple[int, int], steps: tuple[int, int],
    points: NDArray[np.float64], stiffness: NDArray[np.float64], force: NDArray[np.float64],
) -> None:  # fmt: skip
    """Add springs at points to the normal equations: `M u(point) = M u_now(point) + force`, M the point's stiffness.

    `stiffness`, (N, 3), has M's xx, xy and yy; `force` is (N, 2). `band[j, d]` is the element (j + d, j) of the
    symmetric matrix, for the unknown `2 * node + axis`.
    """
    wx, wy, w = np.empty(4), np.empty(4), np.empty(16)
    at = np.empty(16, np.int64)
    for i in range(len(points)):
        xx, xy, yy = stiffness[i]
        if xx == 0.0 and yy == 0.0:
            continue
        ix, tx, _ = patch(points[i, 0], corner[0], spacing, counts[0])
        iy, ty, _ = patch(points[i, 1], corner[1], spacing, counts[1])
        values(tx, wx)
        values(ty, wy)
        ux = uy = 0.0
        for slow in range(4):
            for fast in range(4):
                p, q = (fast, slow) if steps[0] == 1 else (slow, fast)
                k = 4 * slow + fast  # nodes in ascending order
                at[k] = (ix + p) * steps[0] + (iy + q) * steps[1]
                w[k] = wy[q] * wx[p]
                ux += w[k] * coefficients[at[k], 0]
                uy += w[k] * coefficients[at[k], 1]
        fx, fy = force[i, 0] + xx * ux + xy * uy, force[i, 1] + xy * ux + yy * uy
        for k in range(16):
            j = 2 * at[k]
            right[j] += w[k] * fx
            right[j + 1] += w[k] * fy
            square = w[k] * w[k]
            band[j, 0] += square * xx
            band[j, 1] += square * xy
            band[j + 1, 0] += square * yy
            for m in range(k + 1, 16):
                d = 2 * at[m] - j
                product = w[k] * w[m]
                band[j, d] += product * xx
                band[j, d + 1] += product * xy
                band[j + 1, d - 1] += product * xy
                band[j + 1, d] += product * yy


@kernel
def add_blocks(
    band: NDArray[np.float64], counts: tuple[int, int], steps: tuple[int, int], block: NDArray[np.float64]
) -> None:
    """Add one quadratic form, (4, 4, 2, 4, 4, 2) over (y, x, axis) twice, for every cell of the lattice."""
    for iy in range(counts[1] - 3):
        for ix in range(counts[0] - 3):
            for q in range(4):
                for p in range(4):
                    j = 2 * ((ix + p) * steps[0] + (iy + q) * steps[1])
                    for s in range(4):
                        for r in range(4):
                            i = 2 * ((ix + r) * steps[0] + (iy + s) * steps[1])
                            for e in range(2):
                                for f in range(2):
                                    if i + f >= j + e:
                                        band[j + e, i + f - j - e] += block[q, p, e, s, r, f]
