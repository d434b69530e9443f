"""How well walls explain walls: the log-likelihood ratio of a distance to the other map's next wall."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.placements import add_bent_scores, add_scores, invert
from rectmerge.analysis.distance_codes import BINS, EDGES_CELLS, IN_UNKNOWN
from rectmerge.analysis.wall_faces import WallFaces
from rectmerge.robust.features import Features

STEPS_PER_NAT = 1024  # likelihoods are whole numbers of this step
LARGEST_GAIN = 3.0
NEAR_SIGMAS = 2.5  # the unknown this close to a wall counts as known: walls have two faces


@dataclass(frozen=True, slots=True)
class WallNoise:
    """How far a wall of one map lies from the same wall in the other.

    Parameters
    ----------
    spreads
        Standard deviations of equally likely Gaussians, in working cells.
    outliers
        Share of the walls that the other map does not have.
    """

    spreads: tuple[float, ...]
    outliers: float


SEARCH_NOISE = WallNoise((1.5, 3.75), 0.25)
JUDGED_NOISES = (WallNoise((1.0,), 0.05), WallNoise((2.0,), 0.15), WallNoise((4.0,), 0.25))  # rigid, drifting, bent
BENDING_NOISE = WallNoise((1.5,), 0.2)
BLOCK_CELLS = 40.0  # maps that bend against each other fit block by block
BEND_CELLS, BEND_STEP_CELLS = 8, 2  # how far a block may shift, and in which steps
BEND_COST = 0.01  # nats per wall point and squared cell of its shift
BLOCK_COST = 6.0  # nats for each block that shifts at all: its two coordinates are fitted, not known


def gain_table(counts: NDArray[np.intp], noise: WallNoise) -> NDArray[np.float64]:
    """Log-likelihood ratio that a foreign wall point is a wall of a map, by the code of its distance, (256,), nats.

    The alternative is a point anywhere in the map's known area, whose distances are counted in `counts`: a wall met in
    a big empty room says more than one met among shelves, and the empty room itself says nothing. 0 where the map is
    unknown, but for what is near a wall, and along the border.
    """
    background = counts + 1.0
    background /= background.sum()
    below = [[math.erf(edge / (s * math.sqrt(2))) for edge in EDGES_CELLS] for s in noise.spreads]
    ratio = np.log((1 - noise.outliers) * np.diff(np.mean(below, axis=0)) / background + noise.outliers)
    table = np.zeros(256)
    table[:BINS] = np.minimum(ratio, LARGEST_GAIN)
    near = np.count_nonzero(EDGES_CELLS[:-1] < NEAR_SIGMAS * min(noise.spreads))
    table[IN_UNKNOWN : IN_UNKNOWN + near] = table[:near]
    return table


def face_gains(faces: WallFaces, noise: WallNoise) -> NDArray[np.float32]:
    """Return the log-likelihood ratio of meeting each code, by normal, shape (4, 256), nats."""
    return np.stack([gain_table(count, noise) for count in faces.counts]).astype(np.float32)


def likelihood_field(features: Features, noise: WallNoise) -> NDArray[np.int32]:
    """Gain of a foreign wall point at each cell, whichever way it faces, in 1/1024 nat, shape (h, w)."""
    table = np.rint(STEPS_PER_NAT * gain_table(features.distance_counts, noise)).astype(np.int32)
    return np.asarray(cv2.LUT(features.distance_bins, table), np.int32)


class WallLikelihood:
    """Scores placements of B's working grid on A's by the walls of both.

    Parameters
    ----------
    a, b
        The features of both maps.
    walls_a, walls_b
        Their wall points, shape (N, 2), in the order in which they are drawn where not all are asked.
    noise
        How far matching walls lie apart.
    """

    def __init__(
        self, a: Features, b: Features, walls_a: NDArray[np.float64], walls_b: NDArray[np.float64], noise: WallNoise
    ) -> None:
        self._walls_a = np.ascontiguousarray(walls_a.T, np.float32)
        self._walls_b = np.ascontiguousarray(walls_b.T, np.float32)
        self._field_a, self._field_b = likelihood_field(a, noise), likelihood_field(b, noise)

    def score(self, placements: NDArray[np.float64], *, most_points: int | None = None) -> NDArray[np.float64]:
        """Sum the log-likelihood ratios of both maps' wall points, shape (N,); fewer points stand for all."""
        forward = _sums(placements, self._walls_b, self._field_a, most_points)
        backward = _sums(invert(placements), self._walls_a, self._field_b, most_points)
        return forward + backward

    def score_bent(self, placements: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sum the log-likelihood ratios where each block of walls may shift a little by itself, shape (N,).

        Under the right placement of maps that bend, every block finds its walls nearby; under a wrong one, walls that
        are not there are not found nearby either.
        """
        forward = _bent_sums(placements, self._walls_b, self._field_a)
        return forward + _bent_sums(invert(placements), self._walls_a, self._field_b)


def _bent_sums(
    placements: NDArray[np.float64], walls: NDArray[np.float32], field: NDArray[np.int32]
) -> NDArray[np.float64]:
    columns, rows = np.floor(walls / BLOCK_CELLS).astype(np.int64)
    block = columns * (rows.max() + 1) + rows
    order = np.argsort(block, kind="stable")
    starts = np.concatenate([[0], np.flatnonzero(np.diff(block[order])) + 1, [len(block)]])
    cost, fixed_cost = round(BEND_COST * STEPS_PER_NAT), round(BLOCK_COST * STEPS_PER_NAT)
    steps = np.zeros(len(placements), np.int64)
    sorted_walls = np.ascontiguousarray(walls[:, order])
    padded = np.pad(field, 2 * BEND_CELLS)
    add_bent_scores(
        placements, sorted_walls, starts, padded, BEND_CELLS, BEND_STEP_CELLS, cost, fixed_cost, steps
    )  # fmt: skip
    sums: NDArray[np.float64] = steps / STEPS_PER_NAT
    return sums


def _sums(
    placements: NDArray[np.float64], walls: NDArray[np.float32], field: NDArray[np.int32], most: int | None
) -> NDArray[np.float64]:
    drawn = np.ascontiguousarray(walls[:, :most])
    steps = np.zeros(len(placements), np.int64)
    add_scores(placements, drawn, field, steps)
    sums: NDArray[np.float64] = steps * (walls.shape[1] / drawn.shape[1] / STEPS_PER_NAT)
    return sums
