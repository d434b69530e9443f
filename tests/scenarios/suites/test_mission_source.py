"""Missions that cannot have what is wanted, and what is made in their place."""

from dataclasses import replace
from itertools import product

import pytest

from rectmerge.errors import SimulationError
from scenarios.dataset.packing import make
from scenarios.suites import mission_source as missionsource
from scenarios.suites.mission_source import MAX_BUILDINGS, MissionSource
from scenarios.suites.spec import Scenario
from tests.scenarios.known_answers import pair
from tests.sim.small_worlds import office_log

SOURCE = MissionSource("made", Scenario(name="office", noise=(0, 1)), 3)


@pytest.fixture
def buildings(monkeypatch):
    """Say what each building gives: None is no mission, else the noise levels whose pair it has."""

    def say(*given):
        tried = []

        def mission(source):
            tried.append(source.building)
            if given[source.building] is None:
                raise SimulationError("the robots met a wall")
            return replace(office_log(), discarded=("they fell",))

        def made(source, log, variant, noise):
            if noise not in given[source.building]:
                raise SimulationError(f"too little at {noise}")
            return log, pair(source._pair_id(variant, noise), info={"building": source.building}, a=log.a, b=log.b)

        monkeypatch.setattr(MissionSource, "mission", mission)
        monkeypatch.setattr(MissionSource, "_pair", made)
        monkeypatch.setattr(missionsource, "identifiable_margin", lambda log, pair: 1.0)
        return tried

    return say


def test_a_mission_that_has_every_pair_is_not_run_again(buildings):
    tried = buildings((0, 1))
    explored = SOURCE.mission_pairs()

    assert tried == [0]
    assert [explored_pair.pair_id for explored_pair in explored.pairs] == list(SOURCE.pair_ids)
    assert all(explored_pair.related and SOURCE.is_related(explored_pair.pair_id) for explored_pair in explored.pairs)
    assert (explored.log.discarded, explored.failed) == (("they fell",), {})


def test_another_building_is_taken_where_a_pair_is_not_to_be_had_and_its_tries_are_told(buildings):
    tried = buildings(None, (1,), (0, 1))
    explored = SOURCE.mission_pairs()

    assert tried == [0, 1, 2]
    assert [explored_pair.info["building"] for explored_pair in explored.pairs] == [2, 2]
    assert explored.log.discarded == ("the robots met a wall", "they fell", "too little at 0", "they fell")
    assert explored.failed == {}


def test_where_no_building_has_every_pair_the_first_with_most_counts_and_the_rest_is_told(buildings):
    tried = buildings((), (1,), None, (0,), None, ())
    explored = SOURCE.mission_pairs()

    assert tried == list(range(MAX_BUILDINGS))
    assert [(explored_pair.pair_id, explored_pair.info["building"]) for explored_pair in explored.pairs] == [
        ("office-0003-n1", 1)
    ]
    assert explored.failed == {"office-0003-n0": "too little at 0"}
    assert explored.log.discarded.count("the robots met a wall") == 2
    with pytest.raises(SimulationError, match="office-0003-n0: too little at 0"):
        list(SOURCE.pairs())


def test_where_no_building_has_a_mission_every_pair_fails_with_the_reason(buildings):
    buildings(*[None] * MAX_BUILDINGS)
    failed = make(SOURCE, 0).package.failed

    assert failed.keys() == set(SOURCE.pair_ids)
    assert "no mission in 6 buildings, the last: the robots met a wall" in failed["office-0003-n1"]


def test_buildings_share_no_seed_and_the_first_keeps_its_own():
    seeds = [
        replace(SOURCE, seed=seed, building=building)._seed(purpose)
        for seed, building, purpose in product(range(20), range(MAX_BUILDINGS), ("world", "mission", "pair"))
    ]

    assert len(set(seeds)) == len(seeds)
    assert replace(SOURCE, building=0)._seed("world") == SOURCE._seed("world")
