import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from sim.sensors.lidar import LIDARS, Lidar, find_lidar


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


def test_the_same_seed_gives_the_same_bytes():
    ranges = np.random.default_rng(1).uniform(0, 15, (50, 360))
    first, second = (LIDARS["rplidar-a1"].observe(ranges, ranges - 0.1, np.random.default_rng(5)) for _ in range(2))

    assert first.tobytes() == second.tobytes()


@pytest.mark.parametrize("jump", [0.2, 2.0])
def test_only_beams_beside_a_jump_mix_two_surfaces(jump):
    lidar = Lidar(mixed_pixels=0.5, sigma_m=0.0, sigma_per_m=0.0, dropout=0.0)
    ranges = np.tile(np.repeat([3.0, 3.0 + jump], 180), (500, 1))
    seen = lidar.observe(ranges, None, np.random.default_rng(0))

    is_between = (seen > 3.0) & (seen < 3.0 + jump)
    beside = [0, 179, 180, 359]  # beam 359 is beside beam 0
    assert not np.delete(is_between, beside, axis=1).any()
    assert is_between[:, beside].mean() == pytest.approx(0.5 if jump > 0.3 else 0.0, abs=0.03)


def test_beside_nothing_no_range_lies_between():
    ranges = np.repeat([3.0, np.inf, 12.5, 3.0], 90)
    seen = Lidar(mixed_pixels=1.0, sigma_m=0.0, sigma_per_m=0.0, dropout=0.0).observe(
        ranges, None, np.random.default_rng(0)
    )

    assert set(seen.tolist()) == {3.0, np.inf}


def test_the_last_beam_is_beside_the_first_only_if_the_scanner_looks_all_round():
    ranges = np.repeat([3.0, 5.0], 5)
    around, ahead = (
        Lidar(beams=10, fov_deg=fov, mixed_pixels=1.0, sigma_m=0.0, sigma_per_m=0.0, dropout=0.0) for fov in (360, 270)
    )

    assert 3.0 < around.observe(ranges, None, np.random.default_rng(0))[0] < 5.0
    assert ahead.observe(ranges, None, np.random.default_rng(0))[0] == 3.0


@settings(max_examples=30, deadline=None)
@given(st.floats(-1.5, 1.5), st.floats(0.5, 4.0), st.integers(300, 900))
def test_a_pane_is_seen_about_its_normal_only(normal, away, beams):
    lidar = Lidar(beams=beams, sigma_m=0.0, sigma_per_m=0.0, dropout=0.0, glass_return=1.0)
    off = np.abs(np.angle(np.exp(1j * (lidar.angles - normal))))
    glass = np.where(off < 1.0, away / np.cos(off), np.inf)
    seen = lidar.observe(np.full(beams, 9.0), glass, np.random.default_rng(0))

    is_square, is_rim = off < np.radians(5.0), np.abs(off - np.radians(5.0)) < 2 * np.pi / beams
    assert np.array_equal((seen == glass)[~is_rim], is_square[~is_rim])
    assert (seen[off > np.radians(7.0)] == 9.0).all()


def test_a_pane_returns_as_often_as_it_says_and_never_to_an_exact_scanner():
    lidar = Lidar(sigma_m=0.0, sigma_per_m=0.0, dropout=0.0, glass_return=0.3)
    glass = np.tile(np.where(np.abs(lidar.angles) < 0.5, 2.0 / np.cos(lidar.angles), np.inf), (3000, 1))
    ahead = np.abs(lidar.angles) < np.radians(4.0)
    ranges = np.full(glass.shape, 6.0)

    assert (lidar.observe(ranges, glass, np.random.default_rng(0))[:, ahead] < 3.0).mean() == pytest.approx(
        0.3, abs=0.02
    )
    assert (lidar.observe(ranges, glass, np.random.default_rng(0), level=0.0) == 6.0).all()


def test_profiles_are_found_by_name():
    assert {"rplidar-a1", "rplidar-a2", "urg-04lx", "utm-30lx", "lms1xx"} <= set(LIDARS)
    assert find_lidar("utm-30lx") is LIDARS["utm-30lx"]
    with pytest.raises(InputError, match="no lidar 'utm'; there are: rplidar-a1, rplidar-a2, "):
        find_lidar("utm")


@pytest.mark.parametrize(("name", "first", "step"), [("utm-30lx", 135.0, 0.25), ("lms1xx", 135.0, 0.5)])
def test_beams_point_where_the_data_sheet_says(name, first, step):
    angles = np.degrees(LIDARS[name].angles)

    assert -angles[0] == pytest.approx(first)
    assert np.diff(angles) == pytest.approx(step)


def test_beams_are_spread_evenly_about_the_heading():
    angles = Lidar(beams=4, fov_deg=360).angles

    assert np.allclose(np.degrees(angles), [-135, -45, 45, 135])


@pytest.mark.parametrize(
    "values",
    [
        *({"beams": 0}, {"fov_deg": 400.0}, {"min_range_m": 5.0, "max_range_m": 4.0}, {"dropout": 1.5}),
        *({"sigma_m": -1.0}, {"rate_hz": 0.0}, {"mixed_pixels": 2.0}, {"glass_return": -0.1}, {"height_m": 1.0}),
    ],
)
def test_a_lidar_refuses_absurd_values(values):
    with pytest.raises(InputError, match=next(iter(values)).split("_")[0]):
        Lidar(**values)
