"""Disturbances of range readings by the building and its people: windows, people who pass, offsets of whole scans."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError

# source of all: hand, no data; the densities, which are fitted, are fields
PIECE_M = 0.4  # side of the squares of surface that are windows or are not
DEPTH_M = 3.0  # mean distance behind a window at which a beam meets something
ESCAPES = 0.7  # probability that a beam passes its window
SIGHT_M = 6.0  # people appear within this distance
LEG_M, STRIDE_M = 0.07, 0.15  # radius of a leg, and half the distance between both
WALK_M_S, STAY_S = (0.0, 1.3), (1.0, 6.0)  # least and highest speed of people, and least and longest stay


@dataclass(frozen=True, slots=True, kw_only=True)
class Disturbances:
    """Densities of the disturbances of one robot's scans.

    Parameters
    ----------
    windows
        Share of the surfaces, in squares of 0.4 m, that most beams pass: panes, mesh, gaps between things.
    people_per_minute
        People who come into the robot's view, each for 1 to 6 s.
    offset_m
        Standard deviation of an error that all readings of a scan share, as of its time stamp or its height.

    Raises
    ------
    InputError
        If a density is out of range.
    """

    windows: float = 0.0
    people_per_minute: float = 0.0
    offset_m: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.windows <= 1:
            raise InputError(f"windows must be a share, 0 to 1, got {self.windows}")
        for name in ("people_per_minute", "offset_m"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise InputError(f"{name} must be >= 0, got {getattr(self, name)}")

    def disturb(
        self,
        ranges: NDArray[np.float64],
        poses: NDArray[np.float64],
        angles: NDArray[np.float64],
        times: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> NDArray[np.float64]:
        """Return the distances that the beams meet with windows and people about.

        Parameters
        ----------
        ranges
            True ranges, shape (S, B), metres; inf where there is nothing.
        poses
            True poses (x, y, yaw) of the scanner, shape (S, 3).
        angles
            Directions of the beams from the heading, shape (B,), radians.
        times
            Times of the scans, shape (S,), seconds.
        rng
            Randomness of all three.

        Returns
        -------
        NDArray
            Shape (S, B), metres, above 0.
        """
        of_windows, of_people, of_offsets = rng.spawn(3)
        heading = poses[:, 2:] + angles  # (S, B)
        seen = _through_windows(ranges, poses, heading, self.windows, of_windows)
        minutes = float(times[-1] - times[0]) / 60.0
        for _ in range(int(of_people.poisson(self.people_per_minute * minutes))):
            _let_pass(seen, poses, heading, times, of_people)
        offsets = self.offset_m * of_offsets.standard_normal((len(seen), 1))
        return np.maximum(seen + offsets, 0.01)


def _through_windows(
    ranges: NDArray[np.float64],
    poses: NDArray[np.float64],
    heading: NDArray[np.float64],
    share: float,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return ranges, shape (S, B), most beams that meet a window reaching further."""
    seen, is_hit = ranges.copy(), np.isfinite(ranges)
    reach = np.where(is_hit, ranges, 0.0)
    x, y = poses[:, :1] + reach * np.cos(heading), poses[:, 1:2] + reach * np.sin(heading)
    squares = np.floor(np.stack([x[is_hit], y[is_hit]], axis=-1) / PIECE_M).astype(np.int64)  # (N, 2)
    if not len(squares):
        return seen
    squares -= squares.min(axis=0)
    keys, index = np.unique(squares[:, 0] * (squares[:, 1].max() + 1) + squares[:, 1], return_inverse=True)
    is_window, depth = rng.random(len(keys)) < share, rng.exponential(DEPTH_M, len(keys))
    escapes = is_window[index] & (rng.random(len(index)) < ESCAPES)
    beyond = depth[index] * rng.uniform(0.5, 1.5, len(index))
    seen[is_hit] += np.where(escapes, beyond, 0.0)
    return seen


def _let_pass(
    seen: NDArray[np.float64],
    poses: NDArray[np.float64],
    heading: NDArray[np.float64],
    times: NDArray[np.float64],
    rng: np.random.Generator,
) -> None:
    """Shorten the ranges, shape (S, B), of the beams that meet the legs of one person, in place."""
    scan, beam, along = int(rng.integers(len(seen))), int(rng.integers(seen.shape[1])), rng.uniform(0.2, 0.95)
    away = along * min(float(seen[scan, beam]), SIGHT_M)
    start = poses[scan, :2] + away * np.array([math.cos(heading[scan, beam]), math.sin(heading[scan, beam])])
    way, speed, stay = rng.uniform(0, math.tau), rng.uniform(*WALK_M_S), rng.uniform(*STAY_S)
    ahead, aside = np.array([math.cos(way), math.sin(way)]), np.array([-math.sin(way), math.cos(way)])
    first, last = np.searchsorted(times, [times[scan], times[scan] + stay])
    part = slice(int(first), max(int(first) + 1, int(last)))
    walked = (times[part] - times[scan])[:, None] * speed * ahead  # (T, 2)
    for side in (-STRIDE_M, STRIDE_M):
        to_leg = start + side * aside + walked - poses[part, :2]
        distance = np.maximum(np.hypot(*to_leg.T), 2 * LEG_M)[:, None]
        off = heading[part] - np.arctan2(to_leg[:, 1], to_leg[:, 0])[:, None]  # (T, B)
        is_met = np.abs((off + math.pi) % math.tau - math.pi) <= np.arcsin(LEG_M / distance)
        seen[part] = np.where(is_met, np.minimum(seen[part], distance - LEG_M), seen[part])
