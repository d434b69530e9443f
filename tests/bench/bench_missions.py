"""Missions per minute on one core: two robots, 120 simulated seconds, 360 beams at 5 Hz, contact physics at 60 Hz.

A whole mission: it is driven, both robots estimate their poses by `slam`, and both maps are built. `*_s` are the
seconds of each stage.
"""

from __future__ import annotations

import time

import numpy as np
import pytest

from sim.floorplans import Office, make_world
from sim.missions.mission import run_mission
from sim.missions.mission_log import MissionLog
from sim.missions.spec import MissionSpec, RobotSpec
from sim.slam.mapping import build_map
from sim.slam.pose_sources import estimate_poses
from sim.world import World

AIM_PER_MINUTE = {"pybullet": 9, "compiled": 12}
RESOLUTION = 0.05


def whole_mission(world: World, spec: MissionSpec) -> tuple[MissionLog, dict[str, float]]:
    """Run a mission and make its maps; return its log and the seconds of each stage."""
    started = time.perf_counter()
    log = run_mission(world, spec, 0)
    seconds = {**log.seconds, "matching": 0.0, "mapping": 0.0}
    for robot, kind in ((log.a, spec.a), (log.b, spec.b)):
        lidar, rng = kind.lidar, np.random.default_rng(0)
        ranges = lidar.observe(robot.ranges, robot.glass, rng)
        began = time.perf_counter()
        poses = estimate_poses(
            "slam", poses=robot.poses, angles=lidar.angles, ranges=ranges, max_range_m=lidar.max_range_m, rng=rng
        )
        matched = time.perf_counter()
        build_map(poses, lidar.angles, ranges, resolution=RESOLUTION, max_range_m=lidar.max_range_m)
        seconds["matching"] += matched - began
        seconds["mapping"] += time.perf_counter() - matched
    seconds["rest"] = time.perf_counter() - started - sum(spent for stage, spent in seconds.items() if stage != "rest")
    return log, seconds


@pytest.mark.parametrize("path", ["tour", "frontier"])
@pytest.mark.parametrize("rays", ["pybullet", "compiled"])
def test_mission(benchmark, rays, path):
    world = make_world(Office(size_m=(40.0, 26.0), rooms=12), 0)
    robot = RobotSpec(scan_hz=5.0, path=path, share=1.0 if path == "tour" else None)
    spec = MissionSpec(a=robot, b=robot, rays=rays, max_seconds=120.0)
    log, seconds = benchmark.pedantic(whole_mission, (world, spec), rounds=3, warmup_rounds=1)

    stages = {f"{stage}_s": round(spent, 2) for stage, spent in seconds.items()}
    benchmark.extra_info |= stages | {
        "missions_per_minute": round(60 / benchmark.stats.stats.min, 1),
        "aim": f">= {AIM_PER_MINUTE[rays]} missions a minute",
    }
    assert min(log.a.times[-1], log.b.times[-1]) > 119  # both were busy all the time
