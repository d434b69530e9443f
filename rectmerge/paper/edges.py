"""Edges of an empty space: the rectangles along them (Table I, eq. 5 and 6) and the lines between their vertices."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rectmerge.paper.rmap import SIDES, RMap, Side

Edge = Literal["NW", "NE", "SW", "SE"]
EDGES: dict[Edge, tuple[Side, Side]] = {  # vertical and horizontal direction of each edge
    "NW": ("up", "left"),
    "NE": ("up", "right"),
    "SW": ("down", "left"),
    "SE": ("down", "right"),
}
FACING: tuple[tuple[Edge, Edge], ...] = (("NW", "SE"), ("NE", "SW"))


@dataclass(frozen=True, slots=True, eq=False)
class EdgeLines:
    """All line segments between the edge-touching vertices of one edge.

    Parameters
    ----------
    points
        Vertices, shape (P, 2), (u, v) corners of cells in pixels.
    ends
        Shape (L, 2): the two points of each line, L = P (P - 1) / 2 (eq. 7).
    angles
        Shape (L,), radians in [0, pi), from u towards v.
    inliers
        Shape (L,): the line segments of the edge that lie within the tolerance along each line.
    """

    points: NDArray[np.float64]
    ends: NDArray[np.int64]
    angles: NDArray[np.float64]
    inliers: NDArray[np.int64]


def largest_neighbours(rectangles: RMap, label: int, *, longest: int = 50) -> dict[Side, list[int]]:
    """Follow the largest neighbour along each direction from a rectangle (Table I).

    Parameters
    ----------
    rectangles
        The R-map.
    label
        The rectangle to start from, counted from 1.
    longest
        Greatest length of a series; the visited rectangles end most of them sooner.

    Returns
    -------
    dict
        For "up", "down", "left" and "right" the labels in the order met; a series ends where nothing new is connected.

    Raises
    ------
    InputError
        If there is no such label.
    """
    return {side: _series(rectangles, label, side, longest) for side in SIDES}


def _series(rectangles: RMap, label: int, side: Side, longest: int) -> list[int]:
    series: list[int] = []
    visited = {label}
    while len(series) < longest:
        # labels ascend as areas fall, so the first one is the largest
        step = next((int(n) for n in rectangles.connections(label, side) if int(n) not in visited), None)
        if step is None:
            break
        series.append(step)
        visited.add(step)
        label = step
    return series


def edge_rectangles(rectangles: RMap, label: int, *, path_depth: int | None = None) -> dict[Edge, list[int]]:
    """List the rectangles that touch the four edges of the empty space around a rectangle (eq. 5 and 6).

    Parameters
    ----------
    rectangles
        The R-map.
    label
        The largest rectangle of the empty space, counted from 1.
    path_depth
        Length to which each series of largest neighbours is cut; None as in the paper: the length of the shortest
        series, but at least 1.

    Returns
    -------
    dict
        For "NW", "NE", "SW" and "SE" the labels, ascending; each holds `label` itself.
    """
    series = largest_neighbours(rectangles, label)
    depth = max(1, min(map(len, series.values()))) if path_depth is None else path_depth
    edges: dict[Edge, list[int]] = {}
    for edge, (vertical, horizontal) in EDGES.items():
        labels = {label}
        for along, outward in ((vertical, horizontal), (horizontal, vertical)):  # eq. (5)
            for member in series[along][:depth]:
                labels.add(member)
                labels.update(rectangles.connections(member, outward).tolist())
        edges[edge] = sorted(labels)  # eq. (6)
    return edges


def edge_points(rectangles: RMap, labels: list[int], edge: Edge) -> NDArray[np.float64]:
    """Return the edge-touching vertices of rectangles, shape (P, 2), (u, v) corners of cells."""
    x, y, w, h = rectangles.boxes[np.asarray(labels, np.int64) - 1].astype(np.float64).T
    vertical, horizontal = EDGES[edge]
    return np.stack([x + w * (horizontal == "right"), y + h * (vertical == "down")], axis=1)


def edge_lines(points: NDArray[np.float64], *, tau_cells: float = 1.5) -> EdgeLines:
    """Make all lines between points and count the inliers of each (Algorithm 3, lines 7-19).

    Parameters
    ----------
    points
        Shape (P, 2).
    tau_cells
        Half the height of a line's region, in cells along the minor axis.

    Notes
    -----
    Departs from the paper: a band in y is meaningless for a steep line, so the tolerance applies along the minor axis.
    With p points in the region, the lines inside it are the p (p - 1) / 2 between them, which saves the innermost loop.

    Examples
    --------
    >>> len(edge_lines(np.random.default_rng(0).random((14, 2))).inliers)
    91
    """
    from rectmerge._kernels.orientation import line_inliers

    lines = line_inliers(np.ascontiguousarray(points, dtype=np.float64), tau_cells)  # Alg. 3, lines 7-19
    return EdgeLines(points, lines[:, :2].astype(np.int64), lines[:, 2], lines[:, 3].astype(np.int64))
