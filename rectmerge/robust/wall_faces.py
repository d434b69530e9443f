"""The walls of a map by the side they face: what is seen from the left of a wall is not what is seen from the right."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.robust.distance_codes import BINS, IN_UNKNOWN, distance_codes, distance_to
from rectmerge.robust.features import Features
from rectmerge.robust.likelihood import WallNoise, gain_table

QUARTER = math.pi / 2
SEEN_FREE_CELLS = (2.0, 3.0)  # a wall faces a way if the map is free at these distances
LONG_CELLS = 25.0  # what runs on for this long is a wall, and not a thing that may have been moved
RUN_WIDTH_CELLS, RUN_GAP_CELLS = 3.0, 4.0  # how far a run may stray sideways, and be interrupted


@dataclass(frozen=True, slots=True, eq=False)
class Sides:
    """Which way each wall point of a map faces, and how far each cell is from the next wall that faces a way.

    The ways are numbered: k is ``angle + k * 90`` degrees, from u towards v in the working grid.

    Parameters
    ----------
    features
        The map.
    angle
        Of way 0, radians.
    faces
        Shape (N, 4), bool: the wall point has free space that way.
    is_long
        Shape (N, 4), bool: the face is part of a straight run of at least `LONG_CELLS`.
    codes
        Shape (4, h, w), uint8: as `Features.distance_bins`, of the distance to walls that face each way. Where the map
        is not free, `IN_UNKNOWN` more: a wall that another map has there contradicts nothing.
    counts
        Shape (4, BINS): known cells by their distance to walls that face each way.
    """

    features: Features
    angle: float
    faces: NDArray[np.bool_]
    is_long: NDArray[np.bool_]
    codes: NDArray[np.uint8]
    counts: NDArray[np.intp]

    @classmethod
    def of(cls, features: Features, angle: float) -> Sides:
        """Sort the walls of a map by the ways they face."""
        height, width = features.free.shape
        faces = np.ones((len(features.walls), 4), np.bool_)
        is_long = np.zeros_like(faces)
        codes = np.empty((4, height, width), np.uint8)
        counts = np.empty((4, BINS), np.intp)
        for k in range(4):
            way = np.array([math.cos(angle + k * QUARTER), math.sin(angle + k * QUARTER)])
            for cells in SEEN_FREE_CELLS:
                u, v = np.rint(features.walls + cells * way).astype(np.intp).T
                faces[:, k] &= features.free[v.clip(0, height - 1), u.clip(0, width - 1)]
            facing = features.walls[faces[:, k]]
            is_long[faces[:, k], k] = run_lengths(facing @ way, facing @ [-way[1], way[0]]) >= LONG_CELLS
            u, v = np.rint(facing).astype(np.intp).T
            marked = np.zeros((height, width), np.bool_)
            marked[v, u] = True
            codes[k] = distance_codes(distance_to(marked), features.free)
            counts[k] = np.bincount(codes[k][features.known] % IN_UNKNOWN, minlength=BINS)[:BINS]
        return cls(features, angle, faces, is_long, codes, counts)

    def gains(self, noise: WallNoise) -> NDArray[np.float32]:
        """Log-likelihood ratio of meeting each code, by way, shape (4, 256), nats."""
        return np.stack([gain_table(count, noise) for count in self.counts]).astype(np.float32)


def run_lengths(across: NDArray[np.float64], along: NDArray[np.float64]) -> NDArray[np.float64]:
    """Measure the straight run that each point is part of, shape (N,): points in a row along, close across."""
    if len(across) == 0:
        return np.empty(0)
    lane = np.rint(across / RUN_WIDTH_CELLS)
    order = np.lexsort((along, lane))
    breaks = (np.diff(lane[order]) != 0) | (np.diff(along[order]) > RUN_GAP_CELLS)
    run = np.concatenate([[0], np.cumsum(breaks)])
    first = np.flatnonzero(np.diff(run, prepend=-1))
    last = np.append(first[1:], len(run)) - 1
    lengths = np.empty(len(across))
    lengths[order] = (along[order][last] - along[order][first])[run]
    return lengths
