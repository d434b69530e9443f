from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.errors import MapFileError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.occupancy_message import grid_of_message, updated
from tests.rectmerge import bags

GRID = grid_of_message(bags.map_message(), "map")  # 3 rows, 4 columns


def update(cells, *, x, y, size=None):
    """An OccupancyGridUpdate with its rows from the bottom up; a table of cells has the top one first."""
    cells = np.array(cells, np.int8)
    width, height = size or cells.shape[::-1]
    return SimpleNamespace(x=x, y=y, width=width, height=height, data=cells[::-1].ravel())


def test_an_update_counts_from_the_lower_left_cell():
    whole = updated(GRID, update([[100, 0]], x=1, y=0), "update")

    assert whole.occupancy.tolist() == [[0, 0, 100, 100], [0, -1, 0, 100], [0, 100, 0, 50]]
    assert (whole.origin, whole.resolution, whole.frame) == (GRID.origin, GRID.resolution, GRID.frame)
    assert GRID.occupancy.tolist() == [list(row) for row in bags.LAID]  # the map itself is not touched


@given(st.data())
def test_parts_of_a_map_make_the_whole_one(data):
    rows, columns = data.draw(st.integers(2, 6)), data.draw(st.integers(2, 6))
    cells = np.random.default_rng(data.draw(st.integers(0, 99))).choice([-1, 0, 100], (rows, columns)).astype(np.int8)
    cells[0, 0] = 0
    grid = OccupancyGrid(np.zeros_like(cells), 0.05)
    at_row, at_column = data.draw(st.integers(0, rows)), data.draw(st.integers(0, columns))
    for top, bottom in ((0, at_row), (at_row, rows)):
        for left, right in ((0, at_column), (at_column, columns)):
            part = cells[top:bottom, left:right]
            grid = updated(grid, update(part, x=left, y=rows - bottom, size=part.shape[::-1]), "update")

    assert np.array_equal(grid.occupancy, cells)


def test_values_that_mean_nothing_are_unknown():
    assert updated(GRID, update([[-100, 101]], x=0, y=2), "update").occupancy[0].tolist() == [-1, -1, 100, 100]


@pytest.mark.parametrize(
    ("message", "fault"),
    [
        (update([[0, 0]], x=3, y=0), r"2 x 1 cells at \(3, 0\) reach outside the map of 4 x 3: send the whole map"),
        (update([[0], [0]], x=0, y=2), "reach outside"),
        (update([[0]], x=-1, y=0), "reach outside"),
        (update([[0]], x=0, y=-1), "reach outside"),
        (update([[0, 0]], x=0, y=0, size=(2, 2)), "2 cells are not the stated 2 x 2"),
        (update(np.full((3, 4), -1), x=0, y=0), "all cells are unknown after it"),
        (update(np.full((3, 4), 100), x=0, y=0), "no cell is free after it"),
    ],
)
def test_an_update_that_does_not_fit_is_named(message, fault):
    with pytest.raises(MapFileError, match=f"the update: .*{fault}"):
        updated(GRID, message, "the update")
