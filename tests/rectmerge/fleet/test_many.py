import dataclasses
import itertools
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rectmerge as rm
from rectmerge.errors import InputError
from rectmerge.fleet.many import align_many
from rectmerge.grid import UNKNOWN, OccupancyGrid, pixels_to_map_frame
from rectmerge.similarity import Similarity
from tests import drawing
from tests.rectmerge.fleet.fleets import Oracle, fleet, members, worst_error


@pytest.mark.parametrize("seed", range(3))
def test_maps_of_two_buildings_fall_into_two_components_at_their_true_places(seed):
    made = fleet(seed, home=6, other=3)

    graph = align_many(made.maps, method=Oracle(made))

    assert members(graph) == {frozenset(f"home{k}" for k in range(6)), frozenset(f"other{k}" for k in range(3))}
    assert [len(names) for names in graph.components] == [6, 3]
    assert not graph
    assert not graph.left_out
    assert worst_error(made, graph) < 0.01
    assert len(graph.pairs) == 36


@pytest.mark.slow
def test_the_default_method_places_drawn_maps_and_names_those_of_another_building():
    made = fleet(1, home=4, other=1)

    graph = align_many(made.maps)

    assert members(graph) == {frozenset(f"home{k}" for k in range(4))}
    assert worst_error(made, graph) < 0.01
    assert set(graph.left_out) == {"other0"}
    assert "home" in graph.left_out["other0"]


@pytest.mark.parametrize("is_related", [True, False])
def test_of_two_maps_the_answer_is_that_of_align(is_related):
    a = drawing.building(resolution=0.05)
    b = drawing.view(a, drawing.B_IN_A, (90, 110), resolution=0.06) if is_related else fleet(1).maps["other0"]

    for first, second in ((a, b), (b, a)):
        pair, graph = rm.align(first, second, seed=3), align_many({"x": first, "y": second}, seed=3)

        answer = graph.pairs["x", "y"].alignment
        assert bool(graph) == bool(pair) == is_related
        assert answer.as_dict() | {"seconds": 0} == pair.as_dict() | {"seconds": 0}
        if is_related:
            assert graph.placements["y"].to_reference == pair.b_to_a
            assert graph.placements["y"].pixels == pair.pixels
            assert graph.placements["y"].confidence == pytest.approx(pair.confidence, abs=1e-12)
            assert graph.placements["x"].to_reference == Similarity()
            assert graph.bridges == (("x", "y"),)
        else:
            assert pair.reason in graph.left_out["x"]


@given(log_odds=st.floats(-6, 8), seed=st.integers(0, 5))
@settings(max_examples=15)
def test_of_two_maps_any_method_keeps_its_verdict(log_odds, seed):
    made = fleet(seed, home=2, other=0, side=200)
    method = Oracle(made, log_odds=log_odds)

    graph = align_many(made.maps, method=method, seed=seed)

    pair = rm.align(*made.maps.values(), method=method, seed=seed)
    assert bool(graph) == bool(pair)
    if pair:
        assert graph.placements["home1"].to_reference == pair.b_to_a


@pytest.mark.parametrize("seed", range(2))
def test_the_order_of_the_maps_changes_nothing(seed):
    made = fleet(seed, home=6, other=2)
    method = Oracle(made, noise=0.0)
    graph = align_many(made.maps, method=method)

    for order in (sorted(made.maps, reverse=True), ["home3", *[name for name in made.maps if name != "home3"]]):
        again = align_many({name: made.maps[name] for name in order}, method=method)

        assert members(again) == members(graph)
        for names in graph.components:
            for a, b in itertools.pairwise(names):
                there, here = (one.placements[a].pixels.inverse() @ one.placements[b].pixels for one in (again, graph))
                assert there.matrix == pytest.approx(here.matrix, abs=1e-6)


def test_pairs_of_which_none_is_sure_join_where_all_together_are():
    made = fleet(4, home=4, other=2, side=180)

    graph = align_many(made.maps, method=Oracle(made, log_odds=-0.5))  # of which the verdict makes 1.6, no rival near

    assert all(not answer.alignment for answer in graph.pairs.asked.values())
    assert members(graph) == {frozenset(f"home{k}" for k in range(4))}
    assert worst_error(made, graph) < 0.01
    assert min(placement.confidence for placement in graph.placements.values()) > 0.8


def test_copies_of_a_map_with_a_plausible_alias_belong_together():
    graph = align_many([drawing.building()] * 3)

    assert graph
    for placement in graph.placements.values():
        assert placement.pixels.matrix == pytest.approx(Similarity().matrix, abs=0.05)
        assert placement.confidence > 0.95


def test_placements_keep_the_scale_of_every_map():
    made = fleet(4, home=12, other=0)

    graph = align_many(made.maps, method=Oracle(made, noise=0.004))

    reference = graph.components[0][0]
    ratios = [graph.placements[name].pixels.scale / made.b_to_a(reference, name).scale for name in graph.components[0]]
    assert len(ratios) == 12
    assert np.abs(np.log(ratios)).max() < 0.012


def test_placements_are_in_the_map_frame_of_the_first_map_given():
    made = fleet(5, home=3, other=0, side=180)
    made.maps = {
        name: OccupancyGrid(grid.occupancy, 0.05 * made.poses[name].scale, (k - 1.0, 2.0, 0.3 * k))
        for k, (name, grid) in enumerate(made.maps.items())
    }

    graph = align_many(made.maps, method=Oracle(made, noise=0.0))

    for name in made.maps:
        truth = pixels_to_map_frame(made.b_to_a("home0", name), made.maps["home0"], made.maps[name])
        assert graph.placements[name].reference == "home0"
        assert graph.placements[name].to_reference.matrix == pytest.approx(truth.matrix, abs=1e-6)
        assert graph.placements[name].unit == "m"


def test_each_map_is_compared_with_few_others():
    made = fleet(6, home=14, other=6)
    method = Oracle(made)

    graph = align_many(made.maps, method=method)

    assert len(method.asked) == graph.asked <= 5 * 20
    assert len(set(method.asked)) == len(method.asked)
    assert any(answer.status == "not asked" for answer in graph.pairs.values())


def test_a_spent_budget_is_named_where_a_map_is_left_out():
    made = fleet(1, home=5, other=1)
    method = Oracle(made)

    graph = align_many(made.maps, method=method, budget=3)

    assert len(method.asked) == 3
    assert all("were asked: allow more" in reason for reason in graph.left_out.values())


def test_maps_that_cannot_be_used_are_left_out_with_their_fault():
    made = fleet(1, home=3, other=0)
    empty = OccupancyGrid(np.full((5, 5), UNKNOWN, np.int8))

    graph = align_many({"empty": empty, **made.maps}, method=Oracle(made))

    assert graph.left_out == {"empty": "all cells are unknown"}
    assert len(graph.components[0]) == 3
    alone = align_many([empty, made.maps["home0"]], method=Oracle(made))
    assert alone.left_out == {"0": "all cells are unknown", "1": "no other map can be used"}


def test_bad_input_is_named():
    made = fleet(1, home=2, other=0)
    with pytest.raises(InputError, match="two maps or more, got 1"):
        align_many([made.maps["home0"]])
    wrong = OccupancyGrid(made.maps["home1"].occupancy, 0.05, (1e15, 0, 0))
    with pytest.raises(InputError, match=r"^0 and 1: map B: its origin"):
        align_many([made.maps["home0"], wrong])
    with pytest.raises(InputError, match="budget must be"):
        align_many(made.maps, budget=0)


def test_the_graph_is_plain_data_for_json():
    made = fleet(1, home=3, other=1)

    told = json.loads(json.dumps(align_many(made.maps, method=Oracle(made)).as_dict()))

    assert told["schema"] == "rectmerge.fleet/1"
    assert told["components"] == [["home0", "home1", "home2"]]
    assert told["all_in_one"] is False
    assert {pair["status"] for pair in told["pairs"]} <= {"used", "promoted", "unrelated"}


def test_of_two_maps_an_accepted_answer_of_no_confidence_is_taken_as_it_is():
    made = fleet(1, home=2, other=0, side=200)

    class Sure(Oracle):
        def _answer(self, a, b, told):
            answer = super()._answer(a, b, told)
            return dataclasses.replace(answer, verdict="accepted", confidence=0.0)

    assert align_many(made.maps, method=Sure(made, log_odds=-20.0)).placements["home1"].confidence == 0.0
