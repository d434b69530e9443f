import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from rectmerge.errors import InputError
from rectmerge.paper.largest import find_mer
from rectmerge.paper.rmap import SIDES, rmap
from tests.rectmerge.paper import naive, plans

MASKS = arrays(bool, array_shapes(min_dims=2, max_dims=2, max_side=12))


def boxes(free, **limits):
    return [tuple(box) for box in rmap(free, **limits).boxes.tolist()]


@st.composite
def noisy_turned_plans(draw):
    """A floor plan, small enough for the literal loop, turned by any angle and damaged."""
    grid = plans.floor_plan(draw(st.integers(20, 45)), draw(st.integers(25, 50)))
    grid, _ = plans.moved(grid, draw(st.floats(0, 360)))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return plans.damaged(grid, rng, salt=draw(st.sampled_from([0, 0.01, 0.1])), flips=draw(st.sampled_from([0, 0.1])))


@given(MASKS)
def test_the_sequence_is_that_of_the_literal_loop(free):
    assert boxes(free) == naive.rmap(free)


@pytest.mark.slow
@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(0.5, 0.99), st.integers(10, 34), st.integers(10, 34))
def test_the_sequence_is_that_of_the_literal_loop_on_salt(seed, density, height, width):
    free = np.random.default_rng(seed).random((height, width)) < density

    assert boxes(free) == naive.rmap(free)


@pytest.mark.slow
@settings(max_examples=15)
@given(noisy_turned_plans())
def test_the_sequence_is_that_of_the_literal_loop_on_noisy_turned_plans(grid):
    assert boxes(grid.free) == naive.rmap(grid.free)


@given(MASKS, st.integers(1, 12), st.integers(0, 12))
def test_limits_cut_the_sequence_short_and_change_nothing_else(free, least, most):
    wanted = [box for box in naive.rmap(free) if box[2] * box[3] >= least][:most]

    assert boxes(free, min_area_cells=least, max_rectangles=most) == wanted


@given(MASKS)
def test_labels_partition_the_free_space(free):
    rectangles = rmap(free)

    assert ((rectangles.labels > 0) == free).all()
    assert np.bincount(rectangles.labels[free], minlength=len(rectangles) + 1)[1:].tolist() == rectangles.areas.tolist()
    for label, (x, y, w, h) in enumerate(rectangles.boxes.tolist(), start=1):
        assert (rectangles.labels[y : y + h, x : x + w] == label).all()


@given(MASKS, st.booleans())
def test_connections_are_the_labels_along_the_sides(free, is_inclusive):
    rectangles = rmap(free, inclusive_sides=is_inclusive)

    for label, box in enumerate(rectangles.boxes.tolist(), start=1):
        wanted = naive.side_labels(rectangles.labels, tuple(box), int(is_inclusive))
        assert [rectangles.connections(label, side).tolist() for side in SIDES] == [sorted(labels) for labels in wanted]


@given(MASKS)
def test_connections_are_mutual(free):
    rectangles = rmap(free)

    for label in range(1, len(rectangles) + 1):
        assert all(
            label in rectangles.connections(int(other), "left") for other in rectangles.connections(label, "right")
        )
        assert all(label in rectangles.connections(int(other), "up") for other in rectangles.connections(label, "down"))


@given(MASKS)
def test_the_first_rectangle_is_the_maximal_empty_one(free):
    listed = rmap(free, max_rectangles=1).rectangles

    assert (listed[0] if listed else None) == find_mer(free)


def test_the_mask_is_not_changed():
    free = np.ones((5, 6), bool)
    rmap(free)

    assert free.all()


@pytest.mark.parametrize("limits", [{"min_area_cells": 0}, {"max_rectangles": -1}])
def test_a_limit_below_its_least_value_is_refused(limits):
    with pytest.raises(InputError, match=next(iter(limits))):
        rmap(np.ones((2, 2), bool), **limits)


@pytest.mark.parametrize("label", [0, 2])
def test_a_label_that_is_not_there_is_refused(label):
    with pytest.raises(InputError, match="label"):
        rmap(np.ones((2, 2), bool)).connections(label, "up")
