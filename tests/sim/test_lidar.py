import numpy as np
import pytest

from rectmerge.errors import InputError
from sim.lidar import Lidar


def test_readings_out_of_reach_are_inf_and_readings_too_near_are_none():
    seen = Lidar(min_range_m=0.2, max_range_m=10.0).limit(np.array([0.1, 5.0, 10.5, np.inf]))

    assert np.isnan(seen[0])
    assert seen[1] == 5.0
    assert np.isinf(seen[2:]).all()


def test_noise_and_dropouts_have_the_strength_they_say():
    lidar = Lidar(sigma_m=0.01, sigma_per_m=0.005, dropout=0.02)
    seen = lidar.observe(np.full(200_000, 4.0), None, np.random.default_rng(0))

    assert np.nanstd(seen) == pytest.approx(0.03, rel=0.02)
    assert np.nanmean(seen) == pytest.approx(4.0, abs=0.001)
    assert np.isnan(seen).mean() == pytest.approx(0.02, rel=0.1)


def test_level_zero_is_an_exact_scanner():
    ranges = np.random.default_rng(1).uniform(0, 15, 1000)

    assert np.array_equal(
        Lidar().observe(ranges, None, np.random.default_rng(0), level=0.0), Lidar().limit(ranges), equal_nan=True
    )


def test_beams_are_spread_evenly_about_the_heading():
    angles = Lidar(beams=4, fov_deg=360).angles

    assert np.allclose(np.degrees(angles), [-135, -45, 45, 135])


@pytest.mark.parametrize(
    "values",
    [{"beams": 0}, {"fov_deg": 400.0}, {"min_range_m": 5.0, "max_range_m": 4.0}, {"dropout": 1.5}, {"sigma_m": -1.0}],
)
def test_a_lidar_refuses_absurd_values(values):
    with pytest.raises(InputError, match=next(iter(values)).split("_")[0]):
        Lidar(**values)
