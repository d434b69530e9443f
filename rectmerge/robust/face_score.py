"""Score of a sample of wall faces that can be bounded over whole boxes of placements."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.bounding import add_face_scores, lower_shares
from rectmerge.analysis.wall_faces import QUARTER, WallFaces
from rectmerge.robust.directions import dominant_angles
from rectmerge.robust.features import Features
from rectmerge.robust.likelihood import WallNoise, face_gains
from rectmerge.robust.params import CertificateParams, GainParams, Params
from rectmerge.robust.refinement import to_pixels
from rectmerge.similarity import Similarity

STEPS_PER_NAT = 32
POOLED_CELLS = np.array([*range(1, 9), 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96])  # sides of squares
PADDING = int(POOLED_CELLS[-1])
LEVELS = np.searchsorted(POOLED_CELLS, np.arange(PADDING + 2)).astype(np.int32)  # one more for what is larger
ZERO = 128  # of gains as unsigned bytes
UNBOUNDED = np.iinfo(np.int16).max
_NOTHING = np.zeros((1, 4, 1, 1), np.int8)
Shares = NDArray[np.int16]
Placements = NDArray[np.float64]  # (N, 4): angle, ln s, and where B's centre goes (u, v), between the working grids
Boxes = NDArray[np.float64]  # (N, 7): a placement in the middle; half widths of the angle, of ln s, and of u and v


@dataclass(frozen=True, slots=True, eq=False)
class FaceScore:
    """Sampled wall faces of two maps, and their gains pooled over squares of many sizes.

    Parameters
    ----------
    a, b
        The features of both maps.
    centre
        Of B's walls, (u, v) in its working grid.
    given
        The placement from which the ways that B's walls face are counted, shape (4,).
    spread_cells
        Of the noise.
    faces, groups
        The faces, shape (2, N), and which of them share a bound, as in `rectmerge._kernels.bounding`.
    gains
        Of A's grid and of B's: shape (levels, 4, h, w), int8, in 1/32 nat.
    """

    a: Features
    b: Features
    centre: tuple[float, float]
    given: NDArray[np.float64]
    spread_cells: float
    faces: NDArray[np.float64]
    groups: NDArray[np.int64]
    gains: tuple[NDArray[np.int8], NDArray[np.int8]]

    @classmethod
    def from_placement(cls, a: Features, b: Features, pixels: Similarity, params: Params) -> FaceScore:
        """Make ready the score under whose noise a placement, from pixels of B to pixels of A, scores highest."""
        centre = b.walls.mean(axis=0)
        at = a.offset + pixels.apply((centre - b.offset) * b.factor) / a.factor
        given = np.array([pixels.angle, math.log(pixels.scale * b.factor / a.factor), *at])
        angle = dominant_angles(a, params.prepare)[0][0]
        faces = a.faces(angle, params.faces), b.faces(angle - pixels.angle, params.faces)
        sampled = _sampled(*faces, params.certificate)
        score = cls(a, b, (float(centre[0]), float(centre[1])), given, 0.0, *sampled, (_NOTHING, _NOTHING))
        by_noise = []
        for spread in params.rank.spreads_cells:
            noise = WallNoise((spread,), params.certificate.outliers)
            gains = _gains(faces[0], noise, params.gain), _gains(faces[1], noise, params.gain)
            by_noise.append(replace(score, spread_cells=spread, gains=gains))
        best = max(by_noise, key=lambda score: score.accepted)
        return replace(best, gains=(_pooled(best.gains[0]), _pooled(best.gains[1])))

    @property
    def accepted(self) -> int:
        """The score of the given placement, in steps."""
        return int(self.of_placements(self.given[None])[0])

    def of_placements(self, placements: Placements) -> NDArray[np.int64]:
        """Score placements, in steps, shape (N,)."""
        scores = np.zeros(len(placements), np.int64)
        add_face_scores(
            placements, self._quarters(placements), self.groups, self.faces, self.centre,
            self.gains[0][0], self.gains[1][0], PADDING, scores,
        )  # fmt: skip
        return scores

    def unbounded(self, boxes: int) -> Shares:
        """Return shares of boxes before anything is known of them, shape (N, groups)."""
        return np.full((boxes, len(self.groups)), UNBOUNDED, np.int16)

    def lower(self, boxes: Boxes, shares: Shares, threshold: int) -> None:
        """Lower the shares of boxes, whose sum nothing in a box exceeds; all of them where they reach the threshold."""
        lower_shares(
            boxes, self._quarters(boxes), shares, threshold, self.groups, self.faces, self.centre,
            *self.gains, LEVELS, PADDING,
        )  # fmt: skip

    def to_pixels(self, placement: NDArray[np.float64]) -> Similarity:
        """Return a placement between the pixels of the maps."""
        linear = np.exp(complex(placement[1], placement[0]))
        shift = complex(*placement[2:]) - linear * complex(*self.centre)
        a, b, tx, ty = to_pixels(np.array([linear.real, linear.imag, shift.real, shift.imag]), self.a, self.b)
        return Similarity.from_matrix([[a, -b, tx], [b, a, ty]])

    def _quarters(self, rows: NDArray[np.float64]) -> NDArray[np.int64]:
        """Tell by how many quarter turns placements or boxes differ from the given placement, shape (N,)."""
        quarters: NDArray[np.int64] = np.rint((rows[:, 0] - self.given[0]) / QUARTER).astype(np.int64)
        return quarters


def total(shares: Shares) -> NDArray[np.int64]:
    """Add up the shares of each box, shape (N,)."""
    sums: NDArray[np.int64] = shares.sum(axis=1, dtype=np.int64)
    return sums


def _sampled(a: WallFaces, b: WallFaces, params: CertificateParams) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Sample the faces of both maps alike: B's first, by way, and groups that take turns between the maps."""
    every = -(-int(np.count_nonzero(a.faces) + np.count_nonzero(b.faces)) // params.faces) or 1
    faces: list[NDArray[np.float64]] = []
    groups: list[tuple[float, int, int, int, int]] = []
    first = 0
    for is_b, sides in ((1, b), (0, a)):
        points, ways = (each[every // 2 :: every] for each in np.nonzero(sides.faces))
        for way in range(4):
            mine = sides.walls[points[ways == way]]
            ends = first + np.linspace(0, len(mine), -(-len(mine) // params.group_faces) + 1).astype(np.intp)
            groups += [
                ((n - first) / max(1, len(points)), n, end, way, is_b) for n, end in itertools.pairwise(ends.tolist())
            ]
            faces.append(mine)
            first += len(mine)
    order = sorted(groups, key=lambda group: group[0])
    return np.ascontiguousarray(np.concatenate(faces).T), np.array([group[1:] for group in order])


def _gains(sides: WallFaces, noise: WallNoise, params: GainParams) -> NDArray[np.int8]:
    """Lay out what each way gains at each cell, shape (1, 4, h, w), with nothing to gain in a padding before them."""
    tables = np.rint(STEPS_PER_NAT * face_gains(sides, noise, params)).astype(np.int8)
    plain = np.stack([table[codes] for table, codes in zip(tables, sides.codes, strict=True)])
    return np.pad(plain, ((0, 0), (PADDING, 0), (PADDING, 0)))[None]


def _pooled(gains: NDArray[np.int8]) -> NDArray[np.int8]:
    """Find the highest gain in squares to the right of and below each cell, shape (levels, 4, h, w)."""
    pooled = np.empty((len(POOLED_CELLS) + 1, *gains.shape[1:]), np.int8)
    for way, plain in enumerate(gains[0]):
        above = (plain.astype(np.int16) + ZERO).astype(np.uint8)
        for level, side in enumerate(POOLED_CELLS):
            kernel = np.ones((side, side), np.uint8)
            highest = cv2.dilate(above, kernel, anchor=(0, 0), borderType=cv2.BORDER_CONSTANT, borderValue=ZERO)
            pooled[level, way] = (highest.astype(np.int16) - ZERO).astype(np.int8)
        pooled[-1, way] = max(0, plain.max())
    return pooled
