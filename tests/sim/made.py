"""Small worlds and logs made without the physics engine, for tests of what comes after it."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sim.floorplans import Office, make_world
from sim.lidar import Lidar
from sim.mission import MissionLog, MissionSpec, RobotLog, RobotSpec
from sim.world import SCAN_HEIGHT_M, Prism, Room, World, bar
from tests.sim import naive


def box_world(width: float = 6.0, height: float = 4.0) -> World:
    """One room with walls of 0.2 m and a table."""
    corners = np.array([[0.1, 0.1], [width - 0.1, 0.1], [width - 0.1, height - 0.1], [0.1, height - 0.1]])
    walls = [Prism(bar(p, q, 0.2, extra=0.1), 2.5) for p, q in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    table = Prism(np.array([[3.0, 1.0], [4.0, 1.0], [4.0, 1.7], [3.0, 1.7]]), 0.75)
    room = Room("room", corners, np.array([1.5, 2.0]))
    return World(size=(width, height), walls=tuple(walls), furniture=(table,), rooms=(room,), family="box")


@functools.cache
def office_log() -> MissionLog:
    """Two robots that stand in the rooms of a small office, each in its own, with exact rays."""
    world = make_world(Office(size_m=(14.0, 10.0), rooms=6, oblique=0.0), 4)
    lidar = Lidar(beams=720)
    spec = MissionSpec(a=RobotSpec(lidar=lidar), b=RobotSpec(lidar=lidar))
    rooms = sorted(world.rooms, key=lambda room: float(room.spot[0]))
    a, b = (_standing(world, chosen, lidar) for chosen in (rooms[:5], rooms[2:]))
    return MissionLog(world=world, spec=spec, seed=0, a=a, b=b)


def _standing(world: World, rooms: list[Room], lidar: Lidar) -> RobotLog:
    offsets = [(0.0, 0.0), (0.2, 0.13), (-0.17, 0.22)]
    poses = np.array([[*(room.spot + offset), 0.3 * k] for k, room in enumerate(rooms) for offset in offsets])
    return RobotLog(
        times=np.arange(len(poses), dtype=np.float64),
        poses=poses,
        odometry=poses,
        ranges=np.array([naive.cast(world, pose, lidar.angles, lidar.max_range_m) for pose in poses]),
        rooms=tuple(room.name for room in rooms),
    )


def wall_distance(world: World, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance of points (N, 2) to the nearest edge of an obstacle that a robot cannot drive under."""
    nearest = np.full(len(points), np.inf)
    for prism in (p for p in world.obstacles if p.bottom <= SCAN_HEIGHT_M):
        for start, end in zip(prism.outline, np.roll(prism.outline, -1, axis=0), strict=True):
            edge = end - start
            share = np.clip(((points - start) @ edge) / (edge @ edge), 0.0, 1.0)
            nearest = np.minimum(nearest, np.hypot(*(points - start - share[:, None] * edge).T))
    return nearest


def glass_world() -> World:
    """The box with a pane across a part of it, a crate that only A finds and another that only B finds."""
    pane = Prism(np.array([[4.6, 1.2], [4.62, 1.2], [4.62, 3.8], [4.6, 3.8]]), 2.5)
    crates = [Prism(np.array([[2.2, y], [2.6, y], [2.6, y + 0.4], [2.2, y + 0.4]]), 0.9) for y in (0.4, 3.0)]
    return replace(box_world(), glass=(pane,), visits=((crates[0],), (crates[1],)))
