import numpy as np
from hypothesis import given
from hypothesis.extra.numpy import array_shapes, arrays

from rectmerge.paper.largest import find_mer
from tests.rectmerge.paper import naive


@given(arrays(bool, array_shapes(min_dims=2, max_dims=2, max_side=7)))
def test_find_mer_agrees_with_brute_force(free):
    rectangle = find_mer(free)

    assert naive.largest_area(free) == (rectangle.area if rectangle else 0)


def test_find_mer_of_a_room_is_the_room():
    free = np.zeros((20, 30), bool)
    free[3:14, 5:27] = True
    rectangle = find_mer(free)

    assert rectangle is not None
    assert (rectangle.x, rectangle.y, rectangle.w, rectangle.h) == (5, 3, 22, 11)
