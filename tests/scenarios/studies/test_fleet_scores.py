import pytest

from rectmerge.similarity import Similarity
from scenarios.studies.fleet_entrants import Joined
from scenarios.studies.fleet_scores import score_fleet, wrong_maps
from tests.scenarios.dataset.drawn_fleet import DrawnFleet

PLACES = {"a": "home", "b": "home", "c": "home", "x": "sibling"}


@pytest.mark.parametrize(
    ("names", "outcomes", "wrong"),
    [
        ("abc", {("a", "b"): "right", ("b", "c"): "right"}, []),
        ("abc", {("a", "b"): "right", ("b", "c"): "wrong"}, ["c"]),
        ("abc", {("a", "b"): "right"}, []),  # nothing is known of c
        ("abx", {("a", "b"): "nearly"}, ["x"]),
        ("abc", {("a", "b"): "apart", ("b", "c"): "right"}, []),
    ],
)
def test_wrong_maps_are_those_outside_the_largest_group_that_lies_right(names, outcomes, wrong):
    assert wrong_maps(list(names), PLACES, outcomes) == wrong


@pytest.fixture(scope="module")
def fleet():
    source = DrawnFleet(seed=0)
    return source.made(), {(pair.info["map_a"], pair.info["map_b"]): pair for pair in source.pairs()}


def joined(made, names, **moved):
    pixels = {name: moved.get(name, made.poses[name]) for name in names}
    used = [("home0", name) for name in names[1:]]
    return Joined(components=[names], pixels=pixels, answers={}, used=used)


def test_the_true_placements_score_right(fleet):
    made, truth = fleet

    score = score_fleet(joined(made, ["home0", "home1", "home2"]), made.place, truth)

    outcomes = [pair["outcome"] for pair in score["pairs"]]
    assert outcomes.count("right") >= 2
    assert "wrong" not in outcomes
    assert "apart" in outcomes  # the other building's maps
    assert (score["wrong_maps"], score["left_out"], score["maps"]) == (0, 2, 5)
    assert max(pair["scale_error"] for pair in score["pairs"] if pair["outcome"] == "right") < 1e-9


def test_a_map_that_lies_elsewhere_or_is_of_another_building_is_wrong(fleet):
    made, truth = fleet
    off = Similarity(1.0, 0.5, 30.0, 0.0) @ made.poses["home2"]

    moved = score_fleet(joined(made, ["home0", "home1", "home2"], home2=off), made.place, truth)
    mixed = score_fleet(joined(made, ["home0", "home1", "other0"]), made.place, truth)

    assert moved["wrong_maps"] == mixed["wrong_maps"] == 1
    assert not mixed["named"]


def test_a_wrong_map_is_named_where_it_hangs_on_a_bridge_that_the_answer_names(fleet):
    made, truth = fleet
    names = ["home0", "home1", "other0"]
    told = Joined(
        components=[names],
        pixels={name: made.poses[name] for name in names},
        answers={},
        bridges=[("home0", "other0")],
        used=[("home0", "home1"), ("home0", "other0")],
    )

    assert score_fleet(told, made.place, truth)["named"]
