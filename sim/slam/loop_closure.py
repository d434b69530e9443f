"""Loop closure: a robot that knows a place again bends its path so that both visits agree (graph SLAM)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from sim._kernels.pose_graph import solve_profile
from sim.slam.odometry import between, compose, wrapped
from sim.slam.scan_matching import GrowingMap, scan_hits

RECENT = 25  # key scans that are no loop yet, and those that the robot's map begins anew with
AROUND = 8  # key scans before and after an old one that together make the map which the new one is laid on
NEAR_M = 2.5  # between a key scan and an old one that it may know again
WINDOW_M, WINDOW_RAD = 1.5, math.radians(15.0)
TRUST = (0.05, 0.5)  # in the present poses: what a place must fit better per m^2 and rad^2 that it is off
KNOWN_AGAIN, GRIPS = 0.6, 0.25  # score and grip from which the old place is believed: not along a bare corridor
STEP_STD, LINK_STD = np.array([0.03, 0.03, 0.01]), np.array([0.03, 0.03, 0.007])  # metres, metres, radians
AGREES_M, AGREES_RAD = 0.05, math.radians(0.5)  # a link that tells no more than this changes nothing
CONTRADICTS = 8.0  # standard deviations that no link may be stretched by
ROUNDS, ENOUGH = 15, 1e-3  # metres, radians


@dataclass(frozen=True, slots=True, eq=False)
class Links:
    """What is known of pairs of poses.

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

    def stretch(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return by how much poses (K, 3) depart from the links, in standard deviations, shape (E, 3)."""
        return between(self.motions, between(poses[self.pairs[:, 0]], poses[self.pairs[:, 1]])) / self.stds


def solve_graph(poses: NDArray[np.float64], links: Links) -> NDArray[np.float64]:
    """Move poses so that the links between them are stretched least, in squares; the first stays.

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
        If a link names no pose, or some pose hangs on no link.

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
            raise InputError("a pose of the graph hangs on no link")
        step = right.reshape(-1, 3)
        poses[1:] += step
        poses[:, 2] = wrapped(poses[:, 2])
        if np.abs(step).max(initial=0.0) < ENOUGH:
            break
    return poses


def _normal_equations(poses: NDArray[np.float64], links: Links) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return J^T J, and -J^T e of the stretched links, for all poses but the first."""
    count, first, second = len(poses), links.pairs[:, 0], links.pairs[:, 1]
    of_first, of_second = _jacobians(poses[first], poses[second], links)
    error = links.stretch(poses)
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
    """Derivatives of the stretch by the first and by the second pose, each (E, 3, 3)."""
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


def carry(trail: NDArray[np.float64], kept: NDArray[np.int64], poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Carry all poses along with those that a graph has moved.

    Parameters
    ----------
    trail
        Poses as they followed from one another, without any correction, shape (S, 3).
    kept
        Which of them are in the graph, ascending, shape (K,), K >= 1.
    poses
        Where the graph has put those, shape (K, 3).

    Returns
    -------
    NDArray
        Shape (S, 3): each pose between two that were moved is moved in between, by its share of the way in scans.
    """
    scans = np.arange(len(trail))
    before = np.maximum(np.searchsorted(kept, scans, side="right") - 1, 0)
    after = np.minimum(before + 1, len(kept) - 1)
    share = (scans - kept[before]) / np.maximum(kept[after] - kept[before], 1)
    share = np.clip(share, 0.0, 1.0)[:, None]
    from_before, from_after = (compose(poses[k], between(trail[kept[k]], trail)) for k in (before, after))
    carried: NDArray[np.float64] = from_before + share * (from_after - from_before)
    carried[:, 2] = wrapped(from_before[:, 2] + share[:, 0] * wrapped(from_after[:, 2] - from_before[:, 2]))
    return carried


class KeyScans:
    """The scans that a robot keeps, linked into a graph of their poses.

    Parameters
    ----------
    angles
        Beam directions, shape (B,).
    max_range_m
        How far a beam that met nothing has seen.
    resolution_m
        Of the maps that old places are known again by.
    beams
        At most so many readings of a scan are compared.
    """

    def __init__(self, angles: NDArray[np.float64], max_range_m: float, resolution_m: float, beams: int) -> None:
        self.poses = np.empty((0, 3))
        self.scans: list[NDArray[np.float64]] = []
        self._angles, self._max_range_m, self._resolution_m, self._beams = angles, max_range_m, resolution_m, beams
        self._links = Links(np.empty((0, 2), dtype=np.int64), np.empty((0, 3)), np.empty((0, 3)))

    def add(self, pose: NDArray[np.float64], ranges: NDArray[np.float64]) -> None:
        """Keep a scan (B,) at a pose (3,), linked to the one before."""
        self.poses = np.concatenate([self.poses, pose[None]])
        self.scans.append(ranges)
        if len(self.poses) > 1:
            last = len(self.poses) - 1
            self._links = self._with_link(last - 1, last, between(self.poses[-2], pose), STEP_STD)

    def close(self) -> bool:
        """Look whether the newest scan shows a place of long before; if so, move all poses and tell.

        The old place is the nearest by the present poses; what it looked like is laid out from the key scans around it.
        """
        newest = len(self.poses) - 1
        old = self._nearest_old()
        points = scan_hits(self._angles, self.scans[-1], self._beams)
        if old is None or not len(points):
            return False
        scans = np.arange(max(0, old - AROUND), min(newest - RECENT, old + AROUND) + 1)
        place = self.lay_out(scans)
        found = place.match(points, self.poses[-1], window_m=WINDOW_M, window_rad=WINDOW_RAD, trust=TRUST)
        if found.score < KNOWN_AGAIN or found.grip < GRIPS:
            return False
        links = self._with_link(old, newest, between(self.poses[old], found.pose), LINK_STD)
        gap = between(self.poses[-1], found.pose)
        if math.hypot(gap[0], gap[1]) < AGREES_M and abs(gap[2]) < AGREES_RAD:
            self._links = links
            return False
        poses = solve_graph(self.poses, links)
        if np.abs(links.stretch(poses)).max() > CONTRADICTS:
            return False
        self.poses, self._links = poses, links
        return True

    def lay_out(self, scans: NDArray[np.int64]) -> GrowingMap:
        """Make a map of some of the scans."""
        made = GrowingMap(self._resolution_m)
        self.put_into(made, scans)
        return made

    def put_into(self, made: GrowingMap, scans: NDArray[np.int64]) -> None:
        """Add some of the scans to a map."""
        ranges = np.array([self.scans[k] for k in scans])
        made.insert(self.poses[scans], self._angles, ranges, self._max_range_m)

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
