"""Algorithm 3: the rotation that aligns the edges of the free space with the axes of the grid."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from rectmerge.errors import InputError
from rectmerge.paper.edges import FACING, EdgeLines, edge_lines, edge_points, edge_rectangles
from rectmerge.paper.rmap import RMap

LARGEST_TURN = math.radians(44.5)  # the branch of Lambda: -45 degrees rather than 45, as in figure 5


@dataclass(frozen=True, slots=True)
class Orientation:
    """Result of Algorithm 3.

    Parameters
    ----------
    turn
        Lambda: radians to turn the map, counter-clockwise to the eye, from -45.5 to 44.5 degrees.
    inliers
        Inliers of the deciding line.
    label
        The rectangle in the middle of the empty space of this line.
    line, facing_line
        The two parallel lines, each as ((u1, v1), (u2, v2)).
    is_cut
        Whether rectangles of an edge were left out, as there were too many.
    """

    turn: float
    inliers: int
    label: int
    line: tuple[tuple[float, float], tuple[float, float]]
    facing_line: tuple[tuple[float, float], tuple[float, float]]
    is_cut: bool = False


def orthogonal_orientation(
    rectangles: RMap,
    *,
    n_rectangles: int = 10,
    tau_cells: float = 1.5,
    slope_tolerance_deg: float = 0.5,
    path_depth: int | None = None,
    max_edge_points: int = 150,
    walled_share: float = 0.5,
) -> Orientation | None:
    """Find the rotation that makes the edges of the free space orthogonal (Algorithm 3).

    Parameters
    ----------
    rectangles
        The R-map of the map as given.
    n_rectangles
        Number of the largest rectangles taken as centres of empty spaces (the paper's N, 5 to 10).
    tau_cells
        Tolerance of a line's region, in cells.
    slope_tolerance_deg
        Lines on facing edges within this count as parallel, in degrees.
    path_depth
        As in `edge_rectangles`.
    max_edge_points
        Largest rectangles of an edge that are used; the count of inliers is cubic in them.
    walled_share
        Share of a side that must border no free cell, for the side of a rectangle to be an edge of the free space.

    Returns
    -------
    Orientation or None
        None where no edge has a line parallel to a line on the facing edge: the paper's first condition.

    Raises
    ------
    InputError
        If a tolerance is negative.

    Notes
    -----
    Departs from the paper: inliers are counted per line, angles are compared modulo 180 degrees, and the turn is the
    smallest one that aligns, where the paper returns -26.6 degrees in one place and 63.4 in another. An edge with
    more than `max_edge_points` rectangles keeps the largest. A map that is orthogonal already gets the slope of some
    staircase; without one, the sides of the largest rectangle are parallel edges if walls bound two facing sides.
    """
    if tau_cells < 0 or slope_tolerance_deg < 0:
        raise InputError(f"tolerances must be >= 0, got {tau_cells} cells and {slope_tolerance_deg} degrees")
    best, is_cut = None, False  # Alg. 3, lines 2-3
    for label in range(1, min(n_rectangles, len(rectangles)) + 1):  # Alg. 3, line 4
        edges = edge_rectangles(rectangles, label, path_depth=path_depth)  # Alg. 3, line 5
        lines = {  # Alg. 3, line 6
            edge: edge_lines(edge_points(rectangles, labels[:max_edge_points], edge), tau_cells=tau_cells)
            for edge, labels in edges.items()
        }
        is_cut |= any(len(labels) > max_edge_points for labels in edges.values())
        for edge, facing in FACING:  # Alg. 3, lines 22-23
            for here, there in ((lines[edge], lines[facing]), (lines[facing], lines[edge])):
                valid = _best_valid(here, there, math.radians(slope_tolerance_deg))
                if valid and (best is None or here.inliers[valid[0]] > best.inliers):  # Alg. 3, line 24
                    best = _orientation(label, here, there, *valid)
    best = best or _axis_parallel(rectangles, walled_share)
    return best and replace(best, is_cut=is_cut)


def _best_valid(here: EdgeLines, there: EdgeLines, tolerance: float) -> tuple[int, int] | None:
    """Find the line with most inliers that has a parallel on the facing edge, and the best of the parallels."""
    for line in np.argsort(-here.inliers, kind="stable"):
        gap = np.abs(np.remainder(there.angles - here.angles[line] + math.pi / 2, math.pi) - math.pi / 2)
        parallel = np.flatnonzero(gap <= tolerance)
        if len(parallel):
            return int(line), int(parallel[np.argmax(there.inliers[parallel])])
    return None


def _axis_parallel(rectangles: RMap, walled_share: float) -> Orientation | None:
    """Take facing sides of the largest rectangle as parallel edges along the axes, where walls bound both."""
    if len(rectangles) == 0:
        return None
    x, y, w, h = rectangles.boxes[0].tolist()
    framed = np.pad(rectangles.labels, 1)
    up, down = framed[y, x + 1 : x + w + 1], framed[y + h + 1, x + 1 : x + w + 1]
    left, right = framed[y + 1 : y + h + 1, x], framed[y + 1 : y + h + 1, x + w + 1]
    if min((up == 0).mean(), (down == 0).mean()) >= walled_share:
        return Orientation(0.0, 0, 1, ((x, y), (x + w, y)), ((x, y + h), (x + w, y + h)))
    if min((left == 0).mean(), (right == 0).mean()) >= walled_share:
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
    lines of that angle to an axis. Of two turns by about 45 degrees the negative one is taken, as in figure 5.
    """
    turn = math.remainder(angle, math.pi / 2)
    return turn if turn < LARGEST_TURN else turn - math.pi / 2
