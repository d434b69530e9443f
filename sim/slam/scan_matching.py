"""Scan matching against the map made so far: correlation, then Gauss-Newton."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from sim._kernels import matching as kernels
from sim._kernels.tracing import trace_scans
from sim.slam.mapping import MOST_CELLS, scan_points

HIT, MISS, LIMIT = 1.4, -0.5, 3.5  # log-odds: two hits make a wall, a few misses erase what moved away
BLUR_CELLS, BLOCK = 1.0, 4
FIRM = 5.0  # the smooth map is 1 - exp(-FIRM * blurred walls): near 1 on every wall, or Gauss-Newton overshoots
MARGIN = 8  # cells around what changed: blur and blocks reach no farther
GROWTH = 128  # cells by which the map grows
ROUNDS, ENOUGH_CELLS = 12, 0.01
TURN_STEP = 0.7  # cells by which the farthest of the nearer half of the points moves between two turns of the search


@dataclass(frozen=True, slots=True, eq=False)
class ScanMatch:
    """Pose of a scan in a map, and the quality of the match.

    Parameters
    ----------
    pose
        (x, y, yaw), shape (3,).
    score
        Mean value of the map under the scan's points, 0..1: about 0.8 where all fits.
    conditioning
        Inverse condition number of the position, 0..1: information in the worse known direction over that in the
        better; near 0 in a corridor without features.
    """

    pose: NDArray[np.float64]
    score: float
    conditioning: float


class GrowingMap:
    """Map that grows with the scans: log-odds, and the smooth field that scans are matched with.

    Parameters
    ----------
    resolution_m
        Metres per cell.

    Raises
    ------
    InputError
        If the resolution is not positive.
    """

    def __init__(self, resolution_m: float) -> None:
        if not (math.isfinite(resolution_m) and resolution_m > 0):
            raise InputError(f"resolution_m must be a positive number of metres per cell, got {resolution_m}")
        self.resolution_m = resolution_m
        self._low = np.zeros(2, dtype=np.int64)  # (column, row) of the corner, in cells from the frame's origin
        self._log_odds = np.zeros((0, 0), dtype=np.float32)
        self._field = np.zeros((0, 0), dtype=np.float32)
        self._best_near = np.zeros((0, 0), dtype=np.float32)

    def insert(
        self, poses: NDArray[np.float64], angles: NDArray[np.float64], ranges: NDArray[np.float64], max_range_m: float
    ) -> None:
        """Add scans at poses (S, 3): beam directions (B,), ranges (S, B) as `sim.slam.mapping.build_map` takes them."""
        kinds = np.where(np.isnan(ranges), -1, np.isfinite(ranges)).astype(np.int8)
        ends = scan_points(poses, angles, np.where(kinds == 1, ranges, max_range_m)) / self.resolution_m
        starts = poses[:, :2] / self.resolution_m
        seen = np.concatenate([starts, ends[kinds >= 0]])
        low, high = np.floor(seen.min(axis=0)).astype(int), np.floor(seen.max(axis=0)).astype(int) + 1
        self._grow(low - 2 * MARGIN, high + 2 * MARGIN)
        (left, bottom), (right, top) = low - self._low, high - self._low
        trace_scans(starts - low, ends - low, kinds, self._log_odds[bottom:top, left:right], HIT, MISS, LIMIT)
        self._smooth(bottom, top, left, right)

    def match(
        self,
        points: NDArray[np.float64],
        guess: NDArray[np.float64],
        *,
        window_m: float,
        window_rad: float,
        prior_weights: tuple[float, float] = (0.0, 0.0),
    ) -> ScanMatch:
        """Match a scan near a guess.

        Parameters
        ----------
        points
            Hits of the scan in its own frame, shape (N, 2), metres, N >= 1.
        guess
            (x, y, yaw), shape (3,).
        window_m, window_rad
            Half sizes of the search window about the guess.
        prior_weights
            Weights of the guess: gain of the score that is needed for every squared metre, and for every squared
            radian, of departure from it.

        Notes
        -----
        E. Olson, ICRA 2009, doi:10.1109/ROBOT.2009.5152375: an exhaustive search, whose second level of resolution only
        skips what cannot win. Then Gauss-Newton on the interpolated map: S. Kohlbrecher et al., SSRR 2011,
        doi:10.1109/SSRR.2011.6106777. Departs from both: the guess is part of the cost, so that a corridor without
        features does not let the pose run away.
        """
        cells, middle = points / self.resolution_m, self._to_cells(guess)
        coarse = kernels.search(
            self._field,
            self._best_near,
            BLOCK,
            cells,
            middle,
            self._turns(cells, window_rad),
            math.ceil(window_m / self.resolution_m),
            prior_weights[0] * self.resolution_m**2,
            prior_weights[1],
        )
        pull = len(cells) * np.array(
            [prior_weights[0] * self.resolution_m**2, prior_weights[0] * self.resolution_m**2, prior_weights[1]]
        )
        fine = kernels.refine(self._field, cells, coarse[:3], middle, pull, ROUNDS, ENOUGH_CELLS)
        at = (fine[:2] + self._low) * self.resolution_m
        return ScanMatch(np.array([at[0], at[1], math.remainder(fine[2], 2 * math.pi)]), float(fine[3]), float(fine[4]))

    def _turns(self, cells: NDArray[np.float64], window_rad: float) -> NDArray[np.float64]:
        step = TURN_STEP / max(1.0, float(np.median(np.hypot(*cells.T))))
        count = math.ceil(window_rad / step)
        return np.arange(-count, count + 1, dtype=np.float64) * (window_rad / max(1, count))

    def _to_cells(self, pose: NDArray[np.float64]) -> NDArray[np.float64]:
        at = pose[:2] / self.resolution_m - self._low
        return np.array([at[0], at[1], pose[2]])

    def _grow(self, low: NDArray[np.int64], high: NDArray[np.int64]) -> None:
        """Make room for the cells from `low` up to `high`, (column, row) from the frame's origin."""
        shape = np.array(self._field.shape[::-1])
        if not shape.any():
            self._low = low
        before = -(-np.maximum(self._low - low, 0) // GROWTH) * GROWTH
        after = -(-np.maximum(high - self._low - shape, 0) // GROWTH) * GROWTH
        if not (before.any() or after.any()):
            return
        if np.prod(shape + before + after) > MOST_CELLS:
            raise InputError(f"a map of {shape + before + after} cells is too large: {self.resolution_m} m is too fine")
        margins = ((before[1], after[1]), (before[0], after[0]))
        self._log_odds, self._field, self._best_near = (
            np.pad(layer, margins) for layer in (self._log_odds, self._field, self._best_near)
        )
        self._low = self._low - before

    def _smooth(self, bottom: int, top: int, left: int, right: int) -> None:
        """Update the field and its bounds around the changed cells."""
        wide = np.s_[bottom - 2 * MARGIN : top + 2 * MARGIN, left - 2 * MARGIN : right + 2 * MARGIN]
        inner = np.s_[bottom - MARGIN : top + MARGIN, left - MARGIN : right + MARGIN]
        cut = np.s_[MARGIN:-MARGIN, MARGIN:-MARGIN]
        walls = np.maximum(self._log_odds[wide], 0.0) / np.float32(LIMIT)
        smooth = 1 - np.exp(-np.float32(FIRM) * cv2.GaussianBlur(walls, (0, 0), BLUR_CELLS))
        self._field[inner] = smooth[cut]
        self._best_near[inner] = cv2.dilate(smooth, np.ones((BLOCK, BLOCK), np.uint8), anchor=(0, 0))[cut]


def scan_hits(angles: NDArray[np.float64], ranges: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """Return the hits of a scan in its own frame: shape (N, 2), metres, N <= most, spread evenly over the readings.

    Parameters
    ----------
    angles, ranges
        Of the beams, shape (B,), radians and metres; readings that are not finite are left out.
    most
        The largest N.
    """
    hits = np.flatnonzero(np.isfinite(ranges))
    hits = hits[:: max(1, math.ceil(len(hits) / most))]
    points: NDArray[np.float64] = ranges[hits, None] * np.stack([np.cos(angles[hits]), np.sin(angles[hits])], axis=-1)
    return points
