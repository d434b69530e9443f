import numpy as np
import pytest

from rectmerge.errors import InputError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from scenarios.corruption.cells import (
    blobs,
    dilation,
    double_walls,
    erosion,
    salt,
    spurious_rays,
    wall_dropout,
    wall_edge_flips,
)
from tests.scenarios.corruption.small_map import changed, small_map


def test_salt_turns_its_share_of_the_free_cells_to_occupied_and_nothing_else():
    grid = small_map()
    salted = salt(grid, 0.01, np.random.default_rng(0))
    spots = changed(grid, salted)

    assert (grid.free & salted.occupied)[spots].all()
    assert spots.sum() / grid.free.sum() == pytest.approx(0.01, rel=0.2)


def test_flips_stay_where_free_space_and_walls_touch_and_go_both_ways():
    grid = small_map()
    flipped = wall_edge_flips(grid, 0.5, np.random.default_rng(0))
    rows, cols = np.nonzero(changed(grid, flipped))
    to_wall = np.minimum.reduce([rows - 9, cols - 9, 190 - rows, 190 - cols])  # 0: inner wall cells, 1: first free ones

    assert set(to_wall) == {0, 1}
    assert (grid.free & flipped.occupied).any()
    assert (grid.occupied & flipped.free).any()
    assert len(rows) / (4 * 180 + 4 * 178) == pytest.approx(0.5, abs=0.05)


def test_dropout_loses_its_share_of_the_wall_cells():
    grid = small_map()
    lost = changed(grid, wall_dropout(grid, 0.1, np.random.default_rng(0)))

    assert grid.occupied[lost].all()
    assert lost.sum() / grid.occupied.sum() == pytest.approx(0.1, rel=0.3)


def test_double_walls_add_walls_two_to_four_cells_aside():
    grid = small_map()
    added = changed(grid, double_walls(grid, 0.05, np.random.default_rng(0)))
    rows, cols = np.nonzero(added)
    away = np.minimum.reduce(
        [np.abs(rows - k) for k in (8, 9, 190, 191)] + [np.abs(cols - k) for k in (8, 9, 190, 191)]
    )

    assert added.any()
    assert away.max() <= 5


def test_rays_add_free_cells_and_blobs_take_some():
    grid, rng = small_map(), np.random.default_rng(3)

    assert (spurious_rays(grid, 20, rng).free & ~grid.free).any()
    assert not (grid.free & ~spurious_rays(grid, 20, rng).free).any()
    assert 8 < (grid.free & ~blobs(grid, 1, rng).free).sum() < 100


def test_a_share_outside_0_to_1_is_refused():
    with pytest.raises(InputError, match="share"):
        salt(small_map(), 1.5, np.random.default_rng(0))


def across(*values: int) -> OccupancyGrid:
    """A map that is the same in every row: F, #, ? by columns."""
    return OccupancyGrid(np.tile(np.array(values, dtype=np.int8), (9, 1)))


F, W, U = FREE, OCCUPIED, UNKNOWN


def test_erosion_bares_free_space_on_the_free_side_and_unknown_on_the_other():
    assert erosion(across(F, F, W, W, W, W, U, U), 1).occupancy[4].tolist() == [F, F, F, W, W, U, U, U]


def test_erosion_takes_thin_walls_away_and_leaves_a_map_without_walls_alone():
    assert not erosion(across(F, W, W, F), 1).occupied.any()
    assert (erosion(across(F, F, U), 3).occupancy == across(F, F, U).occupancy).all()


@pytest.mark.parametrize("reach", [0, 1, 2, 3.7])
def test_dilation_covers_what_lies_within_its_reach_of_a_wall(reach):
    cells = np.random.default_rng(1).choice([F, U, W], (20, 24), p=[0.6, 0.36, 0.04]).astype(np.int8)
    walls = np.argwhere(cells == W)
    near = np.array([np.hypot(*(walls - at).T).min() <= reach for at in np.ndindex(cells.shape)]).reshape(cells.shape)

    assert (dilation(OccupancyGrid(cells), reach).occupied == near).all()


def test_a_wall_that_is_thickened_and_thinned_again_is_as_before():
    grid = across(F, F, F, F, W, W, F, F, F, F)

    assert (erosion(dilation(grid, 2), 2).occupancy == grid.occupancy).all()
