import dataclasses

import numpy as np
import pytest

from rectmerge.errors import InputError
from rectmerge.paper.merging import Paper
from rectmerge.paper.repaired import PaperRepaired
from rectmerge.similarity import Similarity
from tests.rectmerge.paper import plans

OFF = {
    "max_speck_cells": 0,
    "orientation": "ransac",
    "side_share": 0.0,
    "swap_sides": False,
    "median_ratio": False,
    "hypotheses": 1,
    "max_rectangles": 20,
    "ratio_tolerance": 0.005,
}
PLAN = plans.floor_plan()


def made_pair(degrees_a, degrees_b, ratio=1.0):
    (a, to_a), (b, to_b) = plans.moved(PLAN, degrees_a), plans.moved(PLAN, degrees_b, 1 / ratio)
    return a, b, to_a @ to_b.inverse()


def place(a, b, method=None):
    return (method or PaperRepaired()).align(a, b, scale=(0.5, 2.0), rng=np.random.default_rng(0))


@pytest.mark.parametrize(("degrees_a", "degrees_b"), [(27, 225), (0, 180)])
def test_with_all_repairs_off_it_is_the_method_of_the_paper(degrees_a, degrees_b):
    a, b, _ = made_pair(degrees_a, degrees_b, 1.1429)
    letter, repaired = place(a, b, Paper()), place(a, b, PaperRepaired(**OFF))

    assert repaired.trace == letter.trace
    assert repaired.verdict == letter.verdict
    assert repaired.candidates[0].pixels.matrix.tolist() == letter.candidates[0].pixels.matrix.tolist()


@pytest.mark.parametrize("ratio", [1.0, 1.1429, 1.1875, 1.3])
@pytest.mark.parametrize(("degrees_a", "degrees_b"), [(27, 225), (0, 90), (27, 117), (0, 270)])
def test_turns_and_scales_are_recovered(degrees_a, degrees_b, ratio):
    a, b, truth = made_pair(degrees_a, degrees_b, ratio)
    alignment = place(a, b)

    assert alignment, alignment.reason
    assert plans.placement_error(alignment.pixels, truth, b.shape) < 0.01 * np.hypot(*a.shape)


def test_a_map_merged_with_itself_gives_identity():
    a, _ = plans.moved(PLAN, 33)
    alignment = place(a, a)

    assert alignment, alignment.reason
    assert plans.placement_error(alignment.pixels, Similarity(), a.shape) < 0.01


@pytest.mark.parametrize("seed", [5, 6, 7])
def test_specks_do_not_hide_the_rooms(seed):
    a, b, truth = made_pair(27, 225)
    rng = np.random.default_rng(seed)
    a, b = (plans.damaged(grid, rng, salt=0.005, flips=0) for grid in (a, b))
    alignment = place(a, b)

    assert alignment, alignment.reason
    assert plans.placement_error(alignment.pixels, truth, b.shape) < 0.01 * np.hypot(*a.shape)


@pytest.mark.slow
@pytest.mark.parametrize("field", OFF)
def test_every_repair_is_a_switch_that_repeats_its_answer(field):
    a, b, _ = made_pair(27, 225, 1.1875)
    rng = np.random.default_rng(5)
    a, b = plans.damaged(a, rng), plans.damaged(b, rng)
    method = dataclasses.replace(PaperRepaired(), **{field: OFF[field]})

    first, second = (place(a, b, method).as_dict() for _ in range(2))

    assert first == second
    assert first["reason"]


@pytest.mark.parametrize(
    "fields",
    [{"max_speck_cells": -1}, {"side_share": -0.1}, {"hypotheses": 0}, {"orientation": "compass"}, {"delta_cells": -1}],
)
def test_a_field_that_cannot_be_is_refused_by_name(fields):
    with pytest.raises(InputError, match=next(iter(fields))):
        PaperRepaired(**fields)
