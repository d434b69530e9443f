from dataclasses import replace

import numpy as np
import pytest

from rectmerge.grid import OccupancyGrid
from rectmerge.paper.inspection import inspect_map
from tests import drawing


@pytest.fixture(scope="module")
def inspected():
    return inspect_map(drawing.building(resolution=0.05))


def test_a_long_series_of_neighbours_does_not_widen_the_picture(inspected):
    longer = {side: [2, 3, 4, 5, 6] * 10 for side in inspected.series}

    assert replace(inspected, series=longer).draw().shape[1] == inspected.draw().shape[1]


@pytest.mark.parametrize(
    ("side", "resolution", "area"),
    [
        (200, None, "40,000 cells"),
        (200, 0.05, "100 square metres"),
        (38, 0.05, "3.61 square metres"),
        (200, 1.5, "90,000 square metres"),
    ],
)
def test_free_space_is_told_without_powers_of_ten(side, resolution, area):
    free = OccupancyGrid(np.zeros((side, side), np.int8), resolution)

    assert f"  free space   {area}\n" in str(inspect_map(free))
