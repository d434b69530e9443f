import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra.numpy import array_shapes, arrays

from rectmerge.errors import InputError
from rectmerge.rectangles import Rectangle, largest_rectangle, maximal_rectangles
from tests.rectmerge.paper import naive

MASKS = arrays(bool, array_shapes(min_dims=2, max_dims=2, max_side=8))


@given(MASKS)
def test_the_largest_rectangle_agrees_with_brute_force(free):
    rectangle = largest_rectangle(free)

    assert (rectangle.area if rectangle else 0) == naive.largest_area(free)


@given(MASKS)
def test_ties_go_to_the_smallest_x_then_bottom_then_top(free):
    rectangle = largest_rectangle(free)

    assert (rectangle and (rectangle.x, rectangle.y, rectangle.w, rectangle.h)) == naive.find_mer(free)


@given(MASKS)
def test_all_maximal_rectangles_are_listed_once(free):
    rectangles = [tuple(box) for box in maximal_rectangles(free).tolist()]

    assert len(rectangles) == len(set(rectangles))
    assert set(rectangles) == naive.maximal_rectangles(free)


@given(MASKS)
def test_turning_the_grid_turns_its_maximal_rectangles(free):
    there = {(y, x, h, w) for x, y, w, h in maximal_rectangles(free).tolist()}

    assert there == {tuple(box) for box in maximal_rectangles(np.ascontiguousarray(free.T)).tolist()}


def test_rectangles_with_a_short_side_are_left_out():
    free = np.random.default_rng(0).random((60, 70)) < 0.8
    every = maximal_rectangles(free)

    kept = maximal_rectangles(free, min_side_cells=3)

    assert 0 < len(kept) < len(every)
    assert kept.tolist() == every[every[:, 2:].min(axis=1) >= 3].tolist()


def test_more_rectangles_than_the_first_guess_are_all_returned():
    checkered = (np.indices((80, 80)).sum(axis=0) % 2).astype(bool)

    assert len(maximal_rectangles(checkered)) == 3200


def test_nothing_free_has_no_rectangle():
    assert largest_rectangle(np.zeros((3, 4), bool)) is None
    assert maximal_rectangles(np.zeros((3, 4), bool)).shape == (0, 4)


def test_the_centre_is_that_of_the_pixels_it_covers():
    assert Rectangle(4, 7, 1, 1).centre == (4.0, 7.0)


@pytest.mark.parametrize(
    "free", [np.zeros(3, bool), np.zeros((2, 2)), np.zeros((0, 3), bool), np.zeros((1, 65536), bool)]
)
def test_what_is_no_mask_is_refused(free):
    with pytest.raises(InputError, match=r"mask|cells a side"):
        largest_rectangle(free)


def test_a_side_below_one_cell_is_refused():
    with pytest.raises(InputError, match="min_side_cells"):
        maximal_rectangles(np.ones((2, 2), bool), min_side_cells=0)
