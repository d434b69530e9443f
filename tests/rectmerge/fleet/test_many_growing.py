import pytest

from rectmerge.fleet.many import align_many
from rectmerge.grid import UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from tests.rectmerge.fleet.fleets import Oracle, fleet, members, worst_error


def test_answers_of_an_earlier_graph_are_not_asked_again():
    made = fleet(1, home=5, other=1)
    first = {name: grid for name, grid in made.maps.items() if name != "home4"}
    earlier = align_many(first, method=Oracle(made))
    method = Oracle(made)

    graph = align_many(made.maps, method=method, earlier=earlier)

    assert members(graph) == {frozenset(f"home{k}" for k in range(5))}
    assert method.asked
    assert all("home4" in pair or pair not in earlier.pairs.asked for pair in method.asked)


def test_an_earlier_answer_about_a_map_that_has_changed_is_asked_again():
    made = fleet(1, home=3, other=0)
    earlier = align_many(made.maps, method=Oracle(made))
    occupancy = made.maps["home0"].occupancy.copy()
    occupancy[:20] = UNKNOWN
    made.maps["home0"] = OccupancyGrid(occupancy)
    method = Oracle(made)

    align_many(made.maps, method=method, earlier=earlier)

    assert {frozenset(pair) for pair in method.asked} == {
        frozenset({"home0", "home1"}), frozenset({"home0", "home2"})
    }  # fmt: skip


def test_growing_maps_keep_the_places_of_the_earlier_ones():
    made = fleet(2, home=8, other=0)
    names = list(made.maps)
    graph, asked = align_many({name: made.maps[name] for name in names[:2]}, method=Oracle(made)), set()
    for count in range(3, 9):
        method = Oracle(made, noise=0.003)
        grown = align_many({name: made.maps[name] for name in names[:count]}, method=method, earlier=graph)

        assert not asked & set(method.asked)
        assert not grown.changes
        for name in graph.placements:
            assert grown.placements[name].pixels.matrix == pytest.approx(graph.placements[name].pixels.matrix, abs=1e-9)
        asked |= set(method.asked)
        graph = grown

    assert graph
    assert worst_error(made, graph) < 0.02


def test_an_earlier_placement_that_others_contradict_is_given_up_and_named():
    made = fleet(2, home=5, other=0, side=170)
    wrong = made.b_to_a("home0", "home1")
    lies = {("home0", "home1"): Similarity(wrong.scale, wrong.angle + 0.7, wrong.tx + 60, wrong.ty)}
    method = Oracle(made, lies=lies)
    earlier = align_many({name: made.maps[name] for name in ("home0", "home1")}, method=method)
    assert earlier

    graph = align_many(made.maps, method=method, earlier=earlier)

    assert graph
    assert worst_error(made, graph) < 0.02
    assert set(graph.changes) == {"home1"}
    assert "cells of home0: the new placements are better by" in graph.changes["home1"]


def test_an_earlier_map_that_is_left_out_now_is_named():
    made = fleet(2, home=4, other=1, side=170)
    lies = {("home0", "other0"): Similarity(1.0, 0.3, -20, 12)}
    method = Oracle(made, lies=lies)
    earlier = align_many({name: made.maps[name] for name in ("home0", "other0")}, method=method)

    graph = align_many(made.maps, method=method, earlier=earlier)

    assert set(graph.placements) == {f"home{k}" for k in range(4)}
    assert graph.changes["other0"].startswith("left out now: it fits home0 alone")
