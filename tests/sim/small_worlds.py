"""Small worlds and logs made without the physics engine."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sim.floorplans import Office, make_world
from sim.missions.mission_log import MissionLog, RobotLog
from sim.missions.spec import MissionSpec, RobotSpec
from sim.motion.driving import PathPlanner, make_drive_field
from sim.motion.piloting import Pilot
from sim.motion.steering import Steering
from sim.motion.tours import Tour
from sim.sensors.lidar import Lidar
from sim.sensors.ray_casting import Caster
from sim.slam.mapping import build_map
from sim.world import SCAN_HEIGHT_M, Prism, Room, World, bar
from tests.sim import naive


def box_world(width: float = 6.0, height: float = 4.0) -> World:
    """Make a room with walls of 0.2 m and a table."""
    corners = np.array([[0.1, 0.1], [width - 0.1, 0.1], [width - 0.1, height - 0.1], [0.1, height - 0.1]])
    walls = [Prism(bar(p, q, 0.2, extra=0.1), 2.5) for p, q in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    table = Prism(np.array([[3.0, 1.0], [4.0, 1.0], [4.0, 1.7], [3.0, 1.7]]), 0.75)
    room = Room("room", corners, np.array([1.5, 2.0]))
    return World(size=(width, height), walls=tuple(walls), furniture=(table,), rooms=(room,), family="box")


def corridor_world(width: float) -> World:
    """Make two rooms of 3 m, each with a spot in its middle, joined by a corridor of 6 m."""
    low, high = 1.7 - width / 2, 1.7 + width / 2
    boxes = [(0, 0, 12.4, 0.2), (0, 3.2, 12.4, 3.4), (0, 0.2, 0.2, 3.2), (12.2, 0.2, 12.4, 3.2)]
    boxes += [(3.2, 0.2, 9.2, low), (3.2, high, 9.2, 3.2)]
    rooms = [("left", (0.2, 0.2, 3.2, 3.2)), ("corridor", (3.2, low, 9.2, high)), ("right", (9.2, 0.2, 12.2, 3.2))]
    return World(
        size=(12.4, 3.4),
        walls=tuple(Prism(rectangle(*box), 2.5) for box in boxes),
        rooms=tuple(Room(name, rectangle(*box), rectangle(*box).mean(axis=0)) for name, box in rooms),
        family="corridor",
    )


def rectangle(x0: float, y0: float, x1: float, y1: float) -> NDArray[np.float64]:
    """Return the corners of a rectangle, counter-clockwise."""
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])


def drive_exactly(
    pilots: list[Pilot], starts: list[tuple[float, float, float]], seconds: float
) -> tuple[NDArray[np.float64], float]:
    """Let robots follow the commands of their pilots exactly; return poses (K, steps, 3) and the time of the end."""
    poses, tracks, time = [np.array(start) for start in starts], [[] for _ in pilots], 0.0
    for pilot, pose in zip(pilots, poses, strict=True):
        pilot.position = pose[:2]
    while time < seconds and not all(pilot.is_done for pilot in pilots):
        for k, pilot in enumerate(pilots):
            speed, turn = pilot.command(poses[k], time)
            yaw = poses[k][2]
            poses[k] = poses[k] + np.array([speed * math.cos(yaw), speed * math.sin(yaw), turn]) * 0.05
            tracks[k].append(poses[k])
        time += 0.05
    return np.array(tracks), time


def plain_office(
    seed: int, *, size_m: tuple[float, float] = (14.0, 10.0), rooms: int = 6, oblique: float = 0.3
) -> World:
    """Make an upright office that both visits find alike, without glass."""
    spec = Office(size_m=size_m, rooms=rooms, oblique=oblique, yaw_deg=0.0, glass=0.0, shut=0.0, changed=0.0)
    return make_world(spec, seed)


@functools.cache
def office_log() -> MissionLog:
    """Make the log of two robots that stand in rooms of a small office, with exact rays."""
    world = plain_office(4, oblique=0.0)
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


@functools.cache
def walked_log() -> MissionLog:
    """Make the log of two robots that tour a small office from both ends, each as if alone."""
    world = plain_office(4, oblique=0.0)
    lidar = Lidar(beams=360)
    spec = MissionSpec(a=RobotSpec(lidar=lidar), b=RobotSpec(lidar=lidar))
    rooms = sorted(world.rooms, key=lambda room: float(room.spot[0]))
    a, b = (_walking(world, chosen, lidar) for chosen in (rooms, rooms[::-1]))
    return MissionLog(world=world, spec=spec, seed=0, a=a, b=b)


def _walking(world: World, rooms: list[Room], lidar: Lidar) -> RobotLog:
    planner, caster = PathPlanner(make_drive_field(world)), Caster(world, lidar.height_m)
    pilot = Pilot(Tour(planner, [(room.name, room.spot) for room in rooms]), planner, Steering(speed_m_s=0.9))
    poses = drive_exactly([pilot], [(*rooms[0].spot, 0.0)], 200.0)[0][0][::5]  # (S, 3)
    ranges = [caster.cast(pose, lidar.angles, lidar.max_range_m, np.empty((0, 3))).ranges for pose in poses]
    return RobotLog(times=np.arange(len(poses)) / 4, poses=poses, odometry=poses, ranges=np.array(ranges))


def wall_distance(world: World, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distance of points (N, 2) to the nearest edge of an obstacle that a robot cannot drive under."""
    nearest = np.full(len(points), np.inf)
    for prism in (p for p in world.obstacles if p.bottom <= SCAN_HEIGHT_M):
        for start, end in zip(prism.outline, np.roll(prism.outline, -1, axis=0), strict=True):
            edge = end - start
            share = np.clip(((points - start) @ edge) / (edge @ edge), 0.0, 1.0)
            nearest = np.minimum(nearest, np.hypot(*(points - start - share[:, None] * edge).T))
    return nearest


def glass_world() -> World:
    """Make the box with a pane across a part of it, a crate of the visit of A and another of the visit of B."""
    pane = Prism(np.array([[4.6, 1.2], [4.62, 1.2], [4.62, 3.8], [4.6, 3.8]]), 2.5)
    crates = [Prism(np.array([[2.2, y], [2.6, y], [2.6, y + 0.4], [2.2, y + 0.4]]), 0.9) for y in (0.4, 3.0)]
    return replace(box_world(), glass=(pane,), visits=((crates[0],), (crates[1],)))


def free_cells(robot: RobotLog, lidar: Lidar) -> set[tuple[int, ...]]:
    """Return the free cells of the map of a robot, in a frame that all maps share."""
    poses, ranges = robot.poses, lidar.limit(robot.ranges)
    grid = build_map(poses, lidar.angles, ranges, resolution=0.05, max_range_m=lidar.max_range_m)
    points = grid.pixel_to_map(np.argwhere(grid.free)[:, ::-1])
    return {tuple(cell) for cell in np.floor(points / 0.05).astype(int).tolist()}
