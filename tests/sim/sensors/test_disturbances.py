import math

import numpy as np
import pytest

from rectmerge.errors import InputError
from sim.sensors.disturbances import LEG_M, Disturbances

BEAMS, SCANS, SIDE = 360, 120, 8.0  # a robot that stands in the middle of a square room of 8 m
ANGLES = (np.arange(BEAMS) + 0.5) * math.tau / BEAMS - math.pi
POSES = np.zeros((SCANS, 3))
TIMES = 0.5 * np.arange(SCANS)
RANGES = np.tile(SIDE / 2 / np.maximum(np.abs(np.cos(ANGLES)), np.abs(np.sin(ANGLES))), (SCANS, 1))


def disturbed(seed=0, ranges=RANGES, **densities):
    return Disturbances(**densities).disturb(ranges, POSES, ANGLES, TIMES, np.random.default_rng(seed))


def test_nothing_is_disturbed_by_nothing():
    assert np.array_equal(disturbed(), RANGES)


def test_windows_are_places_of_the_walls_that_most_beams_pass():
    seen = disturbed(windows=0.2)

    passed = seen > RANGES
    assert (seen >= RANGES).all()
    by_beam = passed.mean(axis=0)
    assert 0.05 < (by_beam > 0).mean() < 0.4
    assert by_beam[by_beam > 0].mean() == pytest.approx(0.7, abs=0.05)


def test_people_come_before_the_walls_for_a_while():
    seen = disturbed(people_per_minute=6.0)

    met = seen < RANGES
    assert 0.0005 < met.mean() < 0.05
    assert met.any(axis=0).sum() > 10
    assert (met.mean(axis=0) < 0.5).all()  # nobody stays
    assert seen.min() >= LEG_M - 1e-9


def test_a_scan_shares_its_offset():
    off = disturbed(offset_m=0.05) - RANGES

    assert np.allclose(off, off[:, :1])
    assert off[:, 0].std() == pytest.approx(0.05, rel=0.3)


def test_beams_that_meet_nothing_still_do():
    seen = disturbed(ranges=np.full_like(RANGES, np.inf), windows=0.5, offset_m=0.1)

    assert np.isinf(seen).all()


def test_the_same_seed_disturbs_alike_and_one_cause_leaves_the_others_alone():
    densities = {"windows": 0.1, "people_per_minute": 4.0}

    assert np.array_equal(disturbed(1, **densities), disturbed(1, **densities))
    assert not np.array_equal(disturbed(1, **densities), disturbed(2, **densities))
    with_offset = disturbed(1, **densities, offset_m=0.01)
    assert np.abs(with_offset - disturbed(1, **densities)).max() < 0.05


@pytest.mark.parametrize(
    ("densities", "message"),
    [
        ({"windows": 1.5}, "windows must be a share"),
        ({"people_per_minute": -1.0}, "people_per_minute must be >= 0, got -1.0"),
        ({"offset_m": math.nan}, "offset_m must be >= 0, got nan"),
    ],
)
def test_densities_out_of_range_are_refused(densities, message):
    with pytest.raises(InputError, match=message):
        Disturbances(**densities)
