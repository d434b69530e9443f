from itertools import pairwise

import numpy as np
import pytest

from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from scenarios.pairs.exploring import explore, steps_from
from tests import drawing

GRID = drawing.building(resolution=0.05, origin=(-2.0, -1.5, 0.3))


def breadth_first(free, start):
    """Oracle: steps by a queue, cell by cell."""
    steps, queue = {start: 0}, [start]
    for row, col in queue:
        for near in ((row - 1, col), (row + 1, col), (row, col - 1), (row, col + 1)):
            if 0 <= near[0] < free.shape[0] and 0 <= near[1] < free.shape[1] and free[near] and near not in steps:
                steps[near] = steps[row, col] + 1
                queue.append(near)
    return steps


@pytest.mark.parametrize("seed", range(5))
def test_steps_are_those_of_a_breadth_first_search(seed):
    free = np.random.default_rng(seed).random((24, 31)) < 0.7
    steps = steps_from(free, seed)
    (start,) = np.argwhere(steps == 0)
    expected = breadth_first(free, tuple(start))

    assert {tuple(cell): steps[tuple(cell)] for cell in np.argwhere(steps >= 0)} == expected


def test_each_version_shows_an_equal_share_more_and_the_last_one_all():
    versions = list(explore(GRID, 5, seed=1))
    shares = [version.free.sum() / GRID.free.sum() for version in versions]

    assert shares == pytest.approx([0.2, 0.4, 0.6, 0.8, 1.0], abs=0.03)
    assert versions[-1] is GRID


def test_what_is_shown_is_the_map_and_stays_shown():
    versions = list(explore(GRID, 6, seed=2))
    for earlier, later in pairwise(versions):
        known = earlier.occupancy != UNKNOWN
        np.testing.assert_array_equal(earlier.occupancy[known], GRID.occupancy[known])
        assert np.all(later.occupancy[known] == earlier.occupancy[known])
        assert earlier.origin == GRID.origin


def test_walls_beside_the_free_space_are_shown_and_rooms_behind_them_are_not():
    cells = np.full((20, 41), FREE, dtype=np.int8)
    cells[:, 20] = OCCUPIED  # two rooms without a door
    first = next(explore(OccupancyGrid(cells, 0.05), 2, seed=0))
    left, right = first.free[:, :20].any(), first.free[:, 21:].any()

    assert left != right
    assert first.occupied[:, 20].any()


def test_what_no_way_leads_to_comes_last():
    cells = np.full((20, 41), FREE, dtype=np.int8)
    cells[:, 12] = OCCUPIED
    *before, last = explore(OccupancyGrid(cells, 0.05), 4, seed=0)

    assert not any(version.free[:, :12].any() for version in before)
    assert last.free[:, :12].all()
