import dataclasses
import math
import pickle
from dataclasses import asdict, replace

import numpy as np
import pytest

from rectmerge.errors import ScenarioError
from scenarios.suites.spec import Seeds
from scenarios.suites.suite import load_suite, suite_names, with_cell_noise
from sim.floorplans import Hospital, Office
from sim.sensors.lidar import LIDARS, Lidar

GOOD = """
title = "Two"
[[methods]]
label = "p"
method = "paper"
set = { delta_cells = 2 }
[[scenarios]]
name = "one"
seeds = { first = 3, count = 2 }
noise = [0, 1]
world = { rooms = 6, size_m = [14, 10.0] }
mission = { max_seconds = 20.0, a = { share = 0.9, scan_hz = 2.0, lidar = { beams = 180 } }, b = { scan_hz = 2.0 } }
a = { turn_deg = "random" }
b = { resolution = 0.06, turn_deg = 30, turn = "image" }
[[scenarios]]
name = "two"
"""


def written(tmp_path, text):
    path = tmp_path / "some.toml"
    path.write_text(text)
    return path


def test_a_suite_reads_as_written(tmp_path):
    suite = load_suite(written(tmp_path, GOOD))
    scenario = suite.scenarios[0]

    assert (suite.name, suite.title, suite.methods[0].set) == ("some", "Two", {"delta_cells": 2})
    assert (scenario.world.rooms, scenario.world.size_m, scenario.mission.a.lidar.beams) == (6, (14.0, 10.0), 180)
    assert (scenario.a.turn_deg, scenario.b.turn_deg, scenario.b.turn) == ("random", 30, "image")
    assert (scenario.seeds, scenario.noise) == (Seeds(first=3, count=2), (0, 1))
    assert suite.scenarios[1].world == Office()


def test_robots_that_map_by_their_own_poses_may_differ_in_their_mappers(tmp_path):
    slam = 'a = { poses = "slam", loop_closure = true, slam = { wheel_level = 2.0 }, miss = 0.3 }'
    scenario = load_suite(written(tmp_path, GOOD.replace('a = { turn_deg = "random" }', slam))).scenarios[0]

    a, b = scenario.a, scenario.b
    assert (a.poses, a.loop_closure, a.slam.wheel_level, a.miss) == ("slam", True, 2.0, 0.3)
    assert (b.poses, b.loop_closure, b.slam.wheel_level, b.miss) == ("truth", False, 1.0, 0.4)


@pytest.mark.parametrize(
    ("written_as", "meant"),
    [
        ('"utm-30lx"', LIDARS["utm-30lx"]),
        ('{ profile = "utm-30lx", beams = 90 }', replace(LIDARS["utm-30lx"], beams=90)),
        ("{ dropout = 0 }", Lidar(dropout=0.0)),
    ],
)
def test_a_scanner_is_a_profile_a_table_or_both(tmp_path, written_as, meant):
    suite = load_suite(written(tmp_path, GOOD.replace("{ beams = 180 }", written_as)))

    assert suite.scenarios[0].mission.a.lidar == meant


def test_the_family_of_a_world_says_which_knobs_it_has(tmp_path):
    world = 'world = { family = "hospital", size_m = [30, 14], jitter_m = 0.15, yaw_deg = 30, door_m = [1, 1.2] }'
    suite = load_suite(written(tmp_path, GOOD.replace("world = { rooms = 6, size_m = [14, 10.0] }", world)))

    assert suite.scenarios[0].world == Hospital(size_m=(30.0, 14.0), jitter_m=0.15, yaw_deg=30, door_m=(1.0, 1.2))
    assert asdict(suite.scenarios[0])["world"]["family"] == "hospital"
    assert asdict(suite.scenarios[1])["world"]["family"] == "office"


def test_there_is_one_source_per_mission_with_an_id_per_noise_level(tmp_path):
    sources = load_suite(written(tmp_path, GOOD)).sources()

    assert [source.source_id for source in sources] == ["one-0003", "one-0004", "two-0000"]
    assert sources[0].pair_ids == ("one-0003-n0", "one-0003-n1")
    assert pickle.loads(pickle.dumps(sources[0])) == sources[0]


def test_scenarios_seeds_and_purposes_draw_from_seeds_of_their_own(tmp_path):
    sources = load_suite(written(tmp_path, GOOD)).sources()
    seeds = [source._seed(purpose) for source in sources for purpose in ("world", "mission", "pair")]

    assert len(set(seeds)) == len(seeds)


def test_a_suite_has_a_version_and_its_first_one_has_even_noise_of_the_cells(tmp_path):
    suite = load_suite(written(tmp_path, f"version = 2\n{GOOD}"))
    old = with_cell_noise(suite)

    assert {source.version for source in suite.sources()} == {2}
    assert {source.version for source in old.sources()} == {1}
    assert [scenario.noise for scenario in old.scenarios] == [(0, "cells-1"), (0,)]
    assert old.sources()[0].pair_ids == ("one-0003-n0", "one-0003-ncells-1")
    assert load_suite(written(tmp_path, GOOD.replace("[0, 1]", '["cells-3"]'))).scenarios[0].noise == ("cells-3",)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("seeds = { first = 3, count = 2 }", 'seeds = "a"', "scenarios[0].seeds"),
        ("seeds = { first = 3, count = 2 }", "seeds = { count = 100000000 }", "scenarios[0].seeds: seeds need first"),
        ("rooms = 6", "romms = 6", "scenarios[0].world: unknown key 'romms'"),
        ('name = "two"', 'name = "two"\nseed = 1', "scenarios[1]: unknown key 'seed'"),
        ("beams = 180", "beam = 180", "scenarios[0].mission.a.lidar: unknown key 'beam'"),
        ("{ beams = 180 }", '"rplidar"', "scenarios[0].mission.a.lidar: no lidar 'rplidar'; there are: rplidar-a1,"),
        ("{ beams = 180 }", "{ profile = 1 }", "scenarios[0].mission.a.lidar: no lidar 1; there are: rplidar-a1,"),
        ("{ beams = 180 }", "{ beams = 0 }", "scenarios[0].mission.a.lidar: beams must be 1 to 3600, got 0"),
        ("{ beams = 180 }", "180", "scenarios[0].mission.a.lidar: must be a table or a list"),
        ("{ beams = 180 }", "[180]", "scenarios[0].mission.a.lidar: must be a table or a list"),
        ("{ beams = 180 }", '{ profile = "lms1xx", beam = 9 }', "scenarios[0].mission.a.lidar: unknown key 'beam'"),
        ('title = "Two"', 'title = "Two"\nname = "x"', "unknown key 'name'"),
        ('title = "Two"', "", "title: missing"),
        ("rooms = 6", 'family = "hall", rooms = 6', "scenarios[0].world: unknown key 'rooms'"),
        (
            "rooms = 6",
            'family = "cave"',
            "scenarios[0].world: family must be one of office, apartment, warehouse, loop, hospital, ",
        ),
        ("rooms = 6", "family = 3", "scenarios[0].world: family must be one of office, "),
        ("rooms = 6", "family = []", "scenarios[0].world: family must be one of office, "),
        ("rooms = 6", "yaw_deg = true", "scenarios[0].world: yaw_deg must be a number of degrees or"),
        ("{ rooms = 6, size_m = [14, 10.0] }", "3", "scenarios[0].world: must be a table or a list"),
        ("rooms = 6", 'rooms = "6"', "scenarios[0].world.rooms: must be a whole number, got '6'"),
        ("rooms = 6", "rooms = 3", "scenarios[0].world: rooms must be 6 to 12, got 3"),
        ("share = 0.9", "share = true", "scenarios[0].mission.a.share: must be a number, got True"),
        ("noise = [0, 1]", "noise = [0, 7]", "scenarios[0]: noise must list different levels"),
        ('turn = "image"', 'turn = "both"', "scenarios[0].b.turn: must be one of 'frame', 'image', got 'both'"),
        ('name = "two"', 'name = "one"', "scenarios: two have the same name"),
        ("[14, 10.0]", "[14]", "scenarios[0].world.size_m: "),
        ("noise = [0, 1]", 'noise = [0, "salt"]', "scenarios[0]: noise must list different levels"),
        ("noise = [0, 1]", "noise = [0, 1.5]", "scenarios[0].noise[1]: must be a level of noise, got 1.5"),
        ("noise = [0, 1]", "noise = 0", "scenarios[0].noise: must be a table or a list"),
        ("set = { delta_cells = 2 }", "set = 2", "methods[0].set: must be a table or a list"),
        ('title = "Two"', "title = Two", "not TOML: "),
        (GOOD, 'title = "Empty"', "scenarios: there are none"),
    ],
)
def test_a_mistake_is_refused_with_its_path(tmp_path, old, new, complaint):
    assert old in GOOD
    with pytest.raises(ScenarioError) as refused:
        load_suite(written(tmp_path, GOOD.replace(old, new, 1)))

    assert str(refused.value).startswith(f"some.toml: {complaint}")
    assert "\n" not in str(refused.value)


def test_an_unknown_suite_names_those_there_are(tmp_path):
    with pytest.raises(
        ScenarioError, match=r"no suite 'headlin'; there are: bent, conditions, demo, fleet-20, fleet-3"
    ):
        load_suite("headlin")
    with pytest.raises(ScenarioError, match=r"none\.toml: cannot be read"):
        load_suite(tmp_path / "none.toml")


@pytest.mark.parametrize("name", suite_names())
def test_every_suite_that_comes_with_the_package_loads(name):
    suite = load_suite(name)

    assert suite.name == name
    assert suite.title
    assert suite.methods
    assert suite.sources()


def test_the_headline_suite_keeps_the_papers_arithmetic():
    (headline,) = load_suite("headline").scenarios
    a, b = headline.a, headline.b

    assert (headline.seeds, headline.noise) == (Seeds(first=0, count=50), (0, "cells-1"))
    assert b.resolution / a.resolution == pytest.approx(38 / 32)
    for spec, canvas, turn in ((a, (361, 317), 27.0), (b, (393, 393), 225.0)):
        (w, h), angle = spec.extent_cells, math.radians(turn)
        cos, sin = abs(math.cos(angle)), abs(math.sin(angle))
        assert (spec.turn, spec.turn_deg, spec.canvas) == ("image", turn, canvas)
        assert (round(w * cos + h * sin), round(w * sin + h * cos)) == canvas
    assert sum(b.extent_cells) == 556
    assert sum(b.extent_cells) * 38 / 32 == pytest.approx(660, abs=1)
    assert sum(a.extent_cells) == 504
    assert (headline.world.family, headline.world.yaw_deg) == ("office", 0.0)
    assert np.all(np.array(headline.world.size_m) < np.array(b.extent_cells) * b.resolution)


@pytest.mark.sim
def test_a_source_yields_the_pairs_it_announced(tmp_path):
    source = load_suite(written(tmp_path, GOOD)).sources()[0]
    pairs = list(source.pairs())

    assert tuple(pair.pair_id for pair in pairs) == source.pair_ids
    assert {pair.place for pair in pairs} == {"some/one-0003"}
    assert [pair.info["noise"] for pair in pairs] == [0, 1]
    assert all(pair.related for pair in pairs)


def test_the_test_seeds_of_headline_differ_in_nothing_else():
    (chosen_on,), (tested_on,) = (load_suite(name).scenarios for name in ("headline", "headline-test"))

    assert tested_on.seeds == Seeds(first=50, count=50)
    assert dataclasses.replace(tested_on, seeds=chosen_on.seeds) == chosen_on


@pytest.mark.sim
@pytest.mark.slow
def test_headline_maps_have_the_papers_canvases_and_scale():
    pair = next(load_suite("headline").sources()[0].pairs())

    assert (pair.a.shape, pair.b.shape) == ((317, 361), (393, 393))
    assert pair.pixels.scale == pytest.approx(1.1875)
    assert math.degrees(pair.pixels.angle) % 360 == pytest.approx(225 - 27)


@pytest.mark.sim
@pytest.mark.parametrize(
    ("wanted", "corruption"), [(0.5, ""), (0.35, 'poses = "slam", corruption = [["dilation", 1]]')]
)
def test_finished_maps_have_the_overlap_that_a_suite_asks_for(tmp_path, wanted, corruption):
    suite = f"""
title = "One"
[[scenarios]]
name = "one"
noise = [0, 2]
world = {{ size_m = [20.0, 13.0], rooms = 8 }}
mission = {{ overlap = {wanted}, max_seconds = 120.0, rays = "compiled" }}
a = {{ {corruption} }}
"""
    (source,) = load_suite(written(tmp_path, suite)).sources()

    for pair in source.pairs():
        assert pair.overlap == pytest.approx(wanted, abs=0.05)


SEEDS = {
    "demo-0000": [3475216114, 2277288749, 3250331810],
    "headline-0049": [4222533316, 1888411709, 2373823321],
}


def test_seeds_are_what_they_always_were():
    seeds = {
        source.source_id: [source._seed(purpose) for purpose in ("world", "mission", "pair")]
        for source in (load_suite("demo").sources()[0], load_suite("headline").sources()[-1])
    }

    assert seeds == SEEDS
