"""Occupancy grids from scans with known poses, by log-odds, at any resolution and in any map frame."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from sim._kernels.tracing import trace_scans

HIT, MISS, LIMIT = 1.0, 0.4, 8.0  # log-odds that one hit adds, that one miss takes away, and where they saturate
MOST_CELLS = 100_000_000


def scan_points(
    poses: NDArray[np.float64], angles: NDArray[np.float64], ranges: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Place range readings in the frame of their poses.

    Parameters
    ----------
    poses
        (x, y, yaw), shape (S, 3).
    angles
        Beam directions, shape (B,).
    ranges
        Shape (S, B), metres.

    Returns
    -------
    NDArray
        Shape (S, B, 2).
    """
    heading = poses[:, 2:] + angles  # (S, B)
    reach = ranges[..., None] * np.stack([np.cos(heading), np.sin(heading)], axis=-1)  # (S, B, 2)
    placed: NDArray[np.float64] = poses[:, None, :2] + reach
    return placed


def build_map(
    poses: NDArray[np.float64],
    angles: NDArray[np.float64],
    ranges: NDArray[np.float64],
    *,
    resolution: float,
    max_range_m: float,
    frame: tuple[float, float, float] = (0.0, 0.0, 0.0),
    hit: float = HIT,
    miss: float = MISS,
    least_evidence: float = 0.0,
) -> OccupancyGrid:
    """Build a map from scans.

    Parameters
    ----------
    poses
        (x, y, yaw) of the scanner at each scan, shape (S, 3), metres and radians.
    angles
        Beam directions from the heading, shape (B,), radians.
    ranges
        Shape (S, B), metres; inf where nothing is in reach, nan where there is no reading.
    resolution
        Metres per cell.
    max_range_m
        Range up to which a beam without a hit shows free space.
    frame
        Pose (x, y, yaw) of the map frame in the frame of `poses`.
    hit, miss
        Log-odds that a hit adds to its cell, and that a ray takes away from each cell it passes; both positive.
    least_evidence
        Log-odds up to which, either way, a cell stays unknown, as between the thresholds of a map server.

    Returns
    -------
    OccupancyGrid
        Cells hit more than passed are occupied, cells passed more are free, the rest is unknown; cropped to the
        known cells. Its origin has yaw 0, so its rows follow the map frame's x axis.

    Raises
    ------
    InputError
        If shapes or numbers cannot be used, no beam has a reading, or the map would be absurdly large.

    Notes
    -----
    H. Moravec and A. Elfes, ICRA 1985. A scan changes a cell at most once, and its hits win over its misses, so that
    beams that graze a wall do not erase it.
    """
    whole = growing_maps(
        poses,
        angles,
        ranges,
        [len(poses)],
        resolution=resolution,
        max_range_m=max_range_m,
        frame=frame,
        hit=hit,
        miss=miss,
        least_evidence=least_evidence,
    )
    return next(whole)


def growing_maps(
    poses: NDArray[np.float64],
    angles: NDArray[np.float64],
    ranges: NDArray[np.float64],
    counts: Sequence[int],
    *,
    resolution: float,
    max_range_m: float,
    frame: tuple[float, float, float] = (0.0, 0.0, 0.0),
    hit: float = HIT,
    miss: float = MISS,
    least_evidence: float = 0.0,
) -> Iterator[OccupancyGrid]:
    """Build the maps of the first scans, for several numbers of scans, each as `build_map` does.

    Parameters
    ----------
    poses, angles, ranges, resolution, max_range_m, frame, hit, miss, least_evidence
        As `build_map` has them.
    counts
        Numbers of scans that the maps are made from, ascending; each has a reading.

    Raises
    ------
    InputError
        As `build_map` does.
    """
    if not (math.isfinite(resolution) and resolution > 0):
        raise InputError(f"resolution must be a positive number of metres per cell, got {resolution}")
    if not (0 < hit <= LIMIT and 0 < miss <= LIMIT):
        raise InputError(f"hit and miss must be log-odds > 0 and <= {LIMIT:g}, got {hit} and {miss}")
    if poses.ndim != 2 or poses.shape[1] != 3 or ranges.shape != (len(poses), len(angles)):
        raise InputError(f"poses (S, 3), angles (B,) and ranges (S, B) disagree: {poses.shape}, {ranges.shape}")
    kinds = np.where(np.isnan(ranges), -1, np.isfinite(ranges)).astype(np.int8)
    if not (kinds >= 0).any():
        raise InputError("there is no reading to build a map from")
    into = Similarity(1.0, frame[2], frame[0], frame[1]).inverse()
    ends = into.apply(scan_points(poses, angles, np.where(kinds == 1, ranges, max_range_m))) / resolution
    starts = into.apply(poses[:, :2]) / resolution
    seen = np.concatenate([starts, ends[kinds >= 0]])
    low = np.floor(seen.min(axis=0)) - 1
    width, height = (np.floor(seen.max(axis=0)) + 2 - low).astype(int)
    if width * height > MOST_CELLS:
        raise InputError(f"a map of {width} x {height} cells is too large: resolution {resolution} is too fine")
    log_odds = np.zeros((height, width), dtype=np.float32)
    for done, count in pairwise([0, *counts]):
        part = slice(done, count)
        trace_scans(starts[part] - low, ends[part] - low, kinds[part], log_odds, hit, -miss, LIMIT)
        yield _crop(log_odds, low, resolution, least_evidence)


def _crop(log_odds: NDArray[np.float32], low: NDArray[np.float64], resolution: float, least: float) -> OccupancyGrid:
    """Cut the known part out of a log-odds grid (row 0 at the bottom) whose corner lies at `low`, in cells."""
    cells = np.where(log_odds > least, OCCUPIED, np.where(log_odds < -least, FREE, UNKNOWN)).astype(np.int8)
    rows, cols = np.nonzero((cells != UNKNOWN).any(axis=1))[0], np.nonzero((cells != UNKNOWN).any(axis=0))[0]
    if not len(rows):
        raise InputError(f"no cell has more evidence than least_evidence = {least:g}: too few scans")
    part = cells[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1]
    x, y = (low + np.array([cols[0], rows[0]])) * resolution
    return OccupancyGrid(part[::-1], resolution, (float(x), float(y), 0.0))
