import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from sim._kernels.matching import search
from sim.sensors.lidar import Lidar
from sim.slam.poses import compose_poses, relative_poses
from sim.slam.scan_matching import BLOCK, GrowingMap, scan_hits
from sim.world import World
from tests.sim import naive
from tests.sim.scan_walks import ring_world
from tests.sim.small_worlds import box_world

LIDAR = Lidar(beams=1080)
WORLD, POSE = box_world(), np.array([1.53, 2.07, 0.4])
AROUND = compose_poses(POSE, np.array([[0.0, 0.0, 0.0], [0.21, 0.13, 0.5], [-0.17, 0.2, -0.4]]))


def map_of(world: World, *poses: np.ndarray) -> GrowingMap:
    made = GrowingMap(0.047)  # no wall lies on the border between two cells
    for pose in poses:
        made.insert(pose[None], LIDAR.angles, cast(world, pose)[None], LIDAR.max_range_m)
    return made


def cast(world: World, pose: np.ndarray) -> np.ndarray:
    return naive.cast(world, pose, LIDAR.angles, LIDAR.max_range_m)


def hits(world: World, pose: np.ndarray) -> np.ndarray:
    return scan_hits(LIDAR.angles, cast(world, pose), 360)


SEEN = np.array([cast(WORLD, pose) for pose in AROUND])
TRUE_HITS = hits(WORLD, compose_poses(POSE, np.array([0.1, -0.06, 0.2])))


@settings(max_examples=40)
@given(st.integers(0, 10_000))
def test_the_search_finds_what_trying_everything_finds(seed):
    rng = np.random.default_rng(seed)
    field = np.pad((rng.random((9, 11)) ** 4).astype(np.float32), 8)
    best_near = cv2.dilate(field, np.ones((BLOCK, BLOCK), np.uint8), anchor=(0, 0))
    points, guess = rng.uniform(-5, 5, (6, 2)), rng.uniform([10, 10, -3], [17, 15, 3])
    rest = (np.linspace(-0.4, 0.4, 3), int(rng.integers(0, 5)), 0.01, 0.2)
    shift = search(field, best_near, BLOCK, points, guess, *rest)

    assert shift[3] == pytest.approx(naive.best_shift(field, points, guess, *rest))


@settings(max_examples=20)
@given(st.floats(-0.12, 0.12), st.floats(-0.12, 0.12), st.floats(-0.08, 0.08), st.floats(-3, 3), st.floats(-50, 50))
def test_a_displacement_in_a_room_is_recovered_in_any_frame(x, y, turn, yaw, away):
    frame, true = np.array([away, -3.0, yaw]), compose_poses(POSE, np.array([0.1, -0.06, 0.2]))
    made = GrowingMap(0.015)
    made.insert(compose_poses(frame, AROUND), LIDAR.angles, SEEN, LIDAR.max_range_m)
    guess = compose_poses(compose_poses(frame, true), np.array([x, y, turn]))
    error = relative_poses(compose_poses(frame, true), made.match(TRUE_HITS, guess, window_m=0.15, window_rad=0.1).pose)

    assert np.hypot(error[0], error[1]) < 0.01
    assert abs(np.degrees(error[2])) < 0.3


def test_a_scan_holds_in_a_room_and_slides_along_a_bare_corridor():
    bare, middle = ring_world(is_bare=True), np.array([6.0, 1.1, 0.0])
    near = np.abs(hits(bare, middle)[:, 0]) < 2.5  # the ends are out of sight
    corridor = map_of(bare, middle).match(hits(bare, middle)[near], middle, window_m=0.1, window_rad=0.05)
    room = map_of(WORLD, POSE).match(hits(WORLD, POSE), POSE, window_m=0.1, window_rad=0.05)

    assert corridor.conditioning < 0.05
    assert room.conditioning > 0.3


def test_trust_keeps_a_scan_near_the_guess_where_the_map_says_nothing():
    bare, middle = ring_world(is_bare=True), np.array([6.0, 1.1, 0.0])
    points = hits(bare, middle)
    points = points[np.abs(points[:, 0]) < 2.5]
    guess = middle + np.array([0.07, 0.03, 0.0])
    match = map_of(bare, middle).match(points, guess, window_m=0.15, window_rad=0.05, prior_weights=(5.0, 4.0))

    assert match.pose[0] == pytest.approx(guess[0], abs=0.02)
    assert match.pose[1] == pytest.approx(middle[1], abs=0.025)  # half a cell


def test_off_the_map_the_guess_stays_and_the_score_is_nothing():
    guess = np.array([500.0, 500.0, 1.0])
    match = map_of(WORLD, POSE).match(hits(WORLD, POSE), guess, window_m=0.1, window_rad=0.05, prior_weights=(1.0, 1.0))

    assert np.allclose(match.pose, guess, atol=1e-6)
    assert match.score == 0.0


def test_a_map_that_grows_keeps_what_it_knew():
    far = np.array([60.0, -40.0, 0.0])
    made = map_of(WORLD, *AROUND)
    before = made.match(hits(WORLD, POSE), POSE, window_m=0.1, window_rad=0.05)
    made.insert(far[None], LIDAR.angles, cast(WORLD, POSE)[None], LIDAR.max_range_m)
    after = made.match(hits(WORLD, POSE), POSE, window_m=0.1, window_rad=0.05)

    assert np.allclose(after.pose, before.pose, atol=1e-6)
    assert after.score == pytest.approx(before.score)


def test_hits_are_spread_over_the_readings_and_no_more_than_wanted():
    lidar, ranges = Lidar(beams=180), np.full(180, 2.0)
    ranges[:20], ranges[20:30] = np.nan, np.inf
    points = scan_hits(lidar.angles, ranges, 60)

    assert 40 <= len(points) <= 60
    assert np.allclose(np.hypot(*points.T), 2.0)
    assert np.ptp(np.unwrap(np.arctan2(points[:, 1], points[:, 0]))) > math.radians(290)


@pytest.mark.parametrize("resolution_m", [0.0, -1.0, np.nan])
def test_a_map_refuses_a_resolution_that_is_none(resolution_m):
    with pytest.raises(InputError, match="resolution_m"):
        GrowingMap(resolution_m)


def test_a_map_that_would_be_absurdly_large_is_refused():
    made = GrowingMap(0.01)

    with pytest.raises(InputError, match="too large"):
        made.insert(np.array([[0.0, 0.0, 0.0], [5e3, 5e3, 0.0]]), np.zeros(1), np.ones((2, 1)), 10.0)
