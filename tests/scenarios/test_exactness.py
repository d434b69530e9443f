import functools
from dataclasses import replace

import numpy as np
import pytest

from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import make_pair
from scenarios.pairs.truth import known_extent
from scenarios.suites.suite import load_suite
from sim.floorplans import FAMILIES, make_world
from sim.missions.mission import run_mission
from sim.missions.mission_log import MissionLog
from sim.missions.spec import MissionSpec, RobotSpec
from tests.scenarios.exactness import raster_shift_cells, wall_offset_px
from tests.sim.small_worlds import office_log


@functools.cache
def simulated() -> MissionLog:
    return load_suite("smoke").sources()[0].mission()


LOGS = [office_log, pytest.param(simulated, marks=pytest.mark.sim)]


@pytest.mark.parametrize("made", LOGS)
@pytest.mark.parametrize("visit", [0, 1])
def test_a_map_by_true_poses_lies_on_the_worlds_raster(made, visit):
    for resolution in (0.05, 0.06):
        assert np.abs(raster_shift_cells(made(), visit, resolution)).max() < 0.5


@pytest.mark.parametrize("made", LOGS)
@pytest.mark.parametrize("turn", ["frame", "image"])
def test_the_truth_takes_the_walls_of_b_onto_those_of_a(made, turn):
    for resolution, noise in ((0.05, 0), (0.07, 0), (0.06, 1)):
        spec_b = MapSpec(resolution=resolution, turn_deg=33.0, turn=turn)
        assert wall_offset_px(make_pair(made(), MapSpec(), spec_b, 4, noise=noise)) < 0.7


def test_a_map_that_lies_a_little_beside_the_raster_is_found_out():
    log = office_log()
    moved = replace(log, a=replace(log.a, poses=log.a.poses + np.array([0.03, -0.03, 0.0])))

    off = raster_shift_cells(moved, 0) - raster_shift_cells(log, 0)
    assert off[0] > 0.3
    assert off[1] < -0.3


@pytest.mark.sim
def test_maps_by_the_robots_own_poses_have_a_truth_that_fits_them_as_far_as_they_drift():
    spec_a, spec_b = MapSpec(poses="slam"), MapSpec(poses="slam", resolution=0.06, turn_deg=20.0)
    pair, again = (make_pair(simulated(), spec_a, spec_b, 5, noise=1) for _ in range(2))

    assert np.array_equal(pair.b.occupancy, again.b.occupancy)
    assert 0.1 < pair.residual_px < 0.03 * known_extent(pair.a)
    assert 0.0 < pair.info["ate_a_m"] < 0.5
    assert pair.info["bent"] == (pair.residual_px > 0.015 * known_extent(pair.a))
    assert wall_offset_px(pair) < 1.2


@pytest.mark.sim
@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_gives_exact_maps_and_exact_truth(family):
    world = make_world(FAMILIES[family](), 1)
    robot = RobotSpec(scan_hz=5.0, share=0.8)
    log = run_mission(world, MissionSpec(a=robot, b=robot, max_seconds=90.0), 1)

    for visit in (0, 1):
        assert np.abs(raster_shift_cells(log, visit)).max() < 0.5
    for turn in ("frame", "image"):
        spec_b = MapSpec(resolution=0.06, turn_deg=33.0, turn=turn)
        assert wall_offset_px(make_pair(log, MapSpec(), spec_b, 4, noise=1)) < 0.7
