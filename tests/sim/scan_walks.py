"""Walks through small worlds with exact scans, made without the physics engine."""

from __future__ import annotations

import functools
import itertools
import math

import numpy as np
from numpy.typing import NDArray

from sim.sensors.lidar import Lidar
from sim.world import Prism, World
from tests.sim import naive
from tests.sim.small_worlds import box_world

LIDAR = Lidar(beams=180)
SIZE, WIDTH = (12.0, 9.0), 2.0  # of the ring, and of its corridor


def ring_world(*, is_bare: bool = False) -> World:
    """Make a corridor around a block; niches make each place unlike the others unless it is bare."""
    (w, h), c = SIZE, WIDTH
    walls = [(0, 0, w, 0.2), (0, h - 0.2, w, h), (0, 0, 0.2, h), (w - 0.2, 0, w, h), (c, c, w - c, h - c)]
    niches = [(3.0, 0.2, 3.5, 0.5), (7.1, 0.2, 7.4, 0.4), (4.6, h - 0.5, 5.2, h - 0.2), (8.0, h - 0.4, 8.4, h - 0.2)]
    niches += [(0.2, 3.2, 0.5, 3.7), (0.2, 6.0, 0.4, 6.2), (w - 0.4, 4.1, w - 0.2, 4.9)]
    return World(size=SIZE, walls=tuple(_block(*sides) for sides in (walls if is_bare else walls + niches)))


@functools.cache
def ring_walk() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return poses of a bit more than a lap of the ring in steps of 0.25 m, and exact ranges."""
    (w, h), m = SIZE, WIDTH / 2 + 0.1
    corners = [(m, m), (w - m, m), (w - m, h - m), (m, h - m), (m, m), (w / 2, m)]
    return _seen(ring_world(), walk(corners, step_m=0.25))


@functools.cache
def room_walk() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return poses of a walk about the table of the box, and exact ranges."""
    return _seen(box_world(), walk([(1.0, 1.0), (2.2, 3.0), (4.8, 2.8), (5.0, 1.0), (4.8, 2.8), (1.5, 2.2)]))


def walk(corners: list[tuple[float, float]], *, step_m: float = 0.15, step_rad: float = 0.3) -> NDArray[np.float64]:
    """Return poses of a robot that drives straight from corner to corner and turns on the spot in between."""
    poses, yaw = [], math.atan2(corners[1][1] - corners[0][1], corners[1][0] - corners[0][0])
    for (x0, y0), (x1, y1) in itertools.pairwise(corners):
        turn = math.remainder(math.atan2(y1 - y0, x1 - x0) - yaw, 2 * math.pi)
        turns = math.ceil(abs(turn) / step_rad)
        poses += [(x0, y0, yaw + turn * k / turns) for k in range(turns)]
        yaw += turn
        steps = math.ceil(math.hypot(x1 - x0, y1 - y0) / step_m)
        poses += [(x0 + (x1 - x0) * k / steps, y0 + (y1 - y0) * k / steps, yaw) for k in range(steps)]
    return np.array(poses)


def _seen(world: World, poses: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    return poses, np.array([naive.cast(world, pose, LIDAR.angles, LIDAR.max_range_m) for pose in poses])


def _block(x0: float, y0: float, x1: float, y1: float) -> Prism:
    return Prism(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]), 2.5)
