import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from scenarios.corruption import NOISE_LEVELS, add_noise, find_noise
from scenarios.corruption.noise_levels import in_cells
from tests.scenarios.corruption.small_map import changed, small_map

CELLS = (0, "cells-1", "cells-2", "cells-3")
KEPT = ("ba8b9b976a8c512a", "76eea97381493f7b", "dc1823a0cb5a5ac6", "03cfb2913579ed8e")


@pytest.mark.parametrize("level", range(4))
def test_a_level_of_cell_noise_gives_the_cells_that_committed_results_rest_on(level):
    cells = add_noise(small_map(), CELLS[level], np.random.default_rng(5)).occupancy

    assert hashlib.sha256(cells.tobytes()).hexdigest()[:16] == KEPT[level]


@settings(max_examples=15, deadline=None)
@given(st.sampled_from(NOISE_LEVELS), st.integers(0, 1000))
def test_the_same_seed_gives_the_same_cells_and_the_frame_stays(level, seed):
    first, again = (add_noise(small_map(), level, np.random.default_rng(seed)) for _ in range(2))

    assert np.array_equal(first.occupancy, again.occupancy)
    assert (first.resolution, first.origin, first.shape) == (0.05, (1.0, 2.0, 0.3), (200, 200))


@pytest.mark.parametrize("levels", [(0, 1, 2, 3), CELLS])
def test_more_noise_changes_more_cells_and_level_zero_none(levels):
    shares = [
        np.mean([changed(small_map(), add_noise(small_map(), level, np.random.default_rng(k))) for k in range(8)])
        for level in levels
    ]

    assert shares[0] == 0.0
    assert np.all(np.diff(shares) > 0.001)


def test_maps_of_one_level_differ_in_strength_and_those_of_cell_noise_do_not():
    shares = {
        level: [changed(small_map(), add_noise(small_map(), level, np.random.default_rng(k))).mean() for k in range(12)]
        for level in (1, "cells-1")
    }

    assert max(shares[1]) > 1.5 * min(shares[1])
    assert max(shares["cells-1"]) < 1.25 * min(shares["cells-1"])


@pytest.mark.parametrize("level", NOISE_LEVELS)
def test_maps_without_walls_or_without_free_space_are_borne(level):
    for value in (FREE, OCCUPIED, UNKNOWN):
        grid = OccupancyGrid(np.full((20, 30), value, dtype=np.int8))
        assert add_noise(grid, level, np.random.default_rng(0)).shape == (20, 30)


def test_cell_noise_stands_in_for_the_levels_of_the_same_number():
    assert [in_cells(level) for level in (0, 1, 3, "cells-2")] == [0, "cells-1", "cells-3", "cells-2"]


@pytest.mark.parametrize("level", [-1, 4, 0.5, "cells-4"])
def test_an_unknown_level_is_refused(level):
    with pytest.raises(InputError, match="noise must be one of 0, 1, 2, 3, cells-1"):
        find_noise(level)
