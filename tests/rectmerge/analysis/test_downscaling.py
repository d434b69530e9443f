import numpy as np
import pytest

from rectmerge.analysis.downscaling import Shrunk, between_given, shrunk_bounds
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity


def spotted(height: int, width: int, row: int, col: int) -> OccupancyGrid:
    """Draw free space with one occupied cell, in a margin of three unknown cells."""
    cells = np.full((height, width), FREE, np.int8)
    cells[row, col] = OCCUPIED
    return OccupancyGrid(np.pad(cells, 3, constant_values=UNKNOWN))


def test_a_wall_of_one_cell_stays_and_keeps_its_place():
    shrunk = Shrunk.from_grid(spotted(40, 61, 20, 41), 31)

    ((row, col),) = np.argwhere(shrunk.grid.occupied)
    assert shrunk.grid.shape == (20, 31)
    assert shrunk.to_given.apply([col, row]) == pytest.approx([41 + 3, 20 + 3], abs=0.51)


def test_the_middle_of_a_block_is_the_middle_of_its_cells():
    assert Shrunk.from_grid(spotted(40, 60, 0, 0), 20).to_given.apply([0, 0]) == pytest.approx([3 + 1, 3 + 1])


def test_a_small_map_is_only_cut():
    shrunk = Shrunk.from_grid(spotted(10, 12, 4, 5), 100)

    assert (shrunk.grid.shape, shrunk.to_given) == ((10, 12), Similarity(1.0, 0.0, 3.0, 3.0))


def test_bounds_and_placements_of_shrunk_maps_stand_for_those_of_the_maps():
    a, b = Shrunk.from_grid(spotted(40, 60, 1, 1), 20), Shrunk.from_grid(spotted(40, 60, 1, 1), 60)

    assert shrunk_bounds((0.5, 2.0), a, b) == pytest.approx((0.5 / 3, 2.0 / 3))
    given = between_given(Similarity(1 / 3, 0.0, -1 / 3, -1 / 3), a, b)
    assert given.matrix == pytest.approx(Similarity().matrix)
