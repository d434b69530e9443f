"""The compiled steps of fitting, `rectmerge._kernels.fitting`."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge._kernels.fitting import inverse, slopes, solve, stepped
from rectmerge._kernels.placements import invert
from rectmerge.similarity import Similarity
from tests.rectmerge.robust import naive
from tests.rectmerge.robust.plans import as_placement

NUMBERS = st.floats(-50, 50)
TURNS = st.floats(-math.pi, math.pi)
SCALES = st.floats(0.4, 2.5)


@given(
    st.lists(st.lists(NUMBERS, min_size=4, max_size=4), min_size=4, max_size=4),
    st.lists(NUMBERS, min_size=4, max_size=4),
)
def test_elimination_solves_what_numpy_solves(rows, right):
    matrix = np.array(rows)
    if np.linalg.cond(matrix) > 1e8:
        return

    np.testing.assert_allclose(matrix @ solve(matrix, np.array(right)), right, atol=1e-5)
    assert np.isfinite(solve(np.zeros((4, 4)), np.array(right))).all()  # singular: numbers, not an error


@given(SCALES, TURNS, NUMBERS, NUMBERS, NUMBERS, NUMBERS)
def test_an_inverse_takes_points_back(scale, turn, tx, ty, x, y):
    placement = as_placement(Similarity(scale, turn, tx, ty))
    back = np.array(inverse(tuple(placement.tolist())))

    there = naive.move(placement, np.array([[x, y]]))

    assert naive.move(back, there)[0] == pytest.approx((x, y), abs=1e-9)
    assert back == pytest.approx(invert(placement[None])[0])


@pytest.mark.parametrize("backward", [False, True])
@given(SCALES, TURNS, NUMBERS, NUMBERS, NUMBERS, NUMBERS, TURNS)
def test_slopes_are_the_numerical_derivatives(backward, scale, turn, tx, ty, x, y, facing):
    placement = as_placement(Similarity(scale, turn, tx, ty))
    gx, gy = math.cos(facing), math.sin(facing)

    def way(step: np.ndarray) -> tuple[float, float, float, float]:
        there = stepped(tuple(placement.tolist()), -step, 1.0, (1e-9, 1e9))
        return inverse(there) if backward else there

    def residual(step: np.ndarray) -> float:
        return float(naive.move(np.array(way(step)), np.array([[x, y]]))[0] @ [gx, gy])

    here = way(np.zeros(4))
    derivatives = slopes(here, *naive.move(np.array(here), np.array([[x, y]]))[0], gx, gy, backward)

    steps = 1e-5 * np.eye(4)
    wanted = [(residual(step) - residual(-step)) / 2e-5 for step in steps]
    np.testing.assert_allclose(derivatives, wanted, atol=1e-4)


@given(st.lists(st.floats(-9, 9), min_size=4, max_size=4), st.floats(0.1, 5))
def test_a_step_keeps_to_its_limits(step, longest):
    a, b, tx, ty = stepped((1.0, 0.0, 3.0, 4.0), np.array(step), longest, (0.95, 1.02))

    assert 0.95 - 1e-9 <= math.hypot(a, b) <= 1.02 + 1e-9
    assert abs(math.atan2(b, a)) <= 0.1 + 1e-9
    assert max(abs(tx - 3), abs(ty - 4)) <= longest + 1e-9
