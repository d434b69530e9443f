import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from sim._kernels.pose_graph import solve_profile
from sim.slam.loop_closure import KeyScans, Links, propagate_corrections, solve_graph
from sim.slam.poses import chain_poses, compose_poses, relative_poses
from tests.sim import naive
from tests.sim.scan_walks import LIDAR, ring_walk, ring_world

seeds = st.integers(0, 10_000)


def random_graph(seed: int, count: int = 12) -> tuple[np.ndarray, Links]:
    """Return the poses of a walk, and exact links along it and across."""
    rng = np.random.default_rng(seed)
    poses = chain_poses(rng.uniform(-3, 3, 3), rng.uniform([0.1, -0.1, -0.6], [0.6, 0.1, 0.6], (count - 1, 3)))
    across = rng.integers(0, count, (5, 2))
    pairs = np.concatenate([np.stack([np.arange(count - 1), np.arange(1, count)], axis=1), across])
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    motions = relative_poses(poses[pairs[:, 0]], poses[pairs[:, 1]])
    return poses, Links(pairs, motions, rng.uniform(0.01, 0.1, (len(pairs), 3)))


def drifted(poses: np.ndarray, turn_per_step: float) -> np.ndarray:
    return chain_poses(poses[0], relative_poses(poses[:-1], poses[1:]) + np.array([0.0, 0.0, turn_per_step]))


def end_errors(poses: np.ndarray, ranges: np.ndarray, estimated: np.ndarray) -> tuple[float, float]:
    """Return the distance of the last pose from the truth before and after all scans."""
    keys = KeyScans(LIDAR.angles, LIDAR.max_range_m, 0.05, 180)
    keys.add(estimated[0], ranges[0])
    for step, scan in zip(relative_poses(estimated[:-1], estimated[1:]), ranges[1:], strict=True):
        keys.add(compose_poses(keys.poses[-1], step), scan)
        keys.close_loop()
    before, after = (float(np.hypot(*(last - poses[-1])[:2])) for last in (estimated[-1], keys.poses[-1]))
    return before, after


@given(seeds)
def test_the_profile_solver_agrees_with_a_dense_one(seed):
    rng = np.random.default_rng(seed)
    half = np.tril(rng.normal(size=(9, 9))) * (rng.random((9, 9)) < 0.4) + 2 * np.eye(9)
    system, right = half @ half.T, rng.normal(size=9)
    solution = right.copy()

    assert solve_profile(system.copy(), solution)
    assert np.allclose(solution, np.linalg.solve(system, right))


@given(seeds)
def test_links_that_agree_are_satisfied_whatever_the_first_guess(seed):
    poses, links = random_graph(seed)
    guess = poses + np.random.default_rng(seed).normal(0.0, 0.1, poses.shape)
    guess[0] = poses[0]

    assert np.abs(relative_poses(poses, solve_graph(guess, links))).max() < 1e-3


@given(seeds)
def test_the_solution_is_the_best_place_nearby(seed):
    poses, links = random_graph(seed)
    rng = np.random.default_rng(seed)
    torn = Links(links.pairs, links.motions + rng.normal(0.0, 0.02, links.motions.shape), links.stds)
    solved = solve_graph(poses, torn)
    cost = (torn.residuals(solved) ** 2).sum()

    for _ in range(10):
        aside = solved + np.vstack([np.zeros(3), rng.normal(0.0, 0.02, (len(poses) - 1, 3))])
        assert (torn.residuals(aside) ** 2).sum() >= cost * (1 - 1e-6)


def test_a_ring_walked_with_biased_wheels_closes():
    poses, ranges = ring_walk()
    before, after = end_errors(poses, LIDAR.observe(ranges, None, np.random.default_rng(0)), drifted(poses, 0.001))

    assert before > 0.5
    assert after < 0.15


def test_a_bare_corridor_is_no_proof_of_having_been_there():
    poses = chain_poses(np.array([3.5, 1.1, 0.0]), np.tile([0.12, 0.0, 0.0], (40, 1)))
    ranges = np.array([naive.cast(ring_world(is_bare=True), pose, LIDAR.angles, 2.5) for pose in poses])
    keys = KeyScans(LIDAR.angles, 2.5, 0.05, 180)
    for pose, scan in zip(poses, ranges, strict=True):
        keys.add(pose * [0.3, 1.0, 1.0], scan)  # it believes that it has moved little

        assert not keys.close_loop()


def test_scans_without_a_reading_close_nothing():
    keys = KeyScans(LIDAR.angles, 12.0, 0.05, 180)
    for _ in range(40):
        keys.add(np.zeros(3), np.full(180, np.nan))

        assert not keys.close_loop()


@settings(max_examples=30)
@given(seeds)
def test_poses_in_between_are_carried_along(seed):
    rng = np.random.default_rng(seed)
    trail = chain_poses(rng.uniform(-3, 3, 3), rng.uniform([0.0, 0.0, -0.5], [0.3, 0.1, 0.5], (20, 3)))
    kept = np.array([0, 4, 5, 11, 18])
    frame = rng.uniform(-3, 3, 3)

    assert np.allclose(relative_poses(trail, propagate_corrections(trail, kept, trail[kept])), 0.0, atol=1e-9)
    moved = propagate_corrections(trail, kept, compose_poses(frame, trail[kept]))
    assert np.allclose(relative_poses(compose_poses(frame, trail), moved), 0.0, atol=1e-9)
    bent = trail[kept] + rng.normal(0.0, 0.1, (5, 3))
    assert np.allclose(relative_poses(bent, propagate_corrections(trail, kept, bent)[kept]), 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("pairs", "complaint"), [([[0, 1], [1, 7]], "links name poses"), ([[0, 1]], "a pose of the graph has no link")]
)
def test_a_graph_that_cannot_be_solved_is_refused(pairs, complaint):
    links = Links(np.array(pairs), np.ones((len(pairs), 3)), np.ones((len(pairs), 3)))

    with pytest.raises(InputError, match=complaint):
        solve_graph(np.zeros((3, 3)), links)
