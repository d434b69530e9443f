"""Algorithm 4: the most similar triangles of both maps, with the centres of three rectangles as vertices."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError


@dataclass(frozen=True, slots=True)
class SharedTriangles:
    """Best set of shared triangles (eq. 12), in the order of size in map 1.

    Parameters
    ----------
    first, second
        Labels of the three rectangles of each map, from 1.
    cost
        J of eq. 11.
    combinations
        Number of triangles of the listed rectangles of map 1 (eq. 9).
    is_cut
        Whether a limit excluded some triangles from the comparison.
    """

    first: tuple[int, int, int]
    second: tuple[int, int, int]
    cost: float
    combinations: int
    is_cut: bool


def corresponding(
    first: NDArray[np.int32], second: NDArray[np.int32], *, delta_cells: float, swap_sides: bool = False
) -> NDArray[np.bool_]:
    """Compare the sides of all rectangles of both maps within a tolerance (eq. 8).

    Parameters
    ----------
    first, second
        Rectangles (x, y, w, h), shape (N, 4) and (M, 4).
    delta_cells
        Tolerance of width and of height.
    swap_sides
        Also compare w with h, as needed where a quarter turn lies between the maps.

    Returns
    -------
    NDArray
        Shape (N, M): True where a rectangle of map 2 corresponds to one of map 1.
    """
    sides_1, sides_2 = first[:, None, 2:].astype(np.int64), second[None, :, 2:].astype(np.int64)
    alike: NDArray[np.bool_] = (np.abs(sides_1 - sides_2) <= delta_cells).all(axis=2)  # eq. (8)
    if swap_sides:
        alike |= (np.abs(sides_1 - sides_2[..., ::-1]) <= delta_cells).all(axis=2)
    return alike


def shared_triangles(
    first: NDArray[np.int32],
    second: NDArray[np.int32],
    *,
    delta_cells: float = 3.0,
    min_area_cells: int = 10,
    max_rectangles: int = 30,
    swap_sides: bool = False,
    weights: tuple[float, float, float, float, float] = (1.0, 1.0, 1.0, 1.0, 1.0),
    max_comparisons: int = 10_000_000,
) -> SharedTriangles | None:
    """Find the best set of shared triangles (Algorithm 4).

    Parameters
    ----------
    first, second
        Rectangles (x, y, w, h) of both maps, largest first, shape (N, 4) and (M, 4).
    delta_cells
        Tolerance of eq. 8.
    min_area_cells
        Smaller rectangles are left out of both lists: those near walls have no remarkable features (III-C).
    max_rectangles
        Number of the largest rectangles of each map that take part.
    swap_sides
        As in `corresponding`.
    weights
        Diagonal of W in eq. 11; the angles of FV are in degrees, areas over distance in cells.
    max_comparisons
        Comparisons of vertices after which the search stops; ten million take about a tenth of a second.

    Returns
    -------
    SharedTriangles or None
        None where no three rectangles of map 1 have three corresponding ones in map 2.

    Raises
    ------
    InputError
        If a weight or a limit is negative.

    Notes
    -----
    The cost is that of eq. 10 and 11 with W = I: areas over a distance, which depend on scale, and unsigned angles,
    which a mirror image shares. All combinations are compared, except where part of a cost exceeds the least one,
    which changes no answer. Departs from the paper: the three rectangles are distinct, degenerate triangles are
    skipped, small rectangles are left out of both lists and not only of map 1's, and limits bound the count (eq. 9 is
    cubic, and every triangle has many partners). A rectangle of map 2 keeps the place of its counterpart in map 1, so
    the triangle of map 2 need not be in the order of size, as eq. 12 has both.
    """
    from rectmerge._kernels.triangles import best_triangles

    if min(weights) < 0 or delta_cells < 0 or max_rectangles < 0:
        raise InputError(f"weights, delta_cells and max_rectangles must be >= 0, got {weights}, {delta_cells}")
    kept_1, cut_1 = _largest(first, min_area_cells, max_rectangles)
    kept_2, cut_2 = _largest(second, min_area_cells, max_rectangles)
    alike = corresponding(kept_1, kept_2, delta_cells=delta_cells, swap_sides=swap_sides)  # Alg. 4, lines 2-5
    starts = np.concatenate([[0], np.cumsum(alike.sum(axis=1))]).astype(np.int64)
    partners = np.nonzero(alike)[1].astype(np.int64)
    cost, vertices, is_stopped = best_triangles(  # Alg. 4, lines 6-16
        _vertices(kept_1), _vertices(kept_2), starts, partners, np.asarray(weights, np.float64), max_comparisons
    )
    if vertices[0] < 0:
        return None
    i, j, k, e, f, g = (int(v) + 1 for v in vertices)
    combinations = math.comb(len(kept_1), 3)  # eq. (9)
    is_cut = bool(is_stopped or cut_1 or cut_2)
    return SharedTriangles((i, j, k), (e, f, g), float(cost), combinations, is_cut)  # eq. (12); Alg. 4, line 17


def _largest(boxes: NDArray[np.int32], min_area_cells: int, most: int) -> tuple[NDArray[np.int32], bool]:
    """Keep the largest rectangles; also return whether `most` left any out."""
    kept = boxes[boxes[:, 2].astype(np.int64) * boxes[:, 3] >= min_area_cells]
    return kept[:most], len(kept) > most


def _vertices(boxes: NDArray[np.int32]) -> NDArray[np.float64]:
    """Return rows (u, v, area), with centres in pixels."""
    x, y, w, h = boxes.astype(np.float64).T
    return np.stack([x + (w - 1) / 2, y + (h - 1) / 2, w * h], axis=1)
