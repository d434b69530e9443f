"""Algorithm 4: the most similar triangles of both maps, with the centres of three rectangles as vertices."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError


@dataclass(frozen=True, slots=True)
class SharedTriangles:
    """Set of shared triangles (eq. 12), each in the order of size.

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
    first: NDArray[np.int32],
    second: NDArray[np.int32],
    *,
    delta_cells: float,
    side_share: float = 0.0,
    swap_sides: bool = False,
) -> NDArray[np.bool_]:
    """Compare the sides of all rectangles of both maps within a tolerance (eq. 8).

    Parameters
    ----------
    first, second
        Rectangles (x, y, w, h), shape (N, 4) and (M, 4).
    delta_cells
        Tolerance of width and of height.
    side_share
        Tolerance as a share of the longer of two sides, in place of `delta_cells`; 0 as in the paper. A repair.
    swap_sides
        Also compare w with h, as needed where a quarter turn lies between the maps. A repair.

    Returns
    -------
    NDArray
        Shape (N, M): True where a rectangle of map 2 corresponds to one of map 1.

    Notes
    -----
    Width and height have to agree, which the paper writes as an intersection.

    Examples
    --------
    The ratios 33/32 and 38/33 of section IV are of sides that eq. 8 has to list:

    >>> boxes = np.array([[0, 0, 33, 20], [0, 0, 38, 20]], np.int32)
    >>> corresponding(boxes[1:], boxes[:1], delta_cells=14).item()
    True
    """
    sides_1, sides_2 = first[:, None, 2:].astype(np.int64), second[None, :, 2:].astype(np.int64)
    alike = _are_close(sides_1, sides_2, delta_cells, side_share)  # eq. (8)
    if swap_sides:
        alike |= _are_close(sides_1, sides_2[..., ::-1], delta_cells, side_share)
    return alike


def _are_close(
    first: NDArray[np.int64], second: NDArray[np.int64], delta_cells: float, side_share: float
) -> NDArray[np.bool_]:
    tolerance = side_share * np.maximum(first, second) if side_share else delta_cells
    close: NDArray[np.bool_] = (np.abs(first - second) <= tolerance).all(axis=2)  # (N, M)
    return close


def shared_triangles(
    first: NDArray[np.int32],
    second: NDArray[np.int32],
    *,
    delta_cells: float = 14.0,
    side_share: float = 0.0,
    swap_sides: bool = False,
    min_area_cells: int = 10,
    max_rectangles: int = 20,
    weights: tuple[float, float, float, float, float] = (1.0, 1.0, 1.0, 1.0, 1.0),
    max_comparisons: int = 10_000_000,
    keep: int = 1,
) -> list[SharedTriangles]:
    """Find the best sets of shared triangles (Algorithm 4).

    Parameters
    ----------
    first, second
        Rectangles (x, y, w, h) of both maps, largest first, shape (N, 4) and (M, 4).
    delta_cells, side_share, swap_sides
        As in `corresponding`.
    min_area_cells
        Smaller rectangles are left out of both lists: those near walls have no remarkable features (III-C).
    max_rectangles
        Number of the largest rectangles of each map that take part.
    weights
        Diagonal of W in eq. 11; the angles of FV are in degrees, areas over distance in cells.
    max_comparisons
        Comparisons of vertices after which the search stops; ten million take about a tenth of a second.
    keep
        Number of sets to return; 1 as in the paper.

    Returns
    -------
    list of SharedTriangles
        At most `keep`, the least cost first; empty where no three rectangles of map 1 have three in map 2.

    Raises
    ------
    InputError
        If a weight or a limit is negative.

    Notes
    -----
    The cost is that of eq. 10 and 11: areas over a distance, which depend on scale, and unsigned angles in degrees,
    which a mirror image shares. All combinations are compared, except where part of a cost exceeds the greatest one
    kept, which changes no answer. Both triangles are in the order of size, as in eq. 12: i < j < k and e < f < g, with
    e among the rectangles of map 2 that correspond to i, f to j and g to k. Departs from the paper: the three
    rectangles are distinct, degenerate triangles are skipped, small rectangles are left out of both lists and not only
    of map 1's, and limits bound the count (eq. 9 is cubic, and every triangle has many partners).
    """
    from rectmerge._kernels.triangles import best_triangles

    if min(*weights, delta_cells, side_share, max_rectangles) < 0:
        limits = f"{weights}, {delta_cells}, {side_share} and {max_rectangles}"
        raise InputError(f"weights, delta_cells, side_share and max_rectangles must be >= 0, got {limits}")
    kept_1, cut_1 = _largest(first, min_area_cells, max_rectangles)
    kept_2, cut_2 = _largest(second, min_area_cells, max_rectangles)
    alike = corresponding(
        kept_1, kept_2, delta_cells=delta_cells, side_share=side_share, swap_sides=swap_sides
    )  # Alg. 4, lines 2-5
    starts = np.concatenate([[0], np.cumsum(alike.sum(axis=1))]).astype(np.int64)
    partners = np.nonzero(alike)[1].astype(np.int64)
    costs, vertices = np.empty(keep), np.empty((keep, 6), np.int64)
    is_stopped = best_triangles(  # Alg. 4, lines 6-16
        _vertices(kept_1), _vertices(kept_2), starts, partners, np.asarray(weights), max_comparisons, costs, vertices
    )
    combinations = math.comb(len(kept_1), 3)  # eq. (9)
    is_cut = bool(is_stopped or cut_1 or cut_2)
    return [  # eq. (12); Alg. 4, line 17
        SharedTriangles((i, j, k), (e, f, g), cost, combinations, is_cut)
        for cost, (i, j, k, e, f, g) in zip(costs.tolist(), (vertices + 1).tolist(), strict=True)
        if cost < math.inf
    ]


def _largest(boxes: NDArray[np.int32], min_area_cells: int, most: int) -> tuple[NDArray[np.int32], bool]:
    """Keep the largest rectangles; also return whether `most` left any out."""
    kept = boxes[boxes[:, 2].astype(np.int64) * boxes[:, 3] >= min_area_cells]
    return kept[:most], len(kept) > most


def _vertices(boxes: NDArray[np.int32]) -> NDArray[np.float64]:
    """Return rows (u, v, area), with centres in pixels."""
    x, y, w, h = boxes.astype(np.float64).T
    return np.stack([x + (w - 1) / 2, y + (h - 1) / 2, w * h], axis=1)
