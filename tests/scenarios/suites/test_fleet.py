from dataclasses import replace

import numpy as np
import pytest

from rectmerge.errors import InputError, ScenarioError
from scenarios.pairs.truth import control_point_rmse
from scenarios.suites.fleet import FleetScenario, FleetSource
from scenarios.suites.suite import load_suite
from sim.floorplans import Office
from sim.missions.spec import MissionSpec, RobotSpec
from sim.sensors.lidar import Lidar

ROBOT = RobotSpec(scan_hz=2.0, lidar=Lidar(beams=180))
SCENARIO = FleetScenario(
    name="tiny",
    noise=0,
    world=Office(size_m=(18.0, 12.0), rooms=6, glass=0.0, shut=0.0, changed=0.0),
    mission=MissionSpec(rays="compiled", max_seconds=25.0, a=ROBOT, b=ROBOT),
    robots=3,
    maps=4,
    siblings=1,
    stretch=(0.6, 0.9),
)


@pytest.mark.sim
def test_a_fleet_is_every_pair_of_its_maps_with_the_truth_of_those_of_one_building():
    source = FleetSource("fleets", SCENARIO, 3)
    pairs = {pair.pair_id: pair for pair in source.pairs()}

    assert tuple(pairs) == source.pair_ids
    assert len(pairs) == 10
    for pair_id, pair in pairs.items():
        assert pair.related <= source.is_related(pair_id)
        assert source.is_related(pair_id) == (pair.info["place_a"] == pair.info["place_b"])
        assert pair.info["fleet"] == source.source_id
        if pair.related:  # by true poses and without noise the truth leaves about nothing
            assert control_point_rmse(pair.pixels.matrix, pair.control_points) < 0.6
    assert sum(pair.related for pair in pairs.values()) >= 4
    of_first = [pair.a for pair in pairs.values() if pair.info["map_a"] == "home-00"]
    assert all(np.array_equal(grid.occupancy, of_first[0].occupancy) for grid in of_first)
    again = next(iter(FleetSource("fleets", SCENARIO, 3).pairs()))
    assert np.array_equal(again.a.occupancy, of_first[0].occupancy)


def test_a_suite_with_the_key_maps_is_of_fleets():
    sources = load_suite("fleet-8").sources()

    assert {type(source) for source in sources} == {FleetSource}
    assert len(sources) >= 20
    assert {source.scenario.map.poses for source in sources} == {"truth", "slam"}
    assert {source.scenario.siblings for source in sources} >= {2, 3}
    assert load_suite("fleet-8").missions() == []
    assert all(source.scenario.is_growing for source in load_suite("fleet-growing").sources())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"robots": 1}, "robots must be 2 to 8"),
        ({"maps": 2}, "a fleet has 3 to 100 maps"),
        ({"stretch": (0.6, 0.3)}, "stretch must be two ascending numbers"),
        ({"resolution": (0.05, 2.0)}, "resolution must be two ascending numbers"),
        ({"noise": 7}, "noise must be one of"),
        ({"mission": MissionSpec(overlap=0.5)}, "mission.overlap"),
        ({"name": "a b"}, "name must be letters"),
    ],
)
def test_a_value_out_of_range_is_refused(change, message):
    with pytest.raises(InputError, match=message):
        replace(SCENARIO, **change)


def test_an_unknown_key_is_refused_with_its_path(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('title = "x"\n[[scenarios]]\nname = "y"\nmaps = 4\nsisters = 1\n')

    with pytest.raises(ScenarioError, match=r"mine.toml: scenarios\[0\].*unknown key 'sisters'"):
        load_suite(file)
