import math

import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.robust.known_scale import KnownScale
from rectmerge.robust.params import Params
from tests.rectmerge.robust import plans

PARAMS = Params().scale


@pytest.mark.parametrize("bounds", [(1.2, 1.2), (1.2 / 1.02, 1.2 * 1.02)])
def test_narrow_bounds_say_that_the_scale_in_their_middle_is_known(bounds):
    known = KnownScale.within(bounds, PARAMS)

    assert known is not None
    assert known.expected == pytest.approx(1.2)


@pytest.mark.parametrize("bounds", [(0.9, 1.1), (0.5, 2.0)])
def test_wide_bounds_say_nothing(bounds):
    assert KnownScale.within(bounds, PARAMS) is None


def test_odds_fall_with_the_difference_from_the_known_scale_alike_on_both_sides():
    known = KnownScale(1.2, PARAMS)
    steps = np.array([0.0, 0.01, 0.05, -0.01, -0.05])
    turned = 1.2 * np.exp(steps)[:, None] * [math.cos(0.7), math.sin(0.7), 0.0, 0.0]

    off = known.off(turned)

    assert off == pytest.approx(steps)
    odds = known.log_odds(off)
    assert odds[0] > odds[1] > odds[2]
    assert odds[1:3] == pytest.approx(odds[3:])


def test_a_known_scale_makes_surer():
    rooms = plans.office(3)
    a = plans.see(rooms, degrees=33, window=(-8, -8, 190, 236), noise=1, seed=1)
    b = plans.see(rooms, degrees=190, scale=0.8, window=(110, -8, 316, 236), noise=1, seed=2)

    free, known = (align(a.grid, b.grid, scale=scale) for scale in ("free", plans.truth(a, b).scale))

    assert all(plans.is_right(each.candidates[0].pixels, a, b) for each in (free, known))
    assert known.candidates[0].evidence["plausibility"] > free.candidates[0].evidence["plausibility"] + 1
    assert known.confidence >= free.confidence
