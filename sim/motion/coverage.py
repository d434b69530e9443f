"""Coverage of the floor by the scans of a robot, and the overlap of two robots after any pair of scans."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim._kernels.visibility import see_scans
from sim.motion.driving import CELL_M
from sim.sensors.lidar import Lidar

FINE_M = 0.05  # cells for the final overlap: about those of the maps
MOST_CUTS = 400  # a longer log is cut at as many evenly spaced scans
TOLERANCE, WHOLE_TOLERANCE = (
    0.015,
    0.035,
)  # of an overlap on cells of this module; the finished maps' overlap is then within 0.05
LEAST_M2, LEAST_SHARE = 40.0, 0.4  # floor that a map must show, or its share in a small building


class SeenFloor:
    """Cells that the beams of one robot have crossed.

    Parameters
    ----------
    lidar
        The robot's scanner.
    shape
        Of the grid (H, W); row 0 at the bottom, its corner at the world's origin.
    cell_m
        Side of a cell; that of drive fields unless given.
    """

    def __init__(self, lidar: Lidar, shape: tuple[int, ...], *, cell_m: float = CELL_M) -> None:
        self._lidar, self._angles, self.cell_m = lidar, lidar.angles, cell_m
        self.since = np.full(shape, -1, dtype=np.int32)
        self.is_hit = np.zeros(shape, dtype=np.bool_)
        self.scans = 0

    @property
    def is_free(self) -> NDArray[np.bool_]:
        """Mask of the cells that some scan has shown free, shape (H, W)."""
        free: NDArray[np.bool_] = self.since >= 0
        return free

    def add(self, poses: NDArray[np.float64], ranges: NDArray[np.float64]) -> None:
        """Add scans, in order: poses (x, y, yaw), shape (S, 3), and true ranges, shape (S, B)."""
        near, far = self._lidar.min_range_m, self._lidar.max_range_m
        see_scans(poses, self._angles, ranges, near, far, self.cell_m, self.scans, self.since, self.is_hit)
        self.scans += len(poses)

    def share_of(self, floor: NDArray[np.bool_]) -> float:
        """Return the share of a floor, shape (H, W), that has been seen."""
        return float(np.count_nonzero(self.is_free & floor)) / max(1, int(np.count_nonzero(floor)))


@dataclass(frozen=True, slots=True, eq=False)
class Cuts:
    """Cuts of two logs: the floor that each part shows, and the floor that two parts have in common.

    Parameters
    ----------
    kept_a, kept_b
        Numbers of scans kept by each cut, ascending, shapes (N,) and (M,).
    area_a, area_b
        Floor that the kept scans show, shapes (N,) and (M,), square metres.
    common
        Floor that both show, shape (N, M), square metres.
    """

    kept_a: NDArray[np.int64]
    kept_b: NDArray[np.int64]
    area_a: NDArray[np.float64]
    area_b: NDArray[np.float64]
    common: NDArray[np.float64]

    @property
    def overlaps(self) -> NDArray[np.float64]:
        """Overlap of every pair of cuts, shape (N, M): the common area over the smaller area."""
        return self.common / np.maximum(1e-9, np.minimum(self.area_a[:, None], self.area_b))

    def choose(self, wanted: float, *, least_m2: float, whole: tuple[bool, bool] = (False, False)) -> CutChoice | None:
        """Choose the cuts with the wanted overlap that leave the largest product of areas; of equal ones the latest.

        Parameters
        ----------
        wanted
            The overlap, met within `TOLERANCE`, or `WHOLE_TOLERANCE` by a log that stays whole.
        least_m2
            Floor that each part must show.
        whole
            Whether the logs of A and of B should stay whole; this goes before areas.

        Returns
        -------
        Choice or None
            None where no pair of cuts will do.
        """
        off = np.abs(self.overlaps - wanted)
        is_enough = (self.area_a >= least_m2)[:, None] & (self.area_b >= least_m2)
        kept = np.zeros_like(off)  # number of logs that stay whole as preferred
        kept[-1, :] += whole[0]
        kept[:, -1] += whole[1]
        is_fit = is_enough & (off <= np.where(kept > 0, WHOLE_TOLERANCE, TOLERANCE))
        if not is_fit.any():
            return None
        worth = np.where(is_fit, self.area_a[:, None] * self.area_b + kept * self.area_a[-1] * self.area_b[-1], 0.0)
        last = worth.size - 1 - int(np.argmax(worth[::-1, ::-1]))
        i, j = divmod(last, worth.shape[1])
        return CutChoice(int(self.kept_a[i]), int(self.kept_b[j]), float(self.overlaps[i, j]), float(worth[i, j]))

    def range(self, *, least_m2: float) -> tuple[float, float] | None:
        """Return the least and the largest overlap of parts that each show enough floor; None where none does."""
        enough = (self.area_a >= least_m2)[:, None] & (self.area_b >= least_m2)
        met = self.overlaps[enough]
        return (float(met.min()), float(met.max())) if met.size else None


@dataclass(frozen=True, slots=True)
class CutChoice:
    """Choice of two cuts: the scans kept of A and of B, their overlap, and their worth for comparison."""

    scans_a: int
    scans_b: int
    overlap: float
    worth: float


def compute_cuts(a: SeenFloor, b: SeenFloor, *, fewest: int) -> Cuts:
    """Compute the cuts of two logs, seen on one grid, that leave each at least `fewest` scans."""
    first = min(fewest, a.scans, b.scans)
    kept_a, kept_b = (np.unique(np.linspace(first, floor.scans, MOST_CUTS).astype(np.int64)) for floor in (a, b))
    n, m = len(kept_a), len(kept_b)
    since_a, since_b = _first_cut(a, kept_a), _first_cut(b, kept_b)  # 0..n, 0..m; n and m: never seen
    counts = np.bincount((since_a * (m + 1) + since_b).ravel(), minlength=(n + 1) * (m + 1)).reshape(n + 1, m + 1)
    upto = counts.cumsum(axis=0).cumsum(axis=1)
    upto = upto * a.cell_m**2
    return Cuts(kept_a, kept_b, upto[:n, m], upto[n, :m], upto[:n, :m])


def _first_cut(floor: SeenFloor, kept: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return, for each cell, the first cut that keeps a scan which shows it."""
    first = np.searchsorted(kept, np.arange(floor.scans), side="right")
    return np.where(floor.is_free, first[floor.since], len(kept))


def least_area_m2(floor: NDArray[np.bool_]) -> float:
    """Return the area that a map must show, given the drivable floor, shape (H, W)."""
    return min(LEAST_M2, LEAST_SHARE * CELL_M**2 * np.count_nonzero(floor))
