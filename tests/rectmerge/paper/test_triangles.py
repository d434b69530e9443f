import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.paper.merging import Paper
from rectmerge.paper.triangles import corresponding, shared_triangles
from tests.rectmerge.paper import naive

ONES = (1.0, 1.0, 1.0, 1.0, 1.0)


def some_boxes(rng, count):
    boxes = np.concatenate([rng.integers(0, 90, (count, 2)), rng.integers(2, 9, (count, 2))], axis=1)
    return boxes[np.argsort(-boxes[:, 2] * boxes[:, 3], kind="stable")].astype(np.int32)


def best(first, second, **limits):
    """Return the best set of shared triangles, or None."""
    return next(iter(shared_triangles(first, second, **limits)), None)


@pytest.mark.parametrize(("min_area_cells", "count"), [(1, 790_244), (10, 364)])
def test_the_papers_counts_of_triangles_are_those_of_its_rectangles(min_area_cells, count):
    rng = np.random.default_rng(0)
    sides = np.where(np.arange(169)[:, None] < 14, [5, 4], [3, 3])  # 14 of 169 have ten cells or more
    boxes = np.concatenate([rng.integers(0, 300, (169, 2)), sides], axis=1).astype(np.int32)
    triangles = best(boxes, boxes, delta_cells=0, min_area_cells=min_area_cells, max_rectangles=169)

    assert triangles is not None
    assert triangles.combinations == count


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from([1.0, 3.0]))
def test_the_least_cost_agrees_with_comparing_all(seed, is_swapped, delta):
    rng = np.random.default_rng(seed)
    first, second = some_boxes(rng, 7), some_boxes(rng, 7)
    alike = corresponding(first, second, delta_cells=delta, swap_sides=is_swapped)
    wanted = min(naive.triangle_costs(first, second, alike, ONES), default=None)

    triangles = best(first, second, delta_cells=delta, min_area_cells=1, swap_sides=is_swapped)

    assert (triangles is None) == (wanted is None)
    assert triangles is None or triangles.cost == pytest.approx(wanted, abs=1e-6)


@pytest.mark.slow
@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1))
def test_more_sets_are_the_next_best_ones(seed):
    rng = np.random.default_rng(seed)
    first, second = some_boxes(rng, 7), some_boxes(rng, 7)
    sets = shared_triangles(first, second, delta_cells=3, min_area_cells=1, keep=10_000)
    alike = corresponding(first, second, delta_cells=3)
    wanted = naive.triangle_costs(first, second, alike, ONES)

    assert [triangles.cost for triangles in sets] == pytest.approx(sorted(wanted), abs=1e-6)
    assert sets[:5] == shared_triangles(first, second, delta_cells=3, min_area_cells=1, keep=5)


@pytest.mark.parametrize(("width_1", "width_2", "ratio"), [(33, 32, 1.0313), (38, 33, 1.1515), (8, 7, 1.1429)])
def test_the_ratios_that_the_paper_prints_are_of_sides_that_correspond(width_1, width_2, ratio):
    first, second = np.array([[0, 0, width_1, 20]], np.int32), np.array([[0, 0, width_2, 20]], np.int32)

    assert width_1 / width_2 == pytest.approx(ratio, abs=5.1e-5)  # 33/32 lies between two roundings
    assert corresponding(first, second, delta_cells=Paper().delta_cells).all()


def test_the_rectangles_that_section_iv_names_may_make_triangles():
    assert Paper().max_rectangles >= 20
    assert round(38 / 32, 4) == round(38 / 33 * 33 / 32, 4) == 1.1875


def test_no_smaller_quotient_prints_the_ratio_of_the_second_iteration():
    printed = [(w, v) for v in range(1, 33) for w in range(v, 2 * v) if round(w / v, 4) == 1.1515]

    assert printed == []


def test_sides_within_a_share_correspond_at_any_size():
    first, second = np.array([[0, 0, 130, 65]], np.int32), np.array([[0, 0, 100, 50]], np.int32)

    assert not corresponding(first, second, delta_cells=14).any()
    assert corresponding(first, second, delta_cells=14, side_share=0.25).all()


@given(st.integers(0, 2**32 - 1))
def test_both_triangles_are_in_the_order_of_size(seed):
    rng = np.random.default_rng(seed)
    triangles = best(some_boxes(rng, 9), some_boxes(rng, 9), delta_cells=6, min_area_cells=1)
    assume(triangles is not None)

    assert triangles.first == tuple(sorted(triangles.first))
    assert triangles.second == tuple(sorted(triangles.second))


def test_weights_decide_between_triangles():
    boxes = np.array([[0, 0, 9, 9], [40, 0, 8, 8], [0, 30, 7, 7], [60, 60, 6, 6]], np.int32)
    moved = boxes + np.array([[0, 0, 0, 0], [0, 0, 0, 0], [0, 9, 0, 0], [0, 0, 1, 0]], np.int32)

    areas, angles = (best(boxes, moved, min_area_cells=1, weights=w) for w in ((1, 1, 1, 0, 0), (0, 0, 0, 1, 1)))

    assert areas != angles


@given(st.integers(0, 2**32 - 1))
def test_the_cost_told_is_that_of_the_triangles_told(seed):
    rng = np.random.default_rng(seed)
    first, second = some_boxes(rng, 9), some_boxes(rng, 9)
    triangles = best(first, second, min_area_cells=1)
    assume(triangles is not None)
    features_a = naive.triangle_features(first[np.array(triangles.first) - 1])
    features_b = naive.triangle_features(second[np.array(triangles.second) - 1])

    assert triangles.first == tuple(sorted(triangles.first))
    assert triangles.cost == pytest.approx(float(((features_a - features_b) ** 2).sum()), abs=1e-6)


def test_a_map_shares_its_triangles_with_itself_at_no_cost():
    boxes = some_boxes(np.random.default_rng(3), 12)
    triangles = best(boxes, boxes + np.array([5, 7, 0, 0], np.int32))

    assert triangles is not None
    assert triangles.cost == pytest.approx(0, abs=1e-9)


def test_small_rectangles_take_no_part():
    boxes = some_boxes(np.random.default_rng(3), 12)
    large = (boxes[:, 2] * boxes[:, 3] >= 25).sum()
    triangles = best(boxes, boxes, min_area_cells=25)

    assert triangles is not None
    assert max(triangles.first + triangles.second) <= large


def test_a_limit_that_cut_the_list_is_told():
    boxes = some_boxes(np.random.default_rng(3), 12)

    cut, whole = (best(boxes, boxes, max_rectangles=most, min_area_cells=1) for most in (6, 12))

    assert cut is not None
    assert whole is not None
    assert (cut.is_cut, whole.is_cut) == (True, False)


def test_nothing_is_shared_where_no_sides_fit():
    boxes = some_boxes(np.random.default_rng(3), 12)
    assert best(boxes, boxes * np.array([1, 1, 9, 9], np.int32)) is None


def test_centres_on_one_line_make_no_triangle():
    boxes = np.array([[0, 0, 5, 5], [10, 10, 5, 5], [20, 20, 5, 5]], np.int32)
    assert best(boxes, boxes) is None


def test_swapped_sides_correspond_only_when_asked():
    first, second = np.array([[0, 0, 20, 5]], np.int32), np.array([[0, 0, 5, 20]], np.int32)

    assert not corresponding(first, second, delta_cells=3).any()
    assert corresponding(first, second, delta_cells=3, swap_sides=True).all()


@pytest.mark.parametrize("limits", [{"delta_cells": -1}, {"max_rectangles": -1}, {"weights": (1, 1, 1, 1, -1)}])
def test_a_negative_limit_is_refused(limits):
    boxes = some_boxes(np.random.default_rng(3), 4)
    with pytest.raises(InputError, match=">= 0"):
        best(boxes, boxes, **limits)
