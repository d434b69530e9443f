import itertools
import json
import math

import numpy as np
import pytest

from rectmerge.alignment import Method
from rectmerge.errors import InputError, MethodError
from rectmerge.grid import OccupancyGrid
from rectmerge.methods import make_method
from rectmerge.paper import placed_image
from rectmerge.paper.iteration import final_quarter_turns
from rectmerge.paper.merging import Paper
from rectmerge.similarity import Similarity
from tests.rectmerge.paper import plans

PLAN = plans.floor_plan()


def place(a: OccupancyGrid, b: OccupancyGrid, scale=(0.5, 2.0), **fields):
    method: Method = Paper(**fields)
    return method.align(a, b, scale=scale, rng=np.random.default_rng(0))


def made_pair(degrees_a: float, degrees_b: float, ratio: float = 1.0):
    """Two views of the plan, and the truth from B's pixels to A's; `ratio` is the pixel scale."""
    (a, to_a), (b, to_b) = plans.moved(PLAN, degrees_a), plans.moved(PLAN, degrees_b, 1 / ratio)
    return a, b, to_a @ to_b.inverse()


@pytest.mark.parametrize("degrees", [27, 33, 0])
def test_a_map_merged_with_itself_gives_identity(degrees):
    a, _ = plans.moved(PLAN, degrees)
    alignment = place(a, a)

    assert alignment, alignment.reason
    assert plans.placement_error(alignment.pixels, Similarity(), a.shape) < 0.01


@pytest.mark.parametrize(("degrees_a", "degrees_b"), [(27, 225), (27, 207), (0, 180), (207, 27)])
def test_a_made_turn_is_recovered(degrees_a, degrees_b):
    a, b, truth = made_pair(degrees_a, degrees_b)
    alignment = place(a, b)

    assert alignment, alignment.reason
    assert plans.placement_error(alignment.pixels, truth, b.shape) < 1.5


def test_a_made_scale_is_recovered():
    a, b, truth = made_pair(27, 225, 1.1429)  # the paper's simple example
    alignment = place(a, b)

    assert alignment, alignment.reason
    assert alignment.pixels.scale == pytest.approx(truth.scale, rel=0.01)
    assert plans.placement_error(alignment.pixels, truth, b.shape) < 0.01 * math.hypot(*a.shape)


def test_swapped_inputs_give_the_inverse():
    a, b, _ = made_pair(27, 225)
    there, back = place(a, b), place(b, a)

    assert there
    assert back
    assert plans.placement_error(there.pixels @ back.pixels, Similarity(), a.shape) < 2


@pytest.mark.slow
@pytest.mark.parametrize(
    "fields",
    [
        {},
        {"inclusive_sides": True},
        {"path_depth": 2},
        {"resample_from": "previous"},
        {"angle_inside_loop": True},
        {"weights": (1.0, 1.0, 1.0, 0.1, 0.1)},
    ],
)
def test_every_switch_runs_on_noisy_maps_and_repeats_its_answer(fields):
    a, b, _ = made_pair(27, 225, 1.1875)
    rng = np.random.default_rng(5)
    a, b = plans.damaged(a, rng), plans.damaged(b, rng)

    first, second = (place(a, b, **fields).as_dict() for _ in range(2))

    assert first == second
    assert first["reason"]


def test_the_trace_has_every_match_in_plain_data():
    a, b, _ = made_pair(27, 225)
    trace = place(a, b).trace

    assert trace["ended"] is True
    turned, matched = json.loads(json.dumps(trace))["iterations"][:2]
    assert turned["iteration"] == matched["iteration"] == 1
    assert turned["lambda_a_deg"] == pytest.approx(-27, abs=0.5)
    assert turned["lambda_b_deg"] == pytest.approx(-45, abs=0.5)
    assert (turned["lambda_f_deg"], matched["lambda_f_deg"]) == (180, 0)
    assert (turned["ratio"], turned["cumulative_ratio"]) == (None, 1.0)
    assert len(matched["delta_a"]) == len(matched["delta_b"]) == 3
    assert matched["cumulative_ratio"] == matched["ratio"]
    assert matched["rectangles_a"] > 3
    assert matched["triangles_a"] <= math.comb(20, 3)
    assert (matched["has_cut_edges_a"], matched["has_cut_edges_b"]) == (False, False)


@pytest.mark.parametrize("scale", [1.0, 1.1429, 1.1875])
def test_only_a_match_without_a_turn_gives_the_ratio(scale):
    a, b, _ = made_pair(27, 225, scale)
    passes = list(Paper().passes(a, b, scale=(0.5, 2.0)))

    for step, following in itertools.pairwise(passes):
        assert step.is_rescaling == (step.match.quarter_turns == 0)
        assert step.is_rescaling == (following.iteration > step.iteration)
        assert following.images[1].pose.scale == pytest.approx(step.scale_after)


def test_the_trace_tells_where_an_edge_had_more_rectangles_than_are_looked_at():
    a, b = plans.moved(PLAN, 27)[0], PLAN
    step = place(a, b, max_edge_points=8).trace["iterations"][0]

    assert (step["has_cut_edges_a"], step["has_cut_edges_b"]) == (True, False)


ONE_ROOM = OccupancyGrid(np.pad(np.zeros((30, 40), np.int8), 3, constant_values=100))
NOTHING = OccupancyGrid(np.full((30, 40), -1, np.int8))


@pytest.mark.parametrize(("bad", "why"), [(ONE_ROOM, "three rectangles"), (NOTHING, "three rectangles")])
@pytest.mark.parametrize("name", ["A", "B"])
def test_a_map_with_too_few_rectangles_is_named(bad, why, name):
    alignment = place(*((bad, PLAN) if name == "A" else (PLAN, bad)))

    assert alignment.verdict == "rejected"
    assert f"map {name}" in alignment.reason
    assert why in alignment.reason
    assert alignment.trace == {"iterations": [], "ended": False}


def test_a_map_without_parallel_edges_is_named():
    alignment = place(PLAN, OccupancyGrid(np.where(plans.stairs(), 0, 100).astype(np.int8)))

    assert alignment.verdict == "rejected"
    assert "map B has no pair of parallel edges" in alignment.reason


def test_maps_without_a_common_triangle_are_refused():
    huge, _ = plans.moved(PLAN, 0, 4.0)
    alignment = place(PLAN, huge, min_area_cells=3000)

    assert alignment.verdict == "rejected"
    assert "no three rectangles" in alignment.reason


def test_a_scale_outside_its_bounds_is_refused_and_told():
    a, b, _ = made_pair(0, 180)
    alignment = place(a, b, scale=(1.2, 1.4))

    assert alignment.verdict == "rejected"
    assert "outside 1.2 to 1.4" in alignment.reason
    assert alignment.candidates[0].pixels.scale == pytest.approx(1, abs=0.01)
    assert alignment.trace["ended"] is True


def test_the_loop_may_start_far_below_the_bounds_of_the_scale():
    a, b, _ = made_pair(0, 180, 1.1875)
    alignment = place(a, b, scale=(2.5, 2.7))  # the loop starts at 1, below half of 2.5, and ends at 1.19

    assert alignment.trace["ended"] is True
    assert "outside 2.5 to 2.7" in alignment.reason


@pytest.mark.parametrize(("degrees", "name"), [(27, "A"), (0, "B")])
def test_a_map_that_would_grow_too_large_is_refused_before_it_is_resampled(monkeypatch, degrees, name):
    a, b, _ = made_pair(degrees, 180, 1.1875)
    monkeypatch.setattr(placed_image, "MOST_CELLS", 50_000)  # neither A turned nor B rescaled has room
    alignment = place(a, b)

    assert alignment.verdict == "rejected"
    assert f"map {name} is too large" in alignment.reason


def test_a_loop_that_does_not_end_is_refused_with_its_ratios():
    a, b, _ = made_pair(27, 225, 1.1875)
    alignment = place(a, b, max_iterations=1)

    assert alignment.verdict == "rejected"
    assert "does not end, stopped after 1 iteration:" in alignment.reason
    assert alignment.trace["ended"] is False
    assert f"{alignment.trace['iterations'][-1]['ratio']:.4f}" in alignment.reason


@pytest.mark.parametrize("quarters", range(4))
def test_the_final_rotation_is_the_quarter_turn_between_the_medians(quarters):
    triangle = np.array([[0.0, 0.0], [30.0, 4.0], [28.0, -9.0]])
    turned = Similarity(1.0, -quarters * math.pi / 2).apply(triangle)  # v points down

    assert final_quarter_turns(triangle, turned) == quarters


@pytest.mark.parametrize(
    "fields",
    [
        {"n_rectangles": 0},
        {"min_area_cells": 0},
        {"max_iterations": 0},
        {"max_rectangles": 2},
        {"tau_cells": -1.0},
        {"delta_cells": math.nan},
        {"path_depth": -1},
        {"weights": (1.0, 1.0, 1.0, 1.0, -1.0)},
        {"resample_from": "next"},
    ],
)
def test_a_field_that_cannot_be_is_refused_by_name(fields):
    with pytest.raises(InputError, match=next(iter(fields))):
        Paper(**fields)


def test_fields_are_read_from_the_command_line_as_text():
    method = make_method("paper", delta_cells="2", inclusive_sides="true", weights="1,1,1,0.5,0.5")

    assert method == Paper(delta_cells=2.0, inclusive_sides=True, weights=(1.0, 1.0, 1.0, 0.5, 0.5))
    with pytest.raises(MethodError, match="paper"):
        make_method("paper", resample_from="next")


@pytest.mark.parametrize("text", ["1,1,1,1", "a,b,c,d,e", "1"])
def test_weights_that_are_not_five_numbers_are_refused(text):
    with pytest.raises(MethodError, match="weights"):
        make_method("paper", weights=text)
