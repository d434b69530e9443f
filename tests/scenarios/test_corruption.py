import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from scenarios.corruption import (
    blobs,
    damage,
    double_walls,
    noise_strength,
    salt,
    spurious_rays,
    wall_dropout,
    wall_edge_flips,
)


def drawn() -> OccupancyGrid:
    """A room of 180 x 180 cells with walls two cells thick, in unknown space."""
    cells = np.full((200, 200), UNKNOWN, dtype=np.int8)
    cells[8:192, 8:192] = OCCUPIED
    cells[10:190, 10:190] = FREE
    return OccupancyGrid(cells, 0.05, (1.0, 2.0, 0.3))


def changed(before: OccupancyGrid, after: OccupancyGrid) -> np.ndarray:
    return before.occupancy != after.occupancy


def test_salt_turns_its_share_of_the_free_cells_to_occupied_and_nothing_else():
    grid = drawn()
    salted = salt(grid, 0.01, np.random.default_rng(0))
    spots = changed(grid, salted)

    assert (grid.free & salted.occupied)[spots].all()
    assert spots.sum() / grid.free.sum() == pytest.approx(0.01, rel=0.2)


def test_flips_stay_where_free_space_and_walls_touch_and_go_both_ways():
    grid = drawn()
    flipped = wall_edge_flips(grid, 0.5, np.random.default_rng(0))
    rows, cols = np.nonzero(changed(grid, flipped))
    to_wall = np.minimum.reduce([rows - 9, cols - 9, 190 - rows, 190 - cols])  # 0: inner wall cells, 1: first free ones

    assert set(to_wall) == {0, 1}
    assert (grid.free & flipped.occupied).any()
    assert (grid.occupied & flipped.free).any()
    assert len(rows) / (4 * 180 + 4 * 178) == pytest.approx(0.5, abs=0.05)


def test_dropout_loses_its_share_of_the_wall_cells():
    grid = drawn()
    lost = changed(grid, wall_dropout(grid, 0.1, np.random.default_rng(0)))

    assert grid.occupied[lost].all()
    assert lost.sum() / grid.occupied.sum() == pytest.approx(0.1, rel=0.3)


def test_double_walls_add_walls_two_to_four_cells_aside():
    grid = drawn()
    added = changed(grid, double_walls(grid, 0.05, np.random.default_rng(0)))
    rows, cols = np.nonzero(added)
    away = np.minimum.reduce(
        [np.abs(rows - k) for k in (8, 9, 190, 191)] + [np.abs(cols - k) for k in (8, 9, 190, 191)]
    )

    assert added.any()
    assert away.max() <= 5


def test_rays_add_free_cells_and_blobs_take_some():
    grid, rng = drawn(), np.random.default_rng(3)

    assert (spurious_rays(grid, 20, rng).free & ~grid.free).any()
    assert not (grid.free & ~spurious_rays(grid, 20, rng).free).any()
    assert 8 < (grid.free & ~blobs(grid, 1, rng).free).sum() < 100


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 3), st.integers(0, 1000))
def test_the_same_seed_does_the_same_damage_and_the_frame_stays(level, seed):
    first, again = (damage(drawn(), level, np.random.default_rng(seed)) for _ in range(2))

    assert np.array_equal(first.occupancy, again.occupancy)
    assert (first.resolution, first.origin, first.shape) == (0.05, (1.0, 2.0, 0.3), (200, 200))


def test_more_noise_changes_more_cells_and_level_zero_none():
    shares = [changed(drawn(), damage(drawn(), level, np.random.default_rng(1))).mean() for level in range(4)]

    assert shares[0] == 0.0
    assert np.all(np.diff(shares) > 0.004)


@pytest.mark.parametrize("level", range(4))
def test_maps_without_walls_or_without_free_space_are_borne(level):
    for value in (FREE, OCCUPIED, UNKNOWN):
        grid = OccupancyGrid(np.full((20, 30), value, dtype=np.int8))
        assert damage(grid, level, np.random.default_rng(0)).shape == (20, 30)


@pytest.mark.parametrize("level", [-1, 4, 0.5])
def test_an_unknown_level_is_refused(level):
    with pytest.raises(InputError, match="noise must be one of 0, 1, 2, 3"):
        noise_strength(level)


def test_a_share_outside_0_to_1_is_refused():
    with pytest.raises(InputError, match="share"):
        salt(drawn(), 1.5, np.random.default_rng(0))
