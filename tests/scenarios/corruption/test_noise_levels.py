import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from scenarios.corruption import add_noise, noise_strength
from tests.scenarios.corruption.small_map import changed, small_map

KEPT = ("ba8b9b976a8c512a", "76eea97381493f7b", "dc1823a0cb5a5ac6", "03cfb2913579ed8e")


@pytest.mark.parametrize("level", range(4))
def test_a_level_gives_the_cells_that_committed_results_rest_on(level):
    cells = add_noise(small_map(), level, np.random.default_rng(5)).occupancy

    assert hashlib.sha256(cells.tobytes()).hexdigest()[:16] == KEPT[level]


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 3), st.integers(0, 1000))
def test_the_same_seed_gives_the_same_cells_and_the_frame_stays(level, seed):
    first, again = (add_noise(small_map(), level, np.random.default_rng(seed)) for _ in range(2))

    assert np.array_equal(first.occupancy, again.occupancy)
    assert (first.resolution, first.origin, first.shape) == (0.05, (1.0, 2.0, 0.3), (200, 200))


def test_more_noise_changes_more_cells_and_level_zero_none():
    shares = [
        changed(small_map(), add_noise(small_map(), level, np.random.default_rng(1))).mean() for level in range(4)
    ]

    assert shares[0] == 0.0
    assert np.all(np.diff(shares) > 0.004)


@pytest.mark.parametrize("level", range(4))
def test_maps_without_walls_or_without_free_space_are_borne(level):
    for value in (FREE, OCCUPIED, UNKNOWN):
        grid = OccupancyGrid(np.full((20, 30), value, dtype=np.int8))
        assert add_noise(grid, level, np.random.default_rng(0)).shape == (20, 30)


@pytest.mark.parametrize("level", [-1, 4, 0.5])
def test_an_unknown_level_is_refused(level):
    with pytest.raises(InputError, match="noise must be one of 0, 1, 2, 3"):
        noise_strength(level)
