"""Missions of more than two robots."""

from dataclasses import replace

import numpy as np
import pytest

from rectmerge.errors import InputError
from sim.missions.mission import run_fleet
from sim.missions.spec import MissionSpec, RobotSpec
from sim.sensors.lidar import Lidar
from sim.sensors.ray_casting import Caster
from tests.sim.small_worlds import plain_office, wall_distance

ROBOT = RobotSpec(scan_hz=2.0, lidar=Lidar(beams=180), share=0.5)
SPEC = MissionSpec(max_seconds=25.0, a=ROBOT, b=ROBOT, rays="compiled")
TOUCHING_M = 0.34  # between the centres of two robots


@pytest.fixture(scope="module")
def logs():
    return run_fleet(plain_office(2), SPEC, 5, 3)


@pytest.mark.sim
def test_five_robots_drive_and_keep_off_each_other_and_the_walls(logs):
    assert len(logs) == 5
    scans = min(len(log.times) for log in logs)
    at = np.array([log.poses[:scans, :2] for log in logs])  # scans of one number are of one time
    apart = np.hypot(*(at[:, None] - at[None]).transpose(3, 0, 1, 2))
    assert apart[~np.eye(5, dtype=bool)].min() > TOUCHING_M
    assert wall_distance(plain_office(2), at.reshape(-1, 2)).min() > 0.17
    assert all(np.hypot(*np.diff(log.poses[:, :2], axis=0).T).sum() > 3.0 for log in logs)


@pytest.mark.sim
def test_robots_see_each_other(logs):
    caster = Caster(plain_office(2), ROBOT.lidar.height_m)
    shorter = 0
    for log in logs:
        for pose, ranges in zip(log.poses, log.ranges, strict=True):
            alone = caster.cast(pose, ROBOT.lidar.angles, ROBOT.lidar.max_range_m, np.empty((0, 3))).ranges
            shorter += np.count_nonzero(ranges < alone - 0.05)

    assert shorter > 20


@pytest.mark.sim
def test_the_same_seed_gives_the_same_fleet():
    spec = replace(SPEC, max_seconds=8.0)
    one, same = (run_fleet(plain_office(2), spec, 3, 5) for _ in range(2))

    for first, second in zip(one, same, strict=True):
        assert np.array_equal(first.poses, second.poses)
        assert np.array_equal(first.ranges, second.ranges)


@pytest.mark.parametrize(("robots", "overlap"), [(1, None), (9, None), (3, 0.5)])
def test_a_fleet_that_cannot_be_is_refused(robots, overlap):
    spec = MissionSpec(overlap=overlap)
    with pytest.raises(InputError, match="a fleet has 2 to 8 robots and no overlap, got"):
        run_fleet(plain_office(2), spec, robots, 0)
