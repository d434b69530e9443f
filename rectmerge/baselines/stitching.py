"""Stitching of two images by OpenCV's pipeline for scans: matching, estimation, bundle adjustment."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.baselines.ranked_answer import Placement
from rectmerge.similarity import Similarity

FEWEST_KEYPOINTS = 2  # the second nearest must exist
SMALLEST_AREA = 1e-6  # a map shrunk to less of its area is a point, and a point fits anywhere


def stitch(
    a: NDArray[np.uint8], b: NDArray[np.uint8], finder: cv2.Feature2D, *, match_conf: float, seed: int
) -> Placement | None:
    """Place image B on image A.

    Parameters
    ----------
    a, b
        Images, shape (H, W).
    finder
        Detector and descriptor of keypoints.
    match_conf
        Matches are kept where their distance is below ``1 - match_conf`` times that of the second nearest.
    seed
        Seed of the approximate search for neighbours.

    Returns
    -------
    Placement | None
        With the matcher's confidence, inliers / (8 + 0.3 matches); None where too few keypoints match.
    """
    cv2.setRNGSeed(seed)
    features = [cv2.detail.computeImageFeatures2(finder, image) for image in (a, b)]
    if any(len(feature.getKeypoints()) < FEWEST_KEYPOINTS for feature in features):
        return None
    matches = cv2.detail.AffineBestOf2NearestMatcher(False, False, match_conf).apply2(features)
    between = matches[1]  # from A to B; the list is that of a 2 x 2 table
    if between.confidence <= 0:
        return None
    has_estimate, cameras = cv2.detail.AffineBasedEstimator().apply(features, matches, [])
    if not has_estimate:
        return None
    on_a, on_b = (np.float64(camera.R) for camera in _adjusted(features, matches, cameras))
    if not min(np.linalg.det(on_a), np.linalg.det(on_b)) > SMALLEST_AREA:
        return None
    b_to_a = np.linalg.inv(on_b) @ on_a
    return Placement(Similarity.from_matrix(b_to_a[:2]), between.confidence)


def _adjusted(
    features: Sequence[cv2.detail.ImageFeatures],
    matches: Sequence[cv2.detail.MatchesInfo],
    cameras: Sequence[cv2.detail.CameraParams],
) -> Sequence[cv2.detail.CameraParams]:
    """Adjust both images' places to all inliers; return the estimates where that does not converge."""
    for camera in cameras:
        camera.R = camera.R.astype(np.float32)
    adjuster = cv2.detail.BundleAdjusterAffinePartial()
    adjuster.setConfThresh(0.0)
    has_converged, adjusted = adjuster.apply(features, matches, cameras)
    return adjusted if has_converged else cameras
