"""Pass of Algorithm 5's loop: the final rotation, the scale ratio and the overlay from shared triangles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import RectMergeError
from rectmerge.paper.placed_image import PlacedImage
from rectmerge.paper.rmap import RMap
from rectmerge.paper.triangles import SharedTriangles
from rectmerge.similarity import Similarity


class ConditionError(RectMergeError):
    """Condition of the paper that is not met; the message is the reason given to the user."""


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """Shared triangles of two maps with the final rotation and the scale ratio.

    Parameters
    ----------
    triangles
        The best set of shared triangles.
    quarter_turns
        Lambda_f of map 1: quarter turns counter-clockwise to the eye, 0 to 3.
    ratio
        Factor by which map 2 is to be enlarged (eq. 13).
    centres
        Centres of the three rectangles of each map, shape (2, 3, 2), in pixels (u, v).
    """

    triangles: SharedTriangles
    quarter_turns: int
    ratio: float
    centres: NDArray[np.float64]

    def as_trace(self) -> dict[str, Any]:
        """Return the numbers that section IV prints as plain data."""
        return {
            "lambda_f_deg": 90 * self.quarter_turns,
            "delta_a": list(self.triangles.first),
            "delta_b": list(self.triangles.second),
            "min_j": self.triangles.cost,
            "triangles_a": self.triangles.combinations,
            "has_cut_triangles": self.triangles.is_cut,
        }


class Turn(NamedTuple):
    """Lambda of a map, in radians; `has_cut_edges` where Algorithm 3 left out rectangles of an edge."""

    angle: float
    has_cut_edges: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Pass:
    """Pass of the loop of Algorithm 5: one match of the shared triangles.

    Parameters
    ----------
    iteration
        Number of the iteration, from 1; all matches before a rescaling belong to one iteration.
    match
        The shared triangles with Lambda_f and the ratio.
    turns
        Lambda of both maps.
    images, rmaps
        Both maps as they were matched, and their rectangles.
    is_rescaling
        Whether the ratio is used: of a match with Lambda_f = 0, or of the best one where no orientation has that.
    """

    iteration: int
    match: Match
    turns: tuple[Turn, Turn]
    images: tuple[PlacedImage, ...]
    rmaps: tuple[RMap, ...]
    is_rescaling: bool

    @property
    def scale_after(self) -> float:
        """Cumulative ratio: the factor by which this pass and all before it enlarge map 2."""
        return self.images[1].pose.scale * (self.match.ratio if self.is_rescaling else 1.0)

    @property
    def turn_after_deg(self) -> int:
        """Sum of Lambda_f of this pass and all before it, 0 to 270 degrees."""
        upright = -self.images[0].pose.angle - self.turns[0].angle  # clockwise in pixels
        return 90 * ((round(upright / (math.pi / 2)) + self.match.quarter_turns) % 4)

    @property
    def pixels(self) -> Similarity:
        """Resulting placement, from B's pixels to A's."""
        return overlay(self.images, self.match, self.match.ratio if self.is_rescaling else 1.0)

    def is_final(self, ratio_tolerance: float) -> bool:
        """Check if the ratio is 1, which ends the loop (Algorithm 5, line 9)."""
        return self.is_rescaling and abs(self.match.ratio - 1) <= ratio_tolerance

    def as_trace(self) -> dict[str, Any]:
        """Return the numbers that section IV prints as plain data."""
        return {
            "iteration": self.iteration,
            "lambda_a_deg": math.degrees(self.turns[0].angle),
            "lambda_b_deg": math.degrees(self.turns[1].angle),
            "has_cut_edges_a": self.turns[0].has_cut_edges,
            "has_cut_edges_b": self.turns[1].has_cut_edges,
            **self.match.as_trace(),
            "ratio": self.match.ratio if self.is_rescaling else None,
            "cumulative_turn_deg": self.turn_after_deg,
            "rectangles_a": len(self.rmaps[0]),
            "rectangles_b": len(self.rmaps[1]),
            "cumulative_ratio": self.scale_after,
        }


def turn_back(step: Pass) -> PlacedImage:
    """Return map 1 turned by the Lambda_f of a pass."""
    return step.images[0].turned(step.match.quarter_turns * math.pi / 2)


def has_repeated(scales: Sequence[float]) -> bool:
    """Check if map 2 has come back to an earlier scale."""
    return any(abs(scales[-1] / before - 1) < 1e-9 for before in scales[:-1])


def match_triangles(first: RMap, second: RMap, triangles: SharedTriangles, *, median_ratio: bool = False) -> Match:
    """Compute the final rotation and the scale ratio from the shared triangles (Algorithm 5, lines 13-15).

    Parameters
    ----------
    first, second
        R-maps of both maps.
    triangles
        Their shared triangles.
    median_ratio
        Take the median over the widths and heights of all three rectangles, not the widths of the first. A repair.

    Notes
    -----
    At a quarter turn the height of map 1's rectangle is its width after the turn.
    """
    boxes = np.stack(
        [first.boxes[np.array(triangles.first) - 1], second.boxes[np.array(triangles.second) - 1]]
    )  # (2, 3, 4)
    centres = boxes[..., :2] + (boxes[..., 2:] - 1) / 2
    quarters = final_quarter_turns(centres[0], centres[1])  # Alg. 5, line 13
    sides = boxes[0, :, :1:-1] if quarters % 2 else boxes[0, :, 2:]  # of map 1 after its turn, (3, 2)
    ratios = sides / boxes[1, :, 2:]
    ratio = float(np.median(ratios) if median_ratio else ratios[0, 0])  # eq. (13); Alg. 5, line 15
    return Match(triangles, quarters, ratio, centres)


def overlay(images: Sequence[PlacedImage], match: Match, ratio: float) -> Similarity:
    """Overlap the centres of the shared rectangles (Algorithm 5, line 18).

    Parameters
    ----------
    images
        Map 1 and map 2 as they were matched.
    match
        Their shared triangles with Lambda_f.
    ratio
        Factor by which map 2 is enlarged.

    Returns
    -------
    Similarity
        From pixels of the original map 2 to pixels of the original map 1: the exact transforms of both images, with
        the translation that aligns the centroids of the two triangles.
    """
    turn = Similarity(1.0, -match.quarter_turns * math.pi / 2)  # clockwise in pixels
    rescale = Similarity(ratio, 0.0, (ratio - 1) / 2, (ratio - 1) / 2)
    target = turn.apply(match.centres[0]).mean(axis=0)  # Alg. 5, line 18
    source = rescale.apply(match.centres[1]).mean(axis=0)
    shift = Similarity(1.0, 0.0, float(target[0] - source[0]), float(target[1] - source[1]))
    return (turn @ images[0].pose).inverse() @ shift @ rescale @ images[1].pose


def final_quarter_turns(first: NDArray[np.float64], second: NDArray[np.float64]) -> int:
    """Compute Lambda_f: quarter turns, counter-clockwise to the eye, from the median of triangle 1 to that of 2.

    Parameters
    ----------
    first, second
        Centres of Delta_1, Delta_2, Delta_3 in pixels, shape (3, 2).

    Notes
    -----
    The paper's bisector-vector from Delta_1 to the midpoint of Delta_2 and Delta_3 is the median of the triangle.
    """
    (u1, v1), (u2, v2) = median_vector(first), median_vector(second)
    clockwise = math.atan2(u1 * v2 - v1 * u2, u1 * u2 + v1 * v2)  # v points down
    return round(-clockwise / (math.pi / 2)) % 4


def median_vector(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the vector from Delta_1 to the midpoint of Delta_2 and Delta_3, shape (2,)."""
    median: NDArray[np.float64] = (centres[1] + centres[2]) / 2 - centres[0]
    return median
