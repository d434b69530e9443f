import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from rectmerge.analysis.specks import remove_specks
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from tests.rectmerge.paper import plans

CELLS = arrays(np.int8, array_shapes(min_dims=2, max_dims=2, max_side=10), elements=st.sampled_from([-1, 0, 100]))


@pytest.mark.parametrize("speck", [100, -1, 50])
def test_what_stands_alone_in_free_space_becomes_free(speck):
    cells = np.zeros((7, 7), np.int8)
    cells[3, 3] = speck

    assert (remove_specks(OccupancyGrid(cells)).occupancy == 0).all()


@pytest.mark.parametrize("around", [100, -1])
def test_a_free_cell_inside_anything_else_vanishes(around):
    cells = np.full((7, 7), around, np.int8)
    cells[3, 3] = 0

    assert (remove_specks(OccupancyGrid(cells)).occupancy == around).all()


def test_larger_patches_stay():
    cells = np.zeros((9, 9), np.int8)
    cells[4, 3:6] = 100

    assert (remove_specks(OccupancyGrid(cells)).occupancy == cells).all()
    assert (remove_specks(OccupancyGrid(cells), max_speck_cells=3).occupancy == 0).all()


def test_a_clean_plan_stays_as_it_is():
    plan = plans.floor_plan()

    assert (remove_specks(plan).occupancy == plan.occupancy).all()


def test_most_salt_goes():
    plan = plans.floor_plan()
    salted = plans.damaged(plan, np.random.default_rng(0), salt=0.02, flips=0)
    left = (remove_specks(salted).occupancy != plan.occupancy).sum() / (salted.occupancy != plan.occupancy).sum()

    assert left < 0.15


@given(CELLS)
def test_zero_changes_nothing(cells):
    assert (remove_specks(OccupancyGrid(cells), max_speck_cells=0).occupancy == cells).all()


@given(CELLS)
def test_the_frame_is_kept_and_the_input_is_not_changed(cells):
    grid = OccupancyGrid(cells, 0.05, (1.0, 2.0, 0.3))
    before = grid.occupancy.copy()
    clean = remove_specks(grid)

    assert (clean.resolution, clean.origin) == (grid.resolution, grid.origin)
    assert (grid.occupancy == before).all()


def test_a_negative_size_is_refused():
    with pytest.raises(InputError, match="max_speck_cells"):
        remove_specks(plans.floor_plan(), max_speck_cells=-1)
