"""Baseline `keypoints`: keypoints of the maps as images, matched, and a similarity by consensus."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Alignment
from rectmerge.baselines.consensus import agreed_similarity, mutual_matches
from rectmerge.baselines.images import middle_scale, resize, working_factors
from rectmerge.baselines.ranked_answer import Placement, answer
from rectmerge.baselines.stitching import stitch
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid

MAX_KEYPOINTS = 4_000  # the strongest; the time of matching grows with their square, and cluttered maps have many
DETECTORS: dict[str, Callable[[], cv2.Feature2D]] = {
    "akaze": functools.partial(cv2.AKAZE.create, max_points=MAX_KEYPOINTS),
    "orb": cv2.ORB.create,
    "sift": functools.partial(cv2.SIFT.create, nfeatures=MAX_KEYPOINTS),
}
SMALLEST_SIDE = 8  # no keypoint lies in a narrower image, and ORB cannot be asked for any


@dataclass(frozen=True, slots=True, kw_only=True)
class Keypoints:
    """Align by keypoints, as robots that run ROS do, or by the strongest plain way to use them.

    Parameters
    ----------
    detector
        "akaze", "orb" or "sift", as OpenCV sets them.
    variant
        "stitching": OpenCV's stitching pipeline for scans, as in ROS. "plain": one-to-one matches, and the similarity
        within the bounds of the scale with the most inliers.
    match_conf
        Stitching: a match counts where its distance is below 1 - `match_conf` times that of the second nearest.
    reach_cells
        Plain: the largest distance of an inlier from its match, in cells of A.
    samples
        Plain: pairs of matches that are tried.
    longest_cells
        Longest side of the images; larger maps are shrunk.
    accept_at
        The least confidence, inliers / (8 + 0.3 matches), that is accepted; no more than 3.3 is possible.

    Raises
    ------
    InputError
        If a parameter is out of its range.

    Notes
    -----
    J. Hörner, "Map-merging for multi-robot system", bachelor thesis, Charles University in Prague, 2016, the pipeline
    of the ROS package ``multirobot_map_merge``. With the defaults and the detector "akaze" it agrees with the
    package's release 2.1.4, run once outside this repository: 0 points apart on 249 pairs of unknown scale, at most 2
    at known scale. SIFT is no part of the package. The confidence is that of M. Brown and D. Lowe, "Automatic panoramic
    image stitching using invariant features", IJCV 74(1), 2007, DOI 10.1007/s11263-006-0002-3. The image is the
    occupancy as unsigned bytes, as a merger of ROS sees it: unknown is 255, occupied 100 and free 0. Of two maps the
    biggest component is both or one, which `accept_at` alone decides. The plain variant is our choice, its parameters
    included; ROS shrinks no map, and takes every keypoint where we take the 4,000 strongest.

    Extended for unknown scale: stitching fits similarities, so nothing but that an answer outside the bounds does not
    count; where the bounds define a scale, B is resized by it first.
    """

    name: ClassVar[str] = "keypoints"
    detector: Literal["akaze", "orb", "sift"] = "akaze"
    variant: Literal["stitching", "plain"] = "stitching"
    match_conf: float = 0.3
    reach_cells: float = 10.0
    samples: int = 5000
    longest_cells: int = 2000
    accept_at: float = 1.0

    def __post_init__(self) -> None:
        if self.detector not in DETECTORS:
            raise InputError(f"detector must be one of {', '.join(DETECTORS)}, got {self.detector!r}")
        if self.variant not in ("stitching", "plain"):
            raise InputError(f'variant must be "stitching" or "plain", got {self.variant!r}')
        if not 0 <= self.match_conf < 1:
            raise InputError(f"match_conf must be in [0, 1), got {self.match_conf}")
        for field in ("reach_cells", "samples", "longest_cells", "accept_at"):
            if not getattr(self, field) > 0:
                raise InputError(f"{field} must be > 0, got {getattr(self, field)}")

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Place B on A; `scale` bounds the pixel scale (cells of A per cell of B)."""
        factors = working_factors(a, b, scale, self.longest_cells)
        on_a, on_b = (resize(to_image(grid), factor) for grid, factor in zip((a, b), factors, strict=True))
        middle = middle_scale(scale)
        fit = self._fit(
            on_a.image,
            on_b.image,
            (scale[0] / middle, scale[1] / middle),
            self.reach_cells * factors[0],
            rng,
        )
        placements = []
        if fit is not None:
            placements = [Placement(on_a.to_grid @ fit.pixels @ on_b.to_grid.inverse(), fit.score)]
        nothing = f"too few {self.detector} keypoints match at a scale within bounds"
        return answer(self.name, a, b, placements, accept_at=self.accept_at, scale=scale, nothing=nothing)

    def _fit(
        self,
        a: NDArray[np.float32],
        b: NDArray[np.float32],
        scale: tuple[float, float],
        reach: float,
        rng: np.random.Generator,
    ) -> Placement | None:
        """Fit image B on image A by either variant."""
        if min(*a.shape, *b.shape) < SMALLEST_SIDE:
            return None
        images = np.rint(a).astype(np.uint8), np.rint(b).astype(np.uint8)
        finder = DETECTORS[self.detector]()
        if self.variant == "stitching":
            return stitch(*images, finder, match_conf=self.match_conf, seed=int(rng.integers(2**31)))
        matches = mutual_matches(*images, finder)
        return agreed_similarity(*matches, scale=scale, reach=reach, samples=self.samples, rng=rng)


def to_image(grid: OccupancyGrid) -> NDArray[np.float32]:
    """Return the image for the detector, shape (H, W): unknown 255, free 0, occupied 100."""
    return grid.occupancy.view(np.uint8).astype(np.float32)
