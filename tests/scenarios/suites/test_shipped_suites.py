"""What the suites that come with the package promise."""

from collections import Counter
from dataclasses import replace
from itertools import product

import pytest

from scenarios.suites.mission_source import MAX_BUILDINGS
from scenarios.suites.spec import UNRELATED
from scenarios.suites.suite import load_suite, suite_names
from sim.floorplans import FAMILIES

HELD_OUT = {"two-wing", "round"}
LARGE = {"standard", "trust", "conditions", "repetitive"}


def pairs_of(sources):
    return sum(len(source.pair_ids) for source in sources)


@pytest.fixture(scope="module")
def standard():
    return load_suite("standard").sources()


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in LARGE else name for name in suite_names()]
)
def test_ids_are_unique_and_splits_share_no_building(name):
    suite = load_suite(name)
    sources, splits = suite.sources(), {}
    for source in suite.missions():
        for building, purpose in product(range(MAX_BUILDINGS), ("world", *(f"other world {k}" for k in range(40)))):
            seed = replace(source, building=building)._seed(purpose)
            splits.setdefault(seed, set()).add(source.scenario.split)

    ids = [pair_id for source in sources for pair_id in source.pair_ids]
    assert len(set(ids)) == len(ids)
    assert all(len(kept) == 1 for kept in splits.values())


def test_the_standard_suite_holds_what_the_leaderboard_needs(standard):
    related = [source.scenario for source in standard if source.scenario.kind == "related"]
    unrelated = Counter(source.scenario.kind for source in standard if source.scenario.kind != "related")

    assert len(related) >= 240
    assert set(unrelated) == set(UNRELATED) - {"other-storey"}  # a suite of its own
    assert sum(unrelated.values()) >= 150
    assert min(unrelated.values()) >= 30
    assert {scenario.world.family for scenario in related} == set(FAMILIES)
    assert {level for scenario in related for level in scenario.noise} == {0, 1, 2}
    assert Counter(scenario.a.poses for scenario in related)["slam"] == len(related) / 2
    assert all((scenario.a.turn_deg, scenario.b.turn_deg) == ("random", "random") for scenario in related)


@pytest.mark.parametrize(
    ("read", "low", "high"),
    [
        (lambda scenario: scenario.mission.overlap, 0.15, 1.0),
        (lambda scenario: scenario.b.resolution / scenario.a.resolution, 0.6, 1.6),
    ],
)
def test_the_standard_suite_fills_its_ranges(standard, read, low, high):
    values = [read(source.scenario) for source in standard if source.scenario.kind == "related"]

    assert low <= min(values) < low + 0.05 * (high - low)
    assert high - 0.05 * (high - low) < max(values) <= high * (1 + 1e-9)


def test_two_families_are_held_out_for_the_test_split(standard):
    splits = {}
    for source in standard:
        splits.setdefault(source.scenario.world.family, set()).add(source.scenario.split)

    assert {family for family, kept in splits.items() if kept == {"test"}} == HELD_OUT
    assert all(kept == {"train", "test"} for family, kept in splits.items() if family not in HELD_OUT)


def test_repetitive_wards_come_in_three_jitters_at_one_overlap():
    sources = load_suite("repetitive").sources()

    assert pairs_of(sources) >= 150
    assert {source.scenario.world.jitter_m for source in sources} == {0.0, 0.15, 0.5}
    assert {(source.scenario.world.family, source.scenario.mission.overlap) for source in sources} == {
        ("hospital", 0.6)
    }


def test_sweeps_change_one_thing_over_one_mission():
    read = {name: load_suite(f"sweep-{name}").sources()[0].scenario for name in ("overlap", "scale", "noise")}

    assert [variant.overlap for variant in read["overlap"].variants] == [0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0]
    ratios = [variant.b.resolution / variant.a.resolution for variant in read["scale"].variants]
    assert ratios == pytest.approx([0.5, 0.6, 0.8, 1.0, 1.25, 1.6, 2.0])
    assert read["noise"].noise == (0, 1, 2, 3)
    assert {variant.a for variant in read["scale"].variants} == {read["scale"].a}


def test_large_maps_are_made_at_their_own_resolution():
    for source in load_suite("large").sources():
        sides = [source.scenario.world.size_m[0] / variant.a.resolution for variant in source.scenario.variants]
        assert sides == pytest.approx([2000, 4000])
        assert {variant.a.turn for variant in source.scenario.variants} == {"frame"}
