import pytest

from scenarios.scoring.score import grade, measure_errors
from scenarios.studies.fleet_entrants import Remembered, ask_all, join_by_tree, join_jointly, make_lies
from tests.rectmerge.fleet.fleets import Oracle
from tests.scenarios.dataset.drawn_fleet import DrawnFleet


@pytest.fixture(scope="module")
def made():
    return DrawnFleet(seed=0).made()


@pytest.fixture(scope="module")
def truth():
    return {(pair.info["map_a"], pair.info["map_b"]): pair for pair in DrawnFleet(seed=0).pairs()}


def test_a_tree_chains_the_accepted_pairs(made):
    answers = ask_all(Remembered(Oracle(made, noise=0.0), made.maps))

    joined = join_by_tree(answers)

    assert {frozenset(names) for names in joined.components} == {
        frozenset({"home0", "home1", "home2"}), frozenset({"other0", "other1"})
    }  # fmt: skip
    assert len(joined.used) == 3
    for a, b in (("home0", "home2"), ("other0", "other1")):
        found = joined.pixels[a].inverse() @ joined.pixels[b]
        assert made.error(found, a, b) < 1e-6


def test_a_method_is_asked_once_about_a_pair_and_lies_where_it_is_told_to(made, truth):
    oracle = Oracle(made)
    method = Remembered(oracle, made.maps)
    answers = ask_all(method)
    joined, _ = join_jointly(method)

    lies = make_lies("drawn", truth, answers)
    told = ask_all(method.telling(lies))

    assert len(oracle.asked) == len(answers) == 10
    assert set(joined.answers) <= set(answers)
    assert len(lies) == 1
    for pair, lie in lies.items():
        assert told[pair]
        assert told[pair].candidates[0].pixels == lie
        if truth[pair].related:
            assert grade(measure_errors(lie, truth[pair]), 0.0) == "off"
    assert {pair for pair in answers if told[pair] is not answers[pair] and pair in lies} == set(lies)
