import numpy as np

from rectmerge.fleet.many import align_many
from rectmerge.similarity import Similarity
from tests.rectmerge.fleet.fleets import Oracle, fleet, members, plan, window, worst_error


def test_a_cycle_settles_an_ambiguous_pair():
    made = fleet(3, home=3, other=0, side=180)
    pairs = frozenset({("home0", "home2")})

    graph = align_many(made.maps, method=Oracle(made, doubts=pairs))

    answer = graph.pairs["home0", "home2"]
    assert graph
    assert (answer.status, answer.candidate) == ("promoted", 2)
    assert "candidate 2 agrees with the other pairs" in answer.reason
    assert worst_error(made, graph) < 0.01


def test_a_sure_but_wrong_pair_is_thrown_out_by_the_others():
    for seed in range(5):
        made = fleet(seed, home=5, other=0, side=160)
        wrong = made.b_to_a("home1", "home2")
        lies = {("home1", "home2"): Similarity(wrong.scale, wrong.angle + 0.8, wrong.tx + 40, wrong.ty)}

        graph = align_many(made.maps, method=Oracle(made, lies=lies))

        assert graph.pairs["home1", "home2"].status == "thrown out"
        assert "the other pairs place the maps elsewhere" in graph.pairs["home1", "home2"].reason
        assert graph
        assert worst_error(made, graph) < 0.01


def test_a_wrong_join_that_was_the_surest_is_undone_by_the_others():
    for seed in range(5):
        made = fleet(seed, home=5, other=0, side=160)
        wrong = made.b_to_a("home1", "home2")
        lies = {("home1", "home2"): Similarity(wrong.scale, wrong.angle + 0.8, wrong.tx + 40, wrong.ty)}

        graph = align_many(made.maps, method=Oracle(made, log_odds=4.0, lies=lies))

        assert graph
        assert graph.pairs["home1", "home2"].status == "thrown out"
        assert worst_error(made, graph) < 0.01


def test_a_sure_but_wrong_pair_joins_no_map_of_another_building():
    for seed in range(5):
        made = fleet(seed, home=5, other=1, side=160)
        made.maps = {name: made.maps[name] for name in sorted(made.maps, reverse=True)}

        graph = align_many(made.maps, method=Oracle(made, lies={("home2", "other0"): Similarity(1.0, 0.3, -20, 12)}))

        assert members(graph) == {frozenset(f"home{k}" for k in range(5))}
        assert "fits home2 alone" in graph.left_out["other0"]


def test_sure_lies_of_single_pairs_do_not_outvote_the_pairs_that_agree():
    made = fleet(3, home=5, other=0, side=180)
    lies = {
        pair: Similarity(1.0, 0.6 + index, 40.0 * index, 10.0) @ made.b_to_a(*pair)
        for index, pair in enumerate([("home0", "home3"), ("home1", "home4"), ("home1", "home3")])
    }

    graph = align_many(made.maps, method=Oracle(made, lies=lies))

    assert graph
    assert {graph.pairs[pair].status for pair in lies} <= {"thrown out", "not asked"}
    assert worst_error(made, graph) < 0.01


def test_a_wrong_join_that_nothing_can_contradict_is_named_as_a_bridge():
    made = fleet(2, home=3, other=0)
    twin, pose = window(plan(4), np.random.default_rng(0), (175.0, 175.0), 130)  # the same floor of another house
    made.add("other0", "other", twin, pose)

    graph = align_many(made.maps, method=Oracle(made, lies={("home2", "other0"): made.b_to_a("home2", "other0")}))

    assert set(graph.placements) == set(made.maps)
    assert ("home2", "other0") in graph.bridges


def test_a_sure_answer_about_the_only_pair_of_a_building_joins_nothing_that_the_walls_contradict():
    for seed in range(3):
        made = fleet(seed, home=3, other=2)
        right = made.b_to_a("other0", "other1")
        lie = Similarity(right.scale, right.angle + 0.8, right.tx, right.ty)

        graph = align_many(made.maps, method=Oracle(made, lies={("other0", "other1"): lie}))

        assert members(graph) == {frozenset({"home0", "home1", "home2"})}
        assert "walls of one map on the floor of another" in graph.left_out["other0"]
