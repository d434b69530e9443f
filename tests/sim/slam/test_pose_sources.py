import hashlib
import subprocess
import sys

import numpy as np
import pytest

from rectmerge.errors import InputError
from sim.slam.odometry import simulate_odometry
from sim.slam.pose_sources import Slam, estimate_poses
from sim.slam.poses import relative_poses
from tests.marking import some_slow
from tests.sim.scan_walks import LIDAR, ring_walk, room_walk

HASH = """
import hashlib
from tests.sim.slam.test_pose_sources import estimated
print(hashlib.sha256(estimated(loop_closure=True, walk="ring").tobytes()).hexdigest())
"""


def estimated(source: str = "slam", *, seed: int = 0, walk: str = "room", **kwargs: object) -> np.ndarray:
    poses, ranges = ring_walk() if walk == "ring" else room_walk()
    values = {
        "poses": poses,
        "angles": LIDAR.angles,
        "ranges": LIDAR.observe(ranges, None, np.random.default_rng(seed)),
        "max_range_m": LIDAR.max_range_m,
        "rng": np.random.default_rng(seed),
        **kwargs,
    }
    return estimate_poses(source, **values)


def error(estimate: np.ndarray, true: np.ndarray) -> float:
    """Return the root mean square of the distances, metres."""
    return float(np.sqrt(((estimate - true)[:, :2] ** 2).sum(axis=1).mean()))


def test_the_truth_is_returned_as_it_is_and_not_shared():
    poses = room_walk()[0]
    estimate = estimated("truth")
    estimate[0] = 99.0

    assert np.array_equal(estimated("truth"), poses)


def test_odometry_is_what_the_wheels_say():
    poses = room_walk()[0]

    assert np.array_equal(estimated("odometry", seed=3), simulate_odometry(poses, np.random.default_rng(3)))


@pytest.mark.parametrize("loop_closure", [False, True])
@pytest.mark.parametrize("walk", some_slow(["room", "ring"], "room"))
def test_slam_starts_at_the_truth_and_stays_near_where_wheels_do_not(walk, loop_closure):
    poses = (ring_walk() if walk == "ring" else room_walk())[0]
    wheels, slam = [], []
    for seed in range(3):
        same = {"seed": seed, "walk": walk, "slam": Slam(wheel_level=2.0)}
        wheels.append(error(estimated("odometry", **same), poses))
        estimate = estimated(**same, loop_closure=loop_closure)
        slam.append(error(estimate, poses))
        assert np.allclose(relative_poses(poses[0], estimate[0]), 0.0, atol=1e-9)

    assert np.mean(slam) < 0.25 * np.mean(wheels)
    assert max(slam) < (0.04 if walk == "room" else 0.3)


def test_what_moves_and_what_is_lost_is_survived():
    poses, ranges = room_walk()
    rng = np.random.default_rng(1)
    seen = LIDAR.observe(ranges, None, rng, level=2.0)
    for k in range(len(seen)):  # somebody walks by, and one beam in ten ends in the air
        seen[k, (3 * k) % 160 : (3 * k) % 160 + 20] = 0.9
    seen = np.where(rng.random(seen.shape) < 0.1, seen * rng.uniform(0.5, 1.0, seen.shape), seen)
    seen[10:13] = np.nan

    assert error(estimated(ranges=seen), poses) < 0.06


@pytest.mark.parametrize("nothing", [np.nan, np.inf])
def test_without_readings_the_mapper_believes_its_wheels(nothing):
    blind = estimated("odometry")
    estimate = estimated(ranges=np.full_like(room_walk()[1], nothing), loop_closure=True)

    assert np.allclose(relative_poses(blind, estimate), 0.0, atol=1e-6)


def test_a_robot_that_stands_still_stays_where_it_is():
    poses, ranges = room_walk()
    estimate = estimated(poses=np.repeat(poses[:1], 20, axis=0), ranges=np.repeat(ranges[:1], 20, axis=0))

    assert np.allclose(relative_poses(poses[0], estimate), 0.0, atol=1e-9)


def test_the_mappers_settings_matter():
    rough = Slam(resolution_m=0.1, key_distance_m=1.0, key_turn_deg=40.0, beams=30)
    poses = room_walk()[0]

    assert error(estimated(slam=rough), poses) > error(estimated(), poses)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bytes_in_any_process():
    done = subprocess.run([sys.executable, "-c", HASH], capture_output=True, text=True, check=True)

    assert done.stdout.strip() == hashlib.sha256(estimated(loop_closure=True, walk="ring").tobytes()).hexdigest()


@pytest.mark.parametrize(
    ("source", "values", "complaint"),
    [
        ("gps", {}, "source must be one of truth, odometry, slam, got 'gps'"),
        ("slam", {"angles": LIDAR.angles[:9]}, "disagree"),
        ("slam", {"poses": np.zeros((3, 2))}, "disagree"),
        ("slam", {"poses": np.zeros((0, 3)), "ranges": np.zeros((0, 180))}, "disagree"),
        ("truth", {"poses": np.full((1, 3), np.nan), "ranges": np.ones((1, 180))}, "finite"),
        ("slam", {"max_range_m": 0.0}, "max_range_m"),
    ],
)
def test_estimate_poses_says_what_is_wrong(source, values, complaint):
    with pytest.raises(InputError, match=complaint):
        estimated(source, **values)


@pytest.mark.parametrize(
    "values",
    [{"resolution_m": 0.0}, {"key_distance_m": -1.0}, {"beams": 3}, {"window_deg": 90.0}, {"fewest_share": np.nan}],
)
def test_slam_names_the_value_it_refuses(values):
    with pytest.raises(InputError, match=next(iter(values))):
        Slam(**values)
