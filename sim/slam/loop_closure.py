"""Loop closure by pose-graph optimisation: a scan that matches an old place corrects the path."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from sim._kernels.pose_graph import solve_profile
from sim.slam.poses import compose_poses, relative_poses, wrap_angles
from sim.slam.scan_matching import GrowingMap, scan_hits

RECENT = 25  # newest key scans: they are no loop yet, and a new map begins with them
AROUND = 8  # key scans before and after an old one that make the map to match with
NEAR_M = 2.5  # largest distance between a key scan and an old one that it may match
WINDOW_M, WINDOW_RAD = 1.5, math.radians(15.0)
PRIOR_WEIGHTS = (0.05, 0.5)  # of the present pose: score that a match must gain per m^2 and rad^2 of departure
LEAST_SCORE, LEAST_CONDITIONING = (
    0.6,
    0.25,
)  # of a match that is accepted: none along a bare corridor
STEP_STD, LINK_STD = np.array([0.03, 0.03, 0.01]), np.array([0.03, 0.03, 0.007])  # metres, metres, radians
AGREES_M, AGREES_RAD = 0.05, math.radians(0.5)  # a smaller correction changes nothing
CONTRADICTS = 8.0  # largest residual of a link, standard deviations
ROUNDS, ENOUGH = 15, 1e-3  # metres, radians


@dataclass(frozen=True, slots=True, eq=False)
class Links:
    """Links of a pose graph: measured relative poses between pairs of poses.

    Parameters
    ----------
    pairs
        Indices (first, second), shape (E, 2).
    motions
        The second pose in the frame of the first, shape (E, 3).
    stds
        Standard deviations of `motions`, shape (E, 3).
    """

    pairs: NDArray[np.int64]
    motions: NDArray[np.float64]
    stds: NDArray[np.float64]

    def residuals(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the residuals of the links at poses (K, 3), in standard deviations, shape (E, 3)."""
        return (
            relative_poses(self.motions, relative_poses(poses[self.pairs[:, 0]], poses[self.pairs[:, 1]])) / self.stds
        )


def solve_graph(poses: NDArray[np.float64], links: Links) -> NDArray[np.float64]:
    """Find the poses with the least squared residuals of the links; the first pose stays.

    Parameters
    ----------
    poses
        First guess, shape (K, 3).
    links
        At least those from each pose to the next.

    Returns
    -------
    NDArray
        Shape (K, 3).

    Raises
    ------
    InputError
        If a link names no pose, or a pose has no link.

    Notes
    -----
    F. Lu and E. Milios, Autonomous Robots 4, 1997, doi:10.1023/A:1008854305733; solved by Gauss-Newton as in
    G. Grisetti et al., IEEE Intelligent Transportation Systems Magazine, 2010, doi:10.1109/MITS.2010.939925, with dense
    matrices: a few hundred poses.
    """
    if len(links.pairs) and not 0 <= links.pairs.min() <= links.pairs.max() < len(poses):
        raise InputError(f"links name poses 0 to {len(poses) - 1}, got {links.pairs.max()}")
    poses = poses.copy()
    for _ in range(ROUNDS):
        system, right = _normal_equations(poses, links)
        if not solve_profile(system, right):
            raise InputError("a pose of the graph has no link")
        step = right.reshape(-1, 3)
        poses[1:] += step
        poses[:, 2] = wrap_angles(poses[:, 2])
        if np.abs(step).max(initial=0.0) < ENOUGH:
            break
    return poses


def _normal_equations(poses: NDArray[np.float64], links: Links) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return J^T J and -J^T e of the links, for all poses but the first."""
    count, first, second = len(poses), links.pairs[:, 0], links.pairs[:, 1]
    of_first, of_second = _jacobians(poses[first], poses[second], links)
    error = links.residuals(poses)
    system, right = np.zeros((count, count, 3, 3)), np.zeros((count, 3))
    ends = ((first, of_first), (second, of_second))
    for p, of_p in ends:
        np.add.at(right, p, -np.einsum("eki,ek->ei", of_p, error))
        for q, of_q in ends:
            np.add.at(system, (p, q), np.einsum("eki,ekj->eij", of_p, of_q))
    free = 3 * count - 3  # the first pose stays
    blocks: NDArray[np.float64] = system[1:, 1:].transpose(0, 2, 1, 3)
    return blocks.reshape(free, free), right[1:].ravel()


def _jacobians(
    first: NDArray[np.float64], second: NDArray[np.float64], links: Links
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the derivatives of the residuals by the first and by the second pose, each (E, 3, 3)."""
    d = second - first
    yaw = first[:, 2] + links.motions[:, 2]
    cos, sin = np.cos(yaw), np.sin(yaw)
    of_second = np.zeros((len(d), 3, 3))
    of_second[:, 0, 0], of_second[:, 0, 1] = cos, sin
    of_second[:, 1, 0], of_second[:, 1, 1] = -sin, cos
    of_second[:, 2, 2] = 1.0
    of_first = -of_second
    of_first[:, 0, 2] = -sin * d[:, 0] + cos * d[:, 1]
    of_first[:, 1, 2] = -cos * d[:, 0] - sin * d[:, 1]
    return of_first / links.stds[:, :, None], of_second / links.stds[:, :, None]


def propagate_corrections(
    trail: NDArray[np.float64], kept: NDArray[np.int64], poses: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Propagate the corrections of the poses in a graph to all poses.

    Parameters
    ----------
    trail
        Poses as they followed from one another, without any correction, shape (S, 3).
    kept
        Indices of the poses in the graph, ascending, shape (K,), K >= 1.
    poses
        Those poses after the correction, shape (K, 3).

    Returns
    -------
    NDArray
        Shape (S, 3): poses between two of the graph are corrected by interpolation over the scans.
    """
    scans = np.arange(len(trail))
    before = np.maximum(np.searchsorted(kept, scans, side="right") - 1, 0)
    after = np.minimum(before + 1, len(kept) - 1)
    share = (scans - kept[before]) / np.maximum(kept[after] - kept[before], 1)
    share = np.clip(share, 0.0, 1.0)[:, None]
    from_before, from_after = (compose_poses(poses[k], relative_poses(trail[kept[k]], trail)) for k in (before, after))
    carried: NDArray[np.float64] = from_before + share * (from_after - from_before)
    carried[:, 2] = wrap_angles(from_before[:, 2] + share[:, 0] * wrap_angles(from_after[:, 2] - from_before[:, 2]))
    return carried


class KeyScans:
    """Key scans of a robot, linked into a pose graph.

    Parameters
    ----------
    angles
        Beam directions, shape (B,).
    max_range_m
        How far a beam that met nothing has seen.
    resolution_m
        Cells of the maps that old places are matched with.
    beams
        At most so many readings of a scan are compared.
    """

    def __init__(self, angles: NDArray[np.float64], max_range_m: float, resolution_m: float, beams: int) -> None:
        self.poses = np.empty((0, 3))
        self.scans: list[NDArray[np.float64]] = []
        self._angles, self._max_range_m, self._resolution_m, self._beams = angles, max_range_m, resolution_m, beams
        self._links = Links(np.empty((0, 2), dtype=np.int64), np.empty((0, 3)), np.empty((0, 3)))

    def add(self, pose: NDArray[np.float64], ranges: NDArray[np.float64]) -> None:
        """Keep a scan (B,) at a pose (3,), linked to the scan before."""
        self.poses = np.concatenate([self.poses, pose[None]])
        self.scans.append(ranges)
        if len(self.poses) > 1:
            last = len(self.poses) - 1
            self._links = self._with_link(last - 1, last, relative_poses(self.poses[-2], pose), STEP_STD)

    def close_loop(self) -> bool:
        """Match the newest scan with an old place; return True where that has corrected the poses.

        The old place is the nearest by the present poses, and its map is made of the key scans around it.
        """
        newest = len(self.poses) - 1
        old = self._nearest_old()
        points = scan_hits(self._angles, self.scans[-1], self._beams)
        if old is None or not len(points):
            return False
        scans = np.arange(max(0, old - AROUND), min(newest - RECENT, old + AROUND) + 1)
        place = self.make_map(scans)
        match = place.match(
            points, self.poses[-1], window_m=WINDOW_M, window_rad=WINDOW_RAD, prior_weights=PRIOR_WEIGHTS
        )
        if match.score < LEAST_SCORE or match.conditioning < LEAST_CONDITIONING:
            return False
        links = self._with_link(old, newest, relative_poses(self.poses[old], match.pose), LINK_STD)
        gap = relative_poses(self.poses[-1], match.pose)
        if math.hypot(gap[0], gap[1]) < AGREES_M and abs(gap[2]) < AGREES_RAD:
            self._links = links
            return False
        poses = solve_graph(self.poses, links)
        if np.abs(links.residuals(poses)).max() > CONTRADICTS:
            return False
        self.poses, self._links = poses, links
        return True

    def make_map(self, scans: NDArray[np.int64]) -> GrowingMap:
        """Make a map of some of the scans."""
        grid = GrowingMap(self._resolution_m)
        self.add_to_map(grid, scans)
        return grid

    def add_to_map(self, grid: GrowingMap, scans: NDArray[np.int64]) -> None:
        """Add some of the scans to a map."""
        ranges = np.array([self.scans[k] for k in scans])
        grid.insert(self.poses[scans], self._angles, ranges, self._max_range_m)

    def _nearest_old(self) -> int | None:
        distance = np.hypot(*(self.poses[:-RECENT, :2] - self.poses[-1, :2]).T)
        if not len(distance) or distance.min() > NEAR_M:
            return None
        return int(np.argmin(distance))

    def _with_link(self, first: int, second: int, motion: NDArray[np.float64], std: NDArray[np.float64]) -> Links:
        return Links(
            np.concatenate([self._links.pairs, [[first, second]]]),
            np.concatenate([self._links.motions, motion[None]]),
            np.concatenate([self._links.stds, std[None]]),
        )
