"""One-to-one matches of keypoints, and the similarity with the most inliers among them."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.baselines.ranked_answer import BOUNDS_SLACK, Placement
from rectmerge.errors import InputError
from rectmerge.similarity import Similarity

AT_ONCE = 1_000_000  # hypotheses times matches that are held in memory
ROUNDS = 3  # of fitting to the inliers
FEWEST = 3  # inliers; any two matches define a similarity
Points = NDArray[np.float64]


def mutual_matches(a: NDArray[np.uint8], b: NDArray[np.uint8], finder: cv2.Feature2D) -> tuple[Points, Points]:
    """Match the keypoints of two images that are each other's nearest; return their points in A and in B, (N, 2)."""
    (keypoints_a, described_a), (keypoints_b, described_b) = (finder.detectAndCompute(image, None) for image in (a, b))
    if not keypoints_a or not keypoints_b:
        return np.empty((0, 2)), np.empty((0, 2))
    matches = cv2.BFMatcher(finder.defaultNorm(), crossCheck=True).match(described_a, described_b)
    at_a = np.array([keypoints_a[match.queryIdx].pt for match in matches]).reshape(-1, 2)
    at_b = np.array([keypoints_b[match.trainIdx].pt for match in matches]).reshape(-1, 2)
    return at_a, at_b


def agreed_similarity(
    a: Points,
    b: Points,
    *,
    scale: tuple[float, float],
    reach: float,
    samples: int,
    rng: np.random.Generator,
) -> Placement | None:
    """Find the similarity from B to A with the most inliers.

    Parameters
    ----------
    a, b
        Matched points, shape (N, 2).
    scale
        Bounds of the scale; samples further outside than 5 % are not tried.
    reach
        Largest distance of an inlier from its match, in pixels of A.
    samples
        Pairs of matches that are drawn.
    rng
        Source of the draws.

    Returns
    -------
    Placement | None
        With the confidence inliers / (8 + 0.3 matches); None where there are fewer than three inliers.

    Notes
    -----
    M. Fischler and R. Bolles, "Random sample consensus", Communications of the ACM 24(6), 1981,
    DOI 10.1145/358669.358692; the confidence is Brown and Lowe's, 2007, DOI 10.1007/s11263-006-0002-3.
    """
    if len(a) < FEWEST:
        return None
    at_a, at_b = a @ (1, 1j), b @ (1, 1j)  # (N,): in complex numbers a similarity is w z + t
    first, second = rng.integers(len(a), size=(2, samples))
    apart = at_b[second] - at_b[first]
    turns = np.divide(at_a[second] - at_a[first], apart, out=np.zeros_like(apart), where=apart != 0)
    lo, hi = scale[0] * (1 - BOUNDS_SLACK), scale[1] * (1 + BOUNDS_SLACK)
    usable = np.flatnonzero((np.abs(turns) >= lo) & (np.abs(turns) <= hi))
    if len(usable) == 0:
        return None
    turns, shifts = turns[usable], (at_a[first] - turns * at_b[first])[usable]
    votes = [
        np.count_nonzero(np.abs(np.outer(w, at_b) + t[:, None] - at_a) < reach, axis=1)
        for w, t in zip(*(_chunks(values, len(a)) for values in (turns, shifts)), strict=True)
    ]
    best = int(np.argmax(np.concatenate(votes)))
    agrees = np.abs(turns[best] * at_b + shifts[best] - at_a) < reach
    return _fitted(a, b, agrees, reach)


def _chunks(values: NDArray[np.complex128], matches: int) -> list[NDArray[np.complex128]]:
    return np.array_split(values, -(-len(values) * matches // AT_ONCE))


def _fitted(a: Points, b: Points, agrees: NDArray[np.bool_], reach: float) -> Placement | None:
    """Fit the similarity to the inliers, then again to the inliers of that fit."""
    for _ in range(ROUNDS):
        if np.count_nonzero(agrees) < FEWEST:
            return None
        try:
            pixels = Similarity.fit(b[agrees], a[agrees])
        except InputError:  # all in one place
            return None
        agrees = np.linalg.norm(pixels.apply(b) - a, axis=1) < reach
    return Placement(pixels, float(np.count_nonzero(agrees)) / (8 + 0.3 * len(a)))
