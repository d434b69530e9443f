import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.paper.triangles import corresponding, shared_triangles
from tests import naive

ONES = (1.0, 1.0, 1.0, 1.0, 1.0)


def some_boxes(rng, count):
    boxes = np.concatenate([rng.integers(0, 90, (count, 2)), rng.integers(2, 9, (count, 2))], axis=1)
    return boxes[np.argsort(-boxes[:, 2] * boxes[:, 3], kind="stable")].astype(np.int32)


@pytest.mark.parametrize(("min_area_cells", "count"), [(1, 790_244), (10, 364)])
def test_the_papers_counts_of_triangles_are_those_of_its_rectangles(min_area_cells, count):
    rng = np.random.default_rng(0)
    sides = np.where(np.arange(169)[:, None] < 14, [5, 4], [3, 3])  # 14 of 169 have ten cells or more
    boxes = np.concatenate([rng.integers(0, 300, (169, 2)), sides], axis=1).astype(np.int32)
    found = shared_triangles(boxes, boxes, delta_cells=0, min_area_cells=min_area_cells, max_rectangles=169)

    assert found is not None
    assert found.combinations == count


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from([1.0, 3.0]))
def test_the_least_cost_agrees_with_comparing_all(seed, is_swapped, delta):
    rng = np.random.default_rng(seed)
    first, second = some_boxes(rng, 7), some_boxes(rng, 7)
    alike = corresponding(first, second, delta_cells=delta, swap_sides=is_swapped)
    wanted = naive.least_triangle_cost(first, second, alike, ONES)

    found = shared_triangles(first, second, delta_cells=delta, min_area_cells=1, swap_sides=is_swapped)

    assert (found is None) == (wanted is None)
    assert found is None or found.cost == pytest.approx(wanted, abs=1e-6)


@given(st.integers(0, 2**32 - 1))
def test_the_cost_told_is_that_of_the_triangles_told(seed):
    rng = np.random.default_rng(seed)
    first, second = some_boxes(rng, 9), some_boxes(rng, 9)
    found = shared_triangles(first, second, min_area_cells=1)
    assume(found is not None)
    one = naive.triangle_features(first[np.array(found.first) - 1])
    other = naive.triangle_features(second[np.array(found.second) - 1])

    assert found.first == tuple(sorted(found.first))
    assert found.cost == pytest.approx(float(((one - other) ** 2).sum()), abs=1e-6)


def test_a_map_shares_its_triangles_with_itself_at_no_cost():
    boxes = some_boxes(np.random.default_rng(3), 12)
    found = shared_triangles(boxes, boxes + np.array([5, 7, 0, 0], np.int32))

    assert found is not None
    assert found.cost == pytest.approx(0, abs=1e-9)


def test_small_rectangles_take_no_part():
    boxes = some_boxes(np.random.default_rng(3), 12)
    large = (boxes[:, 2] * boxes[:, 3] >= 25).sum()
    found = shared_triangles(boxes, boxes, min_area_cells=25)

    assert found is not None
    assert max(found.first + found.second) <= large


def test_a_limit_that_cut_the_list_is_told():
    boxes = some_boxes(np.random.default_rng(3), 12)

    cut, whole = (shared_triangles(boxes, boxes, max_rectangles=most, min_area_cells=1) for most in (6, 12))

    assert cut is not None
    assert whole is not None
    assert (cut.is_cut, whole.is_cut) == (True, False)


def test_nothing_is_shared_where_no_sides_fit():
    boxes = some_boxes(np.random.default_rng(3), 12)
    assert shared_triangles(boxes, boxes * np.array([1, 1, 9, 9], np.int32)) is None


def test_centres_on_one_line_make_no_triangle():
    boxes = np.array([[0, 0, 5, 5], [10, 10, 5, 5], [20, 20, 5, 5]], np.int32)
    assert shared_triangles(boxes, boxes) is None


def test_swapped_sides_correspond_only_when_asked():
    first, second = np.array([[0, 0, 20, 5]], np.int32), np.array([[0, 0, 5, 20]], np.int32)

    assert not corresponding(first, second, delta_cells=3).any()
    assert corresponding(first, second, delta_cells=3, swap_sides=True).all()


@pytest.mark.parametrize("limits", [{"delta_cells": -1}, {"max_rectangles": -1}, {"weights": (1, 1, 1, 1, -1)}])
def test_a_negative_limit_is_refused(limits):
    boxes = some_boxes(np.random.default_rng(3), 4)
    with pytest.raises(InputError, match=">= 0"):
        shared_triangles(boxes, boxes, **limits)
