import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from rectmerge.errors import SimulationError
from sim._kernels import paths
from sim.driving import KEEP_OFF_M, Steering, drivable, look_ahead, shortest_path
from sim.world import World
from tests.sim import naive
from tests.sim.made import box_world, wall_distance


@settings(deadline=None)
@given(arrays(float, array_shapes(min_dims=2, max_dims=2, max_side=5), elements=st.sampled_from([1.0, 2.5, np.inf])))
def test_cost_to_goal_agrees_with_relaxation(price):
    price[0, 0] = 1.0

    assert np.allclose(paths.cost_to_goal(price, 0, 0), naive.cost_to_goal(price, 0, 0))


def test_a_path_leads_to_the_goal_and_keeps_off_the_walls():
    world = box_world()
    path, cost = shortest_path(drivable(world), np.array([1.0, 1.35]), np.array([5.2, 1.35]))

    assert np.hypot(*(path[-1] - [5.2, 1.35])) < 0.11
    assert wall_distance(world, path).min() > KEEP_OFF_M - 0.06
    assert cost > 4.2  # the table stands in the way


def test_no_way_is_an_error_not_a_path():
    field = drivable(box_world())
    field.is_drivable[:, 30] = False

    with pytest.raises(SimulationError, match="no way"):
        shortest_path(field, np.array([1.0, 3.0]), np.array([5.0, 3.0]))


def test_a_world_without_room_for_a_robot_is_refused():
    with pytest.raises(SimulationError, match="fits nowhere"):
        drivable(World(size=(2.0, 2.0), walls=()))


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
