import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.analysis.dominant_angle import dominant_angle, wall_points
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from tests.rectmerge.paper import plans

PLAN = plans.floor_plan()


@settings(max_examples=15)
@given(st.floats(0, 360))
def test_a_made_turn_is_found_to_half_a_degree(degrees):
    grid, _ = plans.moved(PLAN, degrees)
    angle_deg = math.degrees(dominant_angle(grid))

    assert 0 <= angle_deg < 90
    assert abs(math.remainder(angle_deg - degrees, 90)) < 0.5


@pytest.mark.parametrize("degrees", [0, 7.5, 12, 27, 33, 45, 88])
def test_a_turn_of_some_degrees_is_found_to_a_tenth(degrees):
    grid, _ = plans.moved(PLAN, degrees)

    assert abs(math.remainder(math.degrees(dominant_angle(grid)) - degrees, 90)) < 0.1


@pytest.mark.parametrize("degrees", [0, 27, 44, 45])
def test_noise_moves_it_by_less_than_a_third_of_a_degree(degrees):
    grid = plans.damaged(plans.moved(PLAN, degrees)[0], np.random.default_rng(1), salt=0.02, flips=0.08)

    assert abs(math.remainder(math.degrees(dominant_angle(grid)) - degrees, 90)) < 0.3


def test_walls_are_occupied_cells_beside_free_ones():
    cells = np.full((5, 7), -1, np.int8)
    cells[2, 1:4] = 0
    cells[2, 4:6] = 100

    assert wall_points(OccupancyGrid(cells)).tolist() == [[4.0, 2.0]]


def test_without_occupied_cells_the_outline_of_the_free_space_counts():
    cells = np.full((5, 5), -1, np.int8)
    cells[2, 2] = 0

    assert len(wall_points(OccupancyGrid(cells))) == 4


@pytest.mark.parametrize("value", [-1, 0, 100])
def test_a_map_without_walls_is_refused(value):
    with pytest.raises(InputError, match="no wall"):
        dominant_angle(OccupancyGrid(np.full((6, 6), value, np.int8)))
