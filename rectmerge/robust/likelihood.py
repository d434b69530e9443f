"""Likelihood of walls: the log-likelihood ratio of a distance to the other map's next wall."""

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
from rectmerge.robust.params import GainParams, RankParams

STEPS_PER_NAT = 1024  # likelihoods are whole numbers of this step


@dataclass(frozen=True, slots=True)
class WallNoise:
    """Distribution of the distance of a wall of one map from the same wall in the other.

    Parameters
    ----------
    spreads
        Standard deviations of equally likely Gaussians, in working cells.
    outliers
        Share of the walls that the other map does not have.
    """

    spreads: tuple[float, ...]
    outliers: float


def gain_table(counts: NDArray[np.intp], noise: WallNoise, params: GainParams) -> NDArray[np.float64]:
    """Return the log-likelihood ratio that a foreign wall point is a wall of a map, by its distance code, (256,), nats.

    The alternative is a point anywhere in the map's known area, whose distances are counted in `counts`: a wall met in
    a big empty room says more than one met among shelves, and the empty room itself says nothing. 0 where the map is
    unknown, but for what is near a wall, and along the border.
    """
    background = counts + 1.0
    background /= background.sum()
    below = [[math.erf(edge / (s * math.sqrt(2))) for edge in EDGES_CELLS] for s in noise.spreads]
    ratio = np.log((1 - noise.outliers) * np.diff(np.mean(below, axis=0)) / background + noise.outliers)
    table = np.zeros(256)
    table[:BINS] = np.minimum(ratio, params.max_nats)
    near = np.count_nonzero(EDGES_CELLS[:-1] < params.near_sigmas * min(noise.spreads))
    table[IN_UNKNOWN : IN_UNKNOWN + near] = table[:near]
    return table


def face_gains(faces: WallFaces, noise: WallNoise, params: GainParams) -> NDArray[np.float32]:
    """Return the log-likelihood ratio of meeting each code, by normal, shape (4, 256), nats."""
    return np.stack([gain_table(count, noise, params) for count in faces.counts]).astype(np.float32)


def likelihood_field(features: Features, noise: WallNoise, params: GainParams) -> NDArray[np.int32]:
    """Return the gain of a foreign wall point at each cell, whatever its normal, in 1/1024 nat, shape (h, w)."""
    table = np.rint(STEPS_PER_NAT * gain_table(features.distance_counts, noise, params)).astype(np.int32)
    return np.asarray(cv2.LUT(features.distance_bins, table), np.int32)


class WallLikelihood:
    """Log-likelihood ratio of the walls of both maps under placements of B's working grid on A's.

    Parameters
    ----------
    a, b
        The features of both maps.
    walls_a, walls_b
        Their wall points, shape (N, 2); the first ones stand for all where not all are used.
    noise
        Distance of matching walls.
    params
        Parameters of the gain of a wall point.
    """

    def __init__(
        self,
        a: Features,
        b: Features,
        walls_a: NDArray[np.float64],
        walls_b: NDArray[np.float64],
        noise: WallNoise,
        params: GainParams,
    ) -> None:
        self._walls_a = np.ascontiguousarray(walls_a.T, np.float32)
        self._walls_b = np.ascontiguousarray(walls_b.T, np.float32)
        self._field_a, self._field_b = likelihood_field(a, noise, params), likelihood_field(b, noise, params)

    def score(self, placements: NDArray[np.float64], *, most_points: int | None = None) -> NDArray[np.float64]:
        """Sum the log-likelihood ratios of both maps' wall points, shape (N,); fewer points stand for all."""
        forward = _sums(placements, self._walls_b, self._field_a, most_points)
        backward = _sums(invert(placements), self._walls_a, self._field_b, most_points)
        return forward + backward

    def score_bent(self, placements: NDArray[np.float64], params: RankParams) -> NDArray[np.float64]:
        """Sum the log-likelihood ratios where each block of walls may shift a little by itself, shape (N,).

        Under the right placement of maps that bend, every block finds its walls nearby; under a wrong one, walls that
        are not there are not found nearby either.
        """
        forward = _bent_sums(placements, self._walls_b, self._field_a, params)
        return forward + _bent_sums(invert(placements), self._walls_a, self._field_b, params)


def _bent_sums(
    placements: NDArray[np.float64], walls: NDArray[np.float32], field: NDArray[np.int32], params: RankParams
) -> NDArray[np.float64]:
    blocks = np.rint((walls - walls.mean(axis=1, keepdims=True)) / params.block_cells).astype(np.int64)
    columns, rows = blocks - blocks.min(axis=1, keepdims=True)
    block = columns * (rows.max() + 1) + rows
    order = np.argsort(block, kind="stable")
    starts = np.concatenate([[0], np.flatnonzero(np.diff(block[order])) + 1, [len(block)]])
    cost, fixed_cost = round(params.bend_cost * STEPS_PER_NAT), round(params.block_cost * STEPS_PER_NAT)
    steps = np.zeros(len(placements), np.int64)
    sorted_walls = np.ascontiguousarray(walls[:, order])
    padded = np.pad(field, 2 * params.bend_cells)
    add_bent_scores(
        placements, sorted_walls, starts, padded, params.bend_cells, params.bend_step_cells, cost, fixed_cost, steps
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
