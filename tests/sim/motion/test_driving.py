from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from rectmerge.errors import SimulationError
from sim._kernels import paths
from sim.motion.driving import KEEP_OFF_M, PathPlanner, disc_mask, find_best_goal, make_drive_field, nearest_cell
from sim.world import Prism, World
from tests.sim import naive
from tests.sim.small_worlds import box_world, wall_distance

PRICES = st.sampled_from([0.3, 1.0, 2.5, 9.0, np.inf])  # cells cheaper and dearer than a bucket of the search is wide


@settings(deadline=None)
@given(arrays(float, array_shapes(min_dims=2, max_dims=2, max_side=5), elements=PRICES))
def test_cost_to_goal_is_that_of_relaxation_to_the_last_bit(price):
    price[0, 0] = 1.0

    assert np.array_equal(paths.cost_to_goal(price, 0, 0), naive.cost_to_goal(price, 0, 0))


@settings(deadline=None)
@given(
    arrays(float, (5, 6), elements=PRICES),
    arrays(np.float32, (5, 6), elements=st.sampled_from([0.0, 0.5, 2.0, 4.0])),
)
def test_the_cell_that_pays_most_is_found_without_going_everywhere(price, pay):
    price[0, 0] = 1.0
    true = naive.cost_to_goal(price, 0, 0)
    gains = np.where((pay > 0) & np.isfinite(true), true - pay, np.inf)

    costs, at = find_best_goal(price, np.array([0.05, 0.05]), pay)
    if not np.isfinite(gains).any():
        assert at is None
    else:
        first = min(zip(gains.ravel(), true.ravel(), range(true.size), strict=True))  # of equal ones the nearest
        assert at == divmod(first[2], true.shape[1])
        assert np.array_equal(costs[true <= true[at]], true[true <= true[at]])  # all that a path back may take


def test_a_path_leads_to_the_goal_and_keeps_off_the_walls():
    world = box_world()
    planner, start, goal = PathPlanner(make_drive_field(world)), np.array([1.0, 1.35]), np.array([5.2, 1.35])
    path = planner.path(start, goal)

    assert np.hypot(*(path[-1] - goal)) < 0.11
    assert wall_distance(world, path).min() > KEEP_OFF_M - 0.06
    assert planner.cost_m(start, goal) > 4.2  # the table stands in the way


def test_where_there_is_no_way_there_is_no_path():
    field = make_drive_field(box_world())
    field.is_drivable[:, 30] = False

    assert PathPlanner(field).path(np.array([1.0, 3.0]), np.array([5.0, 3.0])) is None


def test_a_way_keeps_off_what_is_blocked_and_is_none_where_all_is():
    planner, start, goal = PathPlanner(make_drive_field(box_world())), np.array([1.0, 3.0]), np.array([5.0, 3.0])
    stone = disc_mask(planner.prices.shape, np.array([3.0, 3.0]), 0.5)

    assert np.hypot(*(planner.path(start, goal) - [3.0, 3.0]).T).min() < 0.1
    assert np.hypot(*(planner.path(start, goal, stone) - [3.0, 3.0]).T).min() >= 0.5
    assert planner.path(start, goal, np.ones_like(stone)) is None


@pytest.mark.parametrize("group", ["furniture", "glass"])
@pytest.mark.parametrize(("bottom", "top", "is_met"), [(0.0, 0.1, True), (0.28, 0.5, True), (1.0, 1.5, False)])
def test_a_robot_keeps_off_all_that_it_could_touch_seen_or_not(group, bottom, top, is_met):
    box = Prism(np.array([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]), top, bottom)
    field = make_drive_field(replace(box_world(), **{group: (box,)}))

    assert field.is_drivable[15, 15] == (not is_met)


@pytest.mark.parametrize(
    ("world", "complaint"),
    [(World(size=(2.0, 2.0), walls=()), "no floor"), (box_world(0.8, 0.7), "fits nowhere in this box")],
)
def test_a_world_without_room_for_a_robot_is_refused(world, complaint):
    with pytest.raises(SimulationError, match=complaint):
        make_drive_field(world)


@given(st.floats(-1, 7), st.floats(-1, 5))
def test_the_nearest_cell_is_nearest(x, y):
    mask = make_drive_field(box_world()).is_drivable
    row, col = nearest_cell(mask, np.array([x, y]))
    away = np.hypot(np.argwhere(mask)[:, 1] * 0.1 + 0.05 - x, np.argwhere(mask)[:, 0] * 0.1 + 0.05 - y)

    assert mask[row, col]
    assert np.hypot(col * 0.1 + 0.05 - x, row * 0.1 + 0.05 - y) <= away.min() + 0.01
