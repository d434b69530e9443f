"""One pass of Algorithm 5's loop: match rectangles, then say how to turn map 1 and rescale map 2."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.paper.placing import PlacedImage
from rectmerge.paper.rmap import RMap
from rectmerge.paper.triangles import SharedTriangles
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """What the shared triangles of two maps say.

    Parameters
    ----------
    triangles
        The best set of shared triangles.
    quarter_turns
        Lambda_f in quarter turns counter-clockwise to the eye, 0 to 3, for map 1.
    ratio
        Eq. 13: how many times larger map 2 has to be.
    centres
        Centres of the three rectangles of each map, (u, v) pixels, shape (2, 3, 2).
    """

    triangles: SharedTriangles
    quarter_turns: int
    ratio: float
    centres: NDArray[np.float64]

    def as_trace(self) -> dict[str, Any]:
        """Return plain data for reports: the figures that the paper's section IV prints."""
        return {
            "lambda_f_deg": 90 * self.quarter_turns,
            "delta_a": list(self.triangles.first),
            "delta_b": list(self.triangles.second),
            "min_j": self.triangles.cost,
            "triangles_a": self.triangles.combinations,
            "has_cut_triangles": self.triangles.is_cut,
            "ratio": self.ratio,
        }


def match_triangles(first: RMap, second: RMap, triangles: SharedTriangles) -> Match:
    """Read the final rotation and the scale ratio from the shared triangles (Algorithm 5, lines 13-15)."""
    boxes = np.stack(
        [first.boxes[np.array(triangles.first) - 1], second.boxes[np.array(triangles.second) - 1]]
    )  # (2, 3, 4)
    centres = boxes[..., :2] + (boxes[..., 2:] - 1) / 2
    quarters = final_quarter_turns(centres[0], centres[1])
    w, h = boxes[0, 0, 2:]
    width = h if quarters % 2 else w  # as it will be once map 1 is turned
    return Match(triangles, quarters, float(width) / float(boxes[1, 0, 2]), centres)  # eq. (13)


def overlay(images: list[PlacedImage], match: Match) -> Similarity:
    """Overlap the centres of the shared rectangles (Algorithm 5, line 18).

    Parameters
    ----------
    images
        Map 1 and map 2 as they were matched.
    match
        What their shared triangles say.

    Returns
    -------
    Similarity
        From pixels of the original map 2 to pixels of the original map 1: exactly what was done to both images, with
        the translation that brings the centroids of the two triangles together.
    """
    turn = Similarity(1.0, -match.quarter_turns * math.pi / 2)  # clockwise in pixels
    rescale = Similarity(match.ratio, 0.0, (match.ratio - 1) / 2, (match.ratio - 1) / 2)
    target = turn.apply(match.centres[0]).mean(axis=0)
    source = rescale.apply(match.centres[1]).mean(axis=0)
    shift = Similarity(1.0, 0.0, float(target[0] - source[0]), float(target[1] - source[1]))
    return (turn @ images[0].pose).inverse() @ shift @ rescale @ images[1].pose


def final_quarter_turns(first: NDArray[np.float64], second: NDArray[np.float64]) -> int:
    """Find Lambda_f: the quarter turns, counter-clockwise to the eye, that take triangle 1's direction to triangle 2's.

    Parameters
    ----------
    first, second
        Centres of Delta_1, Delta_2, Delta_3 in pixels, shape (3, 2).

    Notes
    -----
    What the paper calls the bisector runs from Delta_1 to the midpoint of Delta_2 and Delta_3: the median.
    """
    (u1, v1), (u2, v2) = median_vector(first), median_vector(second)
    clockwise = math.atan2(u1 * v2 - v1 * u2, u1 * u2 + v1 * v2)  # v points down
    return round(-clockwise / (math.pi / 2)) % 4


def median_vector(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the vector from Delta_1 to the midpoint of Delta_2 and Delta_3, shape (2,)."""
    median: NDArray[np.float64] = (centres[1] + centres[2]) / 2 - centres[0]
    return median
