import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.motion.coverage import TOLERANCE, SeenFloor, compute_cuts
from sim.sensors.lidar import Lidar
from tests.sim import naive
from tests.sim.small_worlds import office_log

LIDAR = Lidar(beams=7, max_range_m=1.2, min_range_m=0.1)


def random_floor(seed: int, scans: int) -> SeenFloor:
    rng = np.random.default_rng(seed)
    poses = rng.uniform([0, 0, -3], [1.5, 1.0, 3], (scans, 3))
    floor = SeenFloor(LIDAR, (10, 15))
    floor.add(poses, rng.choice([0.05, 0.4, 0.9, np.inf, np.nan], (scans, LIDAR.beams)))
    return floor


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000))
def test_what_is_seen_since_when_agrees_with_cutting_rays_at_the_grid_lines(seed):
    rng = np.random.default_rng(seed)
    poses = rng.uniform([0, 0, -3], [1.5, 1.0, 3], (4, 3))
    ranges = rng.choice([0.05, 0.4, 0.9, 1.3, np.inf, np.nan], (4, LIDAR.beams))
    floor = SeenFloor(LIDAR, (10, 15))
    floor.add(poses[:1], ranges[:1])
    floor.add(poses[1:], ranges[1:])
    since, is_hit = naive.first_seen(poses, LIDAR.angles, ranges, (0.1, 1.2), 0.1, (10, 15))

    assert np.array_equal(floor.since, since)
    assert np.array_equal(floor.is_hit, is_hit)
    assert floor.scans == 4


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000), st.integers(2, 6), st.integers(2, 6))
def test_every_pair_of_cuts_has_the_overlap_of_what_its_scans_show(seed, n, m):
    a, b = random_floor(seed, n), random_floor(seed + 1, m)
    cuts = compute_cuts(a, b, fewest=2)

    assert (cuts.kept_a.tolist(), cuts.kept_b.tolist()) == (list(range(2, n + 1)), list(range(2, m + 1)))
    for i, kept_a in enumerate(cuts.kept_a):
        for j, kept_b in enumerate(cuts.kept_b):
            of_a, of_b = (f.is_free & (f.since < kept) for f, kept in ((a, kept_a), (b, kept_b)))
            assert np.isclose(cuts.area_a[i], of_a.sum() * 0.01)
            assert np.isclose(cuts.area_b[j], of_b.sum() * 0.01)
            assert np.isclose(cuts.common[i, j], (of_a & of_b).sum() * 0.01)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.1, 1.0))
def test_the_choice_has_the_wanted_overlap_and_no_other_shows_more(seed, wanted):
    cuts = compute_cuts(random_floor(seed, 12), random_floor(seed + 1, 12), fewest=2)
    choice = cuts.choose(wanted, least_m2=0.1)
    fits = (np.abs(cuts.overlaps - wanted) <= TOLERANCE) & (np.minimum.outer(cuts.area_a, cuts.area_b) >= 0.1)

    assert (choice is None) == (not fits.any())
    if choice is not None:
        i, j = choice.scans_a - 2, choice.scans_b - 2
        assert fits[i, j]
        assert cuts.area_a[i] * cuts.area_b[j] == np.outer(cuts.area_a, cuts.area_b)[fits].max()


def test_a_log_that_should_stay_whole_is_cut_only_where_no_other_cut_will_do():
    log = office_log()
    floors = [SeenFloor(log.spec.a.lidar, (100, 140)) for _ in "ab"]
    for floor, robot in zip(floors, (log.a, log.b), strict=True):
        floor.add(robot.poses, robot.ranges)
    cuts = compute_cuts(*floors, fewest=3)
    among_whole = float(cuts.overlaps[-1, len(cuts.kept_b) // 2])

    choice = cuts.choose(among_whole, least_m2=1.0, whole=(True, False))
    assert choice is not None
    assert choice.scans_a == len(log.a.times)


def test_a_long_log_is_cut_at_evenly_spaced_scans():
    floor = SeenFloor(LIDAR, (10, 15))
    floor.add(np.tile([0.5, 0.5, 0.0], (5000, 1)), np.full((5000, LIDAR.beams), 0.4))
    cuts = compute_cuts(floor, floor, fewest=10)

    assert cuts.common.shape == (400, 400)
    assert (cuts.kept_a[0], cuts.kept_a[-1]) == (10, 5000)
    assert cuts.choose(1.0, least_m2=0.0) is not None


def test_the_share_of_a_floor_is_told():
    floor = SeenFloor(LIDAR, (10, 15))
    wanted = np.zeros((10, 15), dtype=np.bool_)
    wanted[5, 5:7] = True
    assert floor.share_of(wanted) == 0.0

    floor.add(np.array([[0.55, 0.55, 0.0]]), np.full((1, LIDAR.beams), 0.3))
    assert floor.share_of(wanted) == pytest.approx(1.0)
