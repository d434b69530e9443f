"""Random missions of every family, scanner, path and mapper, from a seed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from scenarios.pairs.map_view import MapSpec
from scenarios.suites.mission_source import MissionSource
from scenarios.suites.spec import Scenario, Seeds
from sim.floorplans import FAMILIES
from sim.missions.spec import MissionSpec, RobotSpec
from sim.sensors.lidar import LIDARS
from sim.slam.pose_sources import PoseSource, Slam

SUITE = "worlds"
HAND_HELD = 0.35  # share of pairs like those of a hand-held depth sensor: bent, stretched, with thick walls
MAX_BEAMS = 720  # of a scanner with more, every k-th is kept


def random_sources(count: int, *, seed: int = 0, poses: tuple[PoseSource, ...] = ("slam",)) -> list[MissionSource]:
    """Draw missions, one pair each: families and pose sources in turn, everything else at random.

    Parameters
    ----------
    count
        Number of missions.
    seed
        Same seed, same missions; a smaller count gives the first of them.
    poses
        The pose sources to go through; both robots of a mission use the same.
    """
    return [_draw(k, seed, poses[k % len(poses)]) for k in range(count)]


def _draw(k: int, seed: int, poses: PoseSource) -> MissionSource:
    rng = np.random.default_rng([seed, k])
    kind = list(FAMILIES.values())[k % len(FAMILIES)]
    mission = MissionSpec(
        a=_robot(rng),
        b=_robot(rng),
        rays="pybullet" if rng.random() < 0.5 else "compiled",
        max_seconds=float(rng.uniform(90.0, 200.0)),
        overlap=float(rng.uniform(0.2, 1.0)),
    )
    is_hand_held = rng.random() < HAND_HELD
    fine = float(rng.uniform(0.02, 0.04) if is_hand_held else rng.uniform(0.03, 0.09))
    scenario = Scenario(
        name=f"{kind.family}-{k:03d}",
        seeds=Seeds(first=seed),
        noise=(0 if is_hand_held else int(rng.choice([0, 1, 2])),),  # hand-held mappers leave no specks
        world=kind(),
        mission=mission,
        a=_map(rng, fine, poses, is_hand_held),
        b=_map(rng, fine * math.exp(rng.uniform(math.log(0.7), math.log(1.5))), poses, is_hand_held),
    )
    return MissionSource(SUITE, scenario, seed)


def _robot(rng: np.random.Generator) -> RobotSpec:
    lidar = LIDARS[str(rng.choice(list(LIDARS)))]
    step = -(-lidar.beams // MAX_BEAMS)
    slots: dict[str, Any] = {name: getattr(lidar, name) for name in lidar.__slots__}
    return RobotSpec(
        lidar=type(lidar)(**{**slots, "beams": lidar.beams // step}),
        speed_m_s=float(rng.uniform(0.5, 1.1)),
        scan_hz=5.0,
        path="frontier" if rng.random() < 0.5 else "tour",
        closes_loop=bool(rng.random() < 0.3),
    )


def _map(rng: np.random.Generator, resolution: float, poses: PoseSource, is_hand_held: bool) -> MapSpec:
    slam = Slam(
        resolution_m=float(rng.uniform(0.03, 0.1)),
        key_distance_m=float(rng.uniform(0.2, 1.2)),
        beams=int(rng.choice([30, 60, 180])),
        wheel_level=math.exp(rng.uniform(math.log(0.5), math.log(8.0))),
    )
    stretch, bend = ("stretch", float(rng.uniform(-3.0, 3.0))), ("bend", float(rng.uniform(0.0, 1.5)))
    corruption = (stretch, bend, ("dilation", float(rng.integers(1, 3)))) if is_hand_held else ()
    return MapSpec(
        resolution=resolution,
        turn_deg="random",
        poses=poses,
        slam=slam,
        corruption=corruption,
        hit=math.exp(rng.uniform(math.log(0.2), math.log(1.1))),
        miss=float(rng.uniform(0.3, 0.9)),
    )
