"""Fleets of simulated robots in a small office: their maps as they grow, and where each map lies."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rectmerge.analysis.displacement import displacement_cells
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.similarity import Similarity
from sim.missions.mission import run_fleet
from sim.missions.spec import MissionSpec, RobotSpec
from sim.sensors.lidar import Lidar
from sim.slam.mapping import growing_maps
from sim.slam.poses import relative_poses
from tests.sim.small_worlds import plain_office

ROBOT = RobotSpec(scan_hz=2.0, lidar=Lidar(beams=360), share=0.8)
SPEC = MissionSpec(max_seconds=25.0, a=ROBOT, b=ROBOT, rays="compiled")
VERSIONS = 6  # of each robot's map


class Explorer(NamedTuple):
    """Robot of a fleet: its map as it grows, and the pose of its map frame in the building."""

    name: str
    maps: list[OccupancyGrid]
    in_world: Similarity


def explore(robots: int, seed: int = 3) -> list[Explorer]:
    """Let robots drive in one office; the map frame of each begins at its first pose."""
    explorers = []
    for number, log in enumerate(run_fleet(plain_office(2), SPEC, robots, seed), start=1):
        counts = np.unique(np.linspace(6, len(log.times), VERSIONS).astype(int)).tolist()
        x, y, yaw = log.poses[0].tolist()
        poses = relative_poses(log.poses[0], log.poses)
        lidar = ROBOT.lidar
        grown = growing_maps(poses, lidar.angles, log.ranges, counts, resolution=0.05, max_range_m=lidar.max_range_m)
        name = f"robot{number}"
        maps = [replace(grid, frame=f"{name}/map") for grid in grown]
        explorers.append(Explorer(name, maps, Similarity(1.0, yaw, x, y)))
    return explorers


def misplaced_cells(placement: Similarity, reference: Explorer, explorer: Explorer, grid: OccupancyGrid) -> float:
    """Return how far a placement of a version of a robot's map lies from the true one, cells of the reference."""
    truth = reference.in_world.inverse() @ explorer.in_world
    found, right = (map_frame_to_pixels(each, reference.maps[-1], grid) for each in (placement, truth))
    return displacement_cells(grid, found, right)
