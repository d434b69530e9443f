import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.errors import InputError
from sim.slam.odometry import WheelNoise, arc_ends, recover_arcs, simulate_odometry
from sim.slam.poses import chain_poses, compose_poses, relative_poses

SILENT = {f"alpha{k}": 0.0 for k in range(1, 7)}
seeds = st.integers(0, 10_000)


def random_walk(seed: int, steps: int = 30) -> np.ndarray:
    """Make arcs forwards and backwards, turns on the spot and a little slip."""
    rng = np.random.default_rng(seed)
    moved = rng.uniform([-0.3, -0.01, -2.5], [0.3, 0.01, 2.5], (steps, 3)) * rng.integers(0, 2, (steps, 3))
    return chain_poses(rng.uniform(-5, 5, 3), moved)


def ends(poses: np.ndarray, runs: int, **kwargs: object) -> np.ndarray:
    """Return the errors of the last pose, in its own frame, of many drives."""
    return np.array(
        [
            relative_poses(poses[-1], simulate_odometry(poses, np.random.default_rng(k), **kwargs)[-1])
            for k in range(runs)
        ]
    )


@given(seeds)
def test_wheels_without_error_report_the_truth(seed):
    poses = random_walk(seed)

    for silent in (
        simulate_odometry(poses, np.random.default_rng(0), level=0.0),
        simulate_odometry(poses, np.random.default_rng(0), noise=WheelNoise(**SILENT)),
    ):
        assert np.allclose(relative_poses(poses, silent), 0.0, atol=1e-9)


@given(st.floats(-1, 1), st.floats(-3, 3))
def test_length_and_turn_of_an_arc_are_recovered(along, turn):
    poses = chain_poses(np.array([1.0, -2.0, 0.7]), arc_ends(np.array([along]), np.array([turn])))
    seen_along, seen_turn, shift = recover_arcs(poses)

    assert np.allclose([seen_along[0], seen_turn[0], *shift[0]], [along, turn, 0, 0], atol=1e-9)


@given(seeds)
def test_mirrored_motion_has_the_same_lengths_and_opposite_turns(seed):
    poses = random_walk(seed)
    along, turn, shift = recover_arcs(poses)
    other_along, other_turn, other_shift = recover_arcs(poses * [1, -1, -1])

    assert np.allclose(other_along, along)
    assert np.allclose(other_turn, -turn)
    assert np.allclose(other_shift, shift * [1, -1])


@given(seeds, st.floats(-3, 3), st.floats(-9, 9))
def test_odometry_does_not_depend_on_the_frame(seed, yaw, x):
    poses, frame = random_walk(seed), np.array([x, 1.0, yaw])
    here = simulate_odometry(poses, np.random.default_rng(seed))
    there = simulate_odometry(compose_poses(frame, poses), np.random.default_rng(seed))

    assert np.allclose(relative_poses(compose_poses(frame, here), there), 0.0, atol=1e-6)


@given(seeds)
def test_compose_undoes_between(seed):
    poses = random_walk(seed)

    assert np.allclose(
        relative_poses(poses[1:], compose_poses(poses[:-1], relative_poses(poses[:-1], poses[1:]))), 0.0, atol=1e-9
    )


def test_errors_grow_along_the_way_and_with_the_level():
    poses = chain_poses(np.zeros(3), np.tile([0.2, 0.0, 0.1], (60, 1)))
    short, long = ends(poses[:20], 200), ends(poses, 200)

    assert (long.std(axis=0) > 1.3 * short.std(axis=0)).all()
    assert (ends(poses, 200, level=2.0).std(axis=0) > 1.5 * long.std(axis=0)).all()


@pytest.mark.parametrize("steps", [25, 100])
def test_the_defaults_are_as_wrong_as_they_say_however_often_they_are_sampled(steps):
    straight = chain_poses(np.zeros(3), np.tile([10.0 / steps, 0.0, 0.0], (steps, 1)))
    turning = chain_poses(np.zeros(3), np.tile([0.0, 0.0, 2 * np.pi / steps], (steps, 1)))

    assert ends(straight, 400)[:, 0].std() == pytest.approx(0.02 * 10, rel=0.3)
    assert np.degrees(ends(straight, 400)[:, 2].std()) == pytest.approx(3.0, rel=0.3)
    assert np.degrees(ends(turning, 400)[:, 2].std()) == pytest.approx(4.0, rel=0.3)


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({"poses": np.zeros((5, 2))}, "shape"),
        ({"poses": np.zeros((0, 3))}, "shape"),
        ({"level": -1.0}, "level"),
        ({"level": np.nan}, "level"),
    ],
)
def test_drive_blind_says_what_is_wrong(values, complaint):
    with pytest.raises(InputError, match=complaint):
        simulate_odometry(**{"poses": np.zeros((5, 3)), "rng": np.random.default_rng(0), **values})


@pytest.mark.parametrize("name", SILENT)
def test_wheel_noise_names_the_value_it_refuses(name):
    with pytest.raises(InputError, match=name):
        WheelNoise(**{name: -1.0})
