"""Algorithm 3: the turn that lays the edges of the free space along the axes of the grid."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.paper.rmap import SIDES, RMap, Side

Edge = Literal["NW", "NE", "SW", "SE"]
EDGES: dict[Edge, tuple[Side, Side]] = {  # vertical and horizontal direction of each edge
    "NW": ("up", "left"),
    "NE": ("up", "right"),
    "SW": ("down", "left"),
    "SE": ("down", "right"),
}
FACING: tuple[tuple[Edge, Edge], ...] = (("NW", "SE"), ("NE", "SW"))
EVEN_TURN = math.radians(44.5)  # from here on both turns are as small as each other, for all that can be told
WALLED_SHARE = 0.5  # of a side, for the side to count as an edge of the free space
MOST_EDGE_POINTS = 150  # the largest rectangles of an edge; the count of inliers is cubic in them


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


@dataclass(frozen=True, slots=True)
class Orientation:
    """The answer of Algorithm 3.

    Parameters
    ----------
    turn
        Lambda: radians to turn the map, counter-clockwise to the eye, from -45.5 to 44.5 degrees.
    inliers
        Inliers of the line that decided.
    label
        The rectangle whose empty space holds it.
    line, facing_line
        The two parallel lines, each as ((u1, v1), (u2, v2)).
    is_cut
        Whether some edge had more rectangles than are looked at.
    """

    turn: float
    inliers: int
    label: int
    line: tuple[tuple[float, float], tuple[float, float]]
    facing_line: tuple[tuple[float, float], tuple[float, float]]
    is_cut: bool = False


def largest_neighbours(found: RMap, label: int, *, longest: int = 50) -> dict[Side, list[int]]:
    """Follow the largest neighbour along each direction from a rectangle (Table I).

    Parameters
    ----------
    found
        The R-map.
    label
        Where to start, from 1.
    longest
        A series is cut after so many rectangles.

    Returns
    -------
    dict
        For "up", "down", "left" and "right" the labels in the order met; a series ends where nothing new is connected.

    Raises
    ------
    InputError
        If there is no such label.
    """
    return {side: _series(found, label, side, longest) for side in SIDES}


def _series(found: RMap, label: int, side: Side, longest: int) -> list[int]:
    series: list[int] = []
    visited = {label}
    while len(series) < longest:
        # labels ascend as areas fall, so the first one is the largest
        step = next((int(n) for n in found.connections(label, side) if int(n) not in visited), None)
        if step is None:
            break
        series.append(step)
        visited.add(step)
        label = step
    return series


def edge_rectangles(found: RMap, label: int, *, path_depth: int | None = None) -> dict[Edge, list[int]]:
    """List the rectangles that touch the four edges of the empty space around a rectangle (eq. 5 and 6).

    Parameters
    ----------
    found
        The R-map.
    label
        The largest rectangle of the empty space, from 1.
    path_depth
        How much of each series of largest neighbours counts; None as in the paper: as much as the shortest one has,
        but at least 1.

    Returns
    -------
    dict
        For "NW", "NE", "SW" and "SE" the labels, ascending; each holds `label` itself.
    """
    series = largest_neighbours(found, label)
    depth = max(1, min(map(len, series.values()))) if path_depth is None else path_depth
    edges: dict[Edge, list[int]] = {}
    for edge, (vertical, horizontal) in EDGES.items():
        labels = {label}
        for along, outward in ((vertical, horizontal), (horizontal, vertical)):  # eq. (5): e.g. UL, then LU
            for member in series[along][:depth]:
                labels.add(member)
                labels.update(found.connections(member, outward).tolist())
        edges[edge] = sorted(labels)  # eq. (6)
    return edges


def edge_points(found: RMap, labels: list[int], edge: Edge) -> NDArray[np.float64]:
    """Return the edge-touching vertices of rectangles, shape (P, 2), (u, v) corners of cells."""
    x, y, w, h = found.boxes[np.asarray(labels, np.int64) - 1].astype(np.float64).T
    vertical, horizontal = EDGES[edge]
    return np.stack([x + w * (horizontal == "right"), y + h * (vertical == "down")], axis=1)


def edge_lines(points: NDArray[np.float64], *, tau_cells: float = 1.5) -> EdgeLines:
    """Make all lines between points and count the inliers of each (Algorithm 3, lines 7-19).

    Parameters
    ----------
    points
        Shape (P, 2).
    tau_cells
        Half the width of a line's region, in cells along the axis the line is steep to.

    Notes
    -----
    Departs from the paper: a band in y means nothing for a steep line, so the band lies along the minor axis. With p
    points in the region, the lines inside it are the p (p - 1) / 2 between them, which saves the innermost loop.

    Examples
    --------
    >>> len(edge_lines(np.random.default_rng(0).random((14, 2))).inliers)
    91
    """
    from rectmerge._kernels.orientation import line_inliers

    lines = line_inliers(np.ascontiguousarray(points, dtype=np.float64), tau_cells)
    return EdgeLines(points, lines[:, :2].astype(np.int64), lines[:, 2], lines[:, 3].astype(np.int64))


def orthogonal_orientation(
    found: RMap,
    *,
    n_rectangles: int = 10,
    tau_cells: float = 1.5,
    slope_tolerance_deg: float = 0.5,
    path_depth: int | None = None,
) -> Orientation | None:
    """Find the turn that makes the edges of the free space orthogonal (Algorithm 3).

    Parameters
    ----------
    found
        The R-map of the map as it is.
    n_rectangles
        How many of the largest rectangles are taken as centres of empty spaces (the paper's N, 5 to 10).
    tau_cells
        Tolerance of a line's region, in cells.
    slope_tolerance_deg
        Lines on facing edges within this count as parallel, in degrees.
    path_depth
        As `edge_rectangles`.

    Returns
    -------
    Orientation or None
        None where no edge has a line parallel to one on the facing edge: the paper's first condition.

    Raises
    ------
    InputError
        If a tolerance is negative.

    Notes
    -----
    Departs from the paper: inliers are counted per line, angles are compared modulo 180 degrees, and the turn is the
    smallest one that aligns, where the paper returns -26.6 degrees in one place and 63.4 in another. An edge with
    more than 150 rectangles keeps the largest. A map that is orthogonal already gets the slope of some staircase;
    where it has none, the sides of the largest rectangle are parallel edges if walls bound it on two facing sides.
    """
    if tau_cells < 0 or slope_tolerance_deg < 0:
        raise InputError(f"tolerances must be >= 0, got {tau_cells} cells and {slope_tolerance_deg} degrees")
    best, is_cut = None, False
    for label in range(1, min(n_rectangles, len(found)) + 1):  # Alg. 3, line 4
        edges = edge_rectangles(found, label, path_depth=path_depth)  # line 5
        lines = {  # lines 6-20
            edge: edge_lines(edge_points(found, labels[:MOST_EDGE_POINTS], edge), tau_cells=tau_cells)
            for edge, labels in edges.items()
        }
        is_cut |= any(len(labels) > MOST_EDGE_POINTS for labels in edges.values())
        for one, other in FACING:  # lines 21-22
            for here, there in ((lines[one], lines[other]), (lines[other], lines[one])):
                valid = _best_valid(here, there, math.radians(slope_tolerance_deg))
                if valid and (best is None or here.inliers[valid[0]] > best.inliers):  # lines 23-24
                    best = _orientation(label, here, there, *valid)
    best = best or _axis_parallel(found)
    return best and replace(best, is_cut=is_cut)


def _best_valid(here: EdgeLines, there: EdgeLines, tolerance: float) -> tuple[int, int] | None:
    """Find the line with most inliers that has a parallel on the facing edge, and the best of those."""
    for line in np.argsort(-here.inliers, kind="stable"):
        gap = np.abs(np.remainder(there.angles - here.angles[line] + math.pi / 2, math.pi) - math.pi / 2)
        parallel = np.flatnonzero(gap <= tolerance)
        if len(parallel):
            return int(line), int(parallel[np.argmax(there.inliers[parallel])])
    return None


def _axis_parallel(found: RMap) -> Orientation | None:
    """See whether walls bound the largest rectangle on facing sides: these are parallel edges along the axes."""
    if len(found) == 0:
        return None
    x, y, w, h = found.boxes[0].tolist()
    framed = np.pad(found.labels, 1)
    up, down = framed[y, x + 1 : x + w + 1], framed[y + h + 1, x + 1 : x + w + 1]
    left, right = framed[y + 1 : y + h + 1, x], framed[y + 1 : y + h + 1, x + w + 1]
    if min((up == 0).mean(), (down == 0).mean()) >= WALLED_SHARE:
        return Orientation(0.0, 0, 1, ((x, y), (x + w, y)), ((x, y + h), (x + w, y + h)))
    if min((left == 0).mean(), (right == 0).mean()) >= WALLED_SHARE:
        return Orientation(0.0, 0, 1, ((x, y), (x, y + h)), ((x + w, y), (x + w, y + h)))
    return None


def _orientation(label: int, here: EdgeLines, there: EdgeLines, line: int, facing: int) -> Orientation:
    turn = smallest_turn(float(here.angles[line]))
    return Orientation(turn, int(here.inliers[line]), label, _segment(here, line), _segment(there, facing))


def _segment(lines: EdgeLines, line: int) -> tuple[tuple[float, float], tuple[float, float]]:
    (u1, v1), (u2, v2) = lines.points[lines.ends[line]].tolist()
    return (u1, v1), (u2, v2)


def smallest_turn(angle: float) -> float:
    """Return the smallest turn that brings an angle onto a multiple of a quarter turn, in radians.

    The angle is measured clockwise to the eye (u towards v), the turn counter-clockwise: turning an image by it takes
    lines of that angle to an axis. Of the two turns by 45 degrees, to half a degree, the negative one, as in figure 5.
    """
    turn = math.remainder(angle, math.pi / 2)
    return turn if turn < EVEN_TURN else turn - math.pi / 2
