import numpy as np
import pytest

from sim.motion.steering import PathFollower, Steering, look_ahead


@pytest.mark.parametrize(("target", "turn"), [((0.0, 1.0), 1), ((0.0, -1.0), -1), ((1.0, 0.0), 0)])
def test_steering_turns_towards_the_target(target, turn):
    speed, rate = Steering().command(np.zeros(3), np.array(target))

    assert np.sign(rate) == turn
    assert (speed > 0) == (turn == 0)


def test_look_ahead_never_goes_back():
    path = np.stack([np.arange(50) * 0.1, np.zeros(50)], axis=-1)

    aim, nearest = look_ahead(path, np.array([1.0, 0.2]), 8)
    assert nearest == 10
    assert aim[0] > 1.2
    assert look_ahead(path, np.array([0.0, 0.0]), 8)[1] == 8


def test_a_follower_knows_what_lies_ahead():
    path = np.stack([np.arange(50) * 0.1, np.zeros(50)], axis=-1)
    follower = PathFollower(path)
    follower.target(np.array([1.0, 0.1]))

    assert np.array_equal(follower.rest, path[10:])
    assert np.array_equal(follower.end, path[-1])
