"""Laser rays per second on one core: PyBullet's against the compiled caster's, in an office with another robot."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim.bullet import physics
from sim.floorplans import Office, make_world
from sim.sensors.ray_casting import Caster

AIM_M_RAYS_S = 5.0
HEIGHT_M, REACH_M = 0.25, 12.0


@pytest.mark.parametrize("beams", [360, 1081])
@pytest.mark.parametrize("caster", ["compiled", "pybullet"])
def test_rays(benchmark, caster, beams):
    world = make_world(Office(size_m=(30.0, 20.0), rooms=12), 0).at_visit(0)
    poses = np.array([[*room.spot, 0.4 * k] for k, room in enumerate(world.rooms)])
    angles = np.linspace(-math.pi, math.pi, beams, endpoint=False)
    with physics(world) as engine:
        robots = [engine.add_robot(pose) for pose in poses]
        compiled = Caster(world, HEIGHT_M)

        def scans() -> float:
            met = 0.0
            for k, pose in enumerate(poses):
                if caster == "compiled":
                    reading = compiled.cast(pose, angles, REACH_M, np.roll(poses, -1, axis=0)[k : k + 1])
                else:
                    reading = engine.cast(robots[k], angles, REACH_M, HEIGHT_M)
                met += float(np.isfinite(reading.ranges).mean())
            return met / len(poses)

        met = benchmark.pedantic(scans, rounds=20, warmup_rounds=2)

    rate = beams * len(poses) / benchmark.stats.stats.min / 1e6
    benchmark.extra_info |= {"million_rays_per_s": rate, "met": met}
    if caster == "compiled":
        benchmark.extra_info["aim"] = f">= {AIM_M_RAYS_S} million"
    assert met > 0.5
