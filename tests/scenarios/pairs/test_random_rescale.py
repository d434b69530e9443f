import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from scenarios.pairs.random_rescale import FACTORS, RescaledSource, rescale_pair, turn_and_rescale
from scenarios.pairs.truth import control_point_rmse
from tests.scenarios.known_answers import Source, pair

turns, factors = st.floats(-180, 180), st.floats(*FACTORS)


@given(turns, factors, st.integers(0, 99))
@example(30.0, 1.5, 0)
def test_every_pixel_of_the_new_image_is_the_old_one_that_the_similarity_names(turn_deg, factor, seed):
    old = np.random.default_rng(seed).choice(np.array([0, 100], np.int8), (17, 23))

    grid, pixels = turn_and_rescale(OccupancyGrid(old), turn_deg, factor)

    for v, u in np.argwhere(~grid.unknown)[::13]:
        at = pixels.inverse().apply([u, v])
        if np.abs(at % 1 - 0.5).min() < 1e-9:
            continue  # as near to one cell as to the next
        col, row = np.floor(at + 0.5).astype(int)
        assert grid.occupancy[v, u] == old[row, col]
    assert math.isclose(pixels.scale, factor)
    corners = pixels.apply([[0.0, 0.0], [22.0, 0.0], [22.0, 16.0], [0.0, 16.0]])
    assert (corners > -1).all()
    assert (corners < [grid.shape[1], grid.shape[0]]).all()


def test_a_quarter_turn_at_the_same_size_is_exact():
    old = np.random.default_rng(0).choice(np.array([-1, 0, 100], np.int8), (5, 8))

    grid, _ = turn_and_rescale(OccupancyGrid(old, 0.1), 90.0, 1.0)

    assert np.array_equal(grid.occupancy, np.rot90(old))
    assert grid.resolution == 0.1


def test_larger_images_have_smaller_cells():
    assert turn_and_rescale(OccupancyGrid(np.zeros((4, 4), np.int8), 0.1), 0.0, 2.0)[0].resolution == 0.05


@given(turns, factors)
def test_the_truth_of_a_rescaled_pair_holds(turn_deg, factor):
    plain = pair()

    rescaled = rescale_pair(plain, turn_deg, factor)

    assert control_point_rmse(rescaled.pixels.matrix, rescaled.control_points) == pytest.approx(0, abs=1e-9)
    assert rescaled.pixels.scale == pytest.approx(plain.pixels.scale / factor)
    turned = math.degrees(rescaled.pixels.angle - plain.pixels.angle) - turn_deg
    assert math.remainder(turned, 360) == pytest.approx(0, abs=1e-9)


def test_a_source_rescales_each_pair_its_own_way_the_same_every_time():
    source = RescaledSource(source=Source(), seed=(3, 1), mark="turn1")

    first, second = (list(source.pairs()) for _ in range(2))

    assert source.pair_ids == ("m0-related-turn1", "m0-unrelated-turn1")
    assert tuple(rescaled_pair.pair_id for rescaled_pair in first) == source.pair_ids
    assert all(np.array_equal(a.b.occupancy, b.b.occupancy) for a, b in zip(first, second, strict=True))
    assert first[0].info["random_rescale"] != first[1].info["random_rescale"]
    assert [rescaled_pair.related for rescaled_pair in first] == [True, False]
    assert [source.is_related(rescaled_pair.pair_id) for rescaled_pair in first] == [True, False]
    assert first[1].pixels is None
    other = next(RescaledSource(source=Source(), seed=(3, 2), mark="turn2").pairs())
    assert other.info["random_rescale"] != first[0].info["random_rescale"]


def test_a_factor_that_is_not_positive_is_refused():
    with pytest.raises(InputError, match="factor"):
        turn_and_rescale(OccupancyGrid(np.zeros((4, 4), np.int8)), 0.0, 0.0)
