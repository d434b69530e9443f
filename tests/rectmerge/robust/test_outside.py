"""Maps that are white around the building."""

import cv2
import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.grid import FREE, OccupancyGrid
from rectmerge.robust.outside import without_outside
from rectmerge.robust.params import OutsideParams
from tests.rectmerge.robust import plans

PARAMS = OutsideParams()
MARGIN_CELLS = 30


def white_outside(grid: OccupancyGrid) -> OccupancyGrid:
    cells = np.pad(grid.occupancy, MARGIN_CELLS, constant_values=-1)
    return OccupancyGrid(np.where(cells < 0, np.int8(FREE), cells), grid.resolution)


def turned(grid: OccupancyGrid, degrees: float) -> OccupancyGrid:
    """Turn a picture on a larger sheet, which is unknown beside it."""
    height, width = grid.shape
    side = int(np.hypot(height, width)) + 4
    turn = cv2.getRotationMatrix2D((width / 2, height / 2), degrees, 1.0)
    turn[:, 2] += (side - np.array([width, height])) / 2
    cells = cv2.warpAffine(
        (grid.occupancy.astype(np.int16) + 1).astype(np.uint8), turn, (side, side), flags=cv2.INTER_NEAREST
    )
    return OccupancyGrid((cells.astype(np.int16) - 1).astype(np.int8))


@pytest.mark.parametrize("degrees", [0.0, 20.0, 45.0])
def test_the_outside_of_a_picture_becomes_unknown_and_its_rooms_stay_free(degrees):
    view = plans.see(plans.office(1), wall_cells=6)
    picture = turned(white_outside(view.grid), degrees)
    inside = without_outside(picture, PARAMS)
    rooms = np.count_nonzero(view.grid.free)
    assert np.count_nonzero(picture.free) > 1.5 * rooms
    assert np.count_nonzero(inside.free) == pytest.approx(rooms, rel=0.03)
    assert np.array_equal(inside.occupied, picture.occupied)


def test_a_front_door_lets_the_outside_in_no_further_than_the_wall():
    view = plans.see([*plans.office(1), plans.box(-8.0, 60.0, 16.0, 8.0)], wall_cells=6)
    inside = without_outside(white_outside(view.grid), PARAMS)
    assert np.count_nonzero(inside.free) == pytest.approx(np.count_nonzero(view.grid.free), rel=0.05)


@pytest.mark.parametrize(
    "cells",
    [
        pytest.param(plans.see(plans.office(1)).grid.occupancy, id="a robot's map, unknown outside"),
        pytest.param(np.zeros((60, 90), np.int8), id="a hall without a wall"),
        pytest.param(np.full((60, 90), -1, np.int8), id="nothing known"),
        pytest.param(np.pad(np.zeros((60, 90), np.int8), 1, constant_values=100), id="a room, walls at its edge"),
        pytest.param(np.zeros((1, 1), np.int8), id="one cell"),
    ],
)
def test_other_maps_stay_as_they_are(cells):
    grid = OccupancyGrid(cells)
    assert without_outside(grid, PARAMS) is grid


@pytest.mark.parametrize(
    ("is_white", "seed"), [((True, False), 2), ((False, True), 1), ((False, True), 8)], ids=["A", "B", "another B"]
)
def test_a_map_that_is_white_outside_is_placed_on_one_that_is_not(is_white, seed):
    rooms, window = plans.office(seed), (210, 220)
    a = plans.see(rooms, window=(0, 0, *window), noise=1)
    b = plans.see(rooms, window=(90, 0, *window), degrees=33, scale=1.2, noise=1, seed=1)
    grids = [white_outside(v.grid) if white else v.grid for v, white in zip((a, b), is_white, strict=True)]
    result = align(*grids)
    assert result, result.reason
    name = "AB"[is_white.index(True)]
    assert result.reason.endswith(f"the white outside of map {name} was taken as unknown")
    corners = [MARGIN_CELLS * white for white in is_white]
    points = np.argwhere(b.grid.free)[::97, ::-1].astype(float)
    placed = result.candidates[0].pixels.apply(points + corners[1]) - corners[0]
    assert np.abs(placed - plans.truth(a, b).apply(points)).max() < 2.0
