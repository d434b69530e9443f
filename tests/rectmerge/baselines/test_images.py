import numpy as np
import pytest

from rectmerge.baselines.images import middle_scale, resize, working_factors
from rectmerge.grid import OccupancyGrid


@pytest.mark.parametrize("factor", [0.3, 0.5, 1.0, 1.7])
def test_a_spot_is_where_the_similarity_says(factor):
    image = np.zeros((60, 80), np.float32)
    image[20:29, 50:59] = 1.0  # its middle is pixel (54, 24)

    resized, to_grid = resize(image, factor)

    v, u = np.indices(resized.shape)
    middle = np.array([np.average(u, weights=resized), np.average(v, weights=resized)])
    assert np.abs(to_grid.apply(middle) - [54, 24]).max() < 0.2


def test_a_thin_wall_survives_shrinking():
    image = np.zeros((90, 90), np.float32)
    image[31] = 1.0

    assert resize(image, 0.1).image.sum(axis=0).min() > 0.05


def test_no_side_becomes_longer_than_allowed_by_rounding():
    sides = [resize(np.zeros((n, 3), np.float32), 512 / n).image.shape[0] for n in range(600, 900)]

    assert set(sides) == {512}


def test_cells_become_equally_large_where_the_scale_is_known():
    a, b = (OccupancyGrid(np.zeros((n, 10), np.int8)) for n in (100, 300))

    assert middle_scale((0.5, 2.0)) == pytest.approx(1.0)
    assert working_factors(a, b, (0.25, 0.25), 1000) == pytest.approx((1.0, 0.25))
    assert working_factors(a, b, (0.5, 0.5), 75) == pytest.approx((0.5, 0.25))  # B becomes 150 cells long, then 75
