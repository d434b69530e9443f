"""Faults of a mission: a robot through a wall, or stuck without a note."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sim.missions.mission_log import STUCK_SHARE, MissionLog, RobotLog
from sim.world import World

STEP_M = 0.03  # between the points of a robot's path that are looked up in the plan
PLAN_M = 0.02  # cells of that plan


def mission_faults(log: MissionLog) -> tuple[str, ...]:
    """List the faults of a mission, one line each."""
    faults = []
    for visit, (name, robot) in enumerate((("A", log.a), ("B", log.b))):
        if crosses_walls(log.world, robot, visit):
            faults.append(f"robot {name} went through a wall")
        if robot.stuck_s > STUCK_SHARE * float(robot.times[-1]) and "no progress" not in robot.note:
            faults.append(f"robot {name} was stuck for {robot.stuck_s:.0f} s and did not say so")
    return tuple(faults)


def crosses_walls(world: World, robot: RobotLog, visit: int) -> bool:
    """Return whether the centre of a robot was ever in a wall, a pane, or tall furniture."""
    visited = world.at_visit(visit)
    solid = replace(visited, rooms=(), doors=(), floor=()).raster(PLAN_M).occupied
    positions = robot.poses[:, :2]
    lengths = np.hypot(*np.diff(positions, axis=0).T)
    shares = [np.linspace(0, 1, max(2, math.ceil(length / STEP_M)))[:, None] for length in lengths]
    path = [p + share * (q - p) for p, q, share in zip(positions[:-1], positions[1:], shares, strict=True)]
    cols, up = np.floor(np.concatenate(path) / PLAN_M).astype(np.intp).T
    return bool(solid[solid.shape[0] - 1 - up, cols].any())
