from dataclasses import replace

import cv2
import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.analysis.fringe import REACH_CELLS, without_fringe
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN
from tests import drawing

BUILDING = drawing.building()
SPECKS = 0.01  # of the cells


def fringed(grid, cells):
    """Return a map whose walls stand apart from its free space by unknown cells."""
    near = cv2.dilate(grid.occupied.view(np.uint8), np.ones((2 * cells + 1, 2 * cells + 1), np.uint8)) > 0
    return replace(grid, occupancy=np.where(near & grid.free, UNKNOWN, grid.occupancy).astype(np.int8))


def filled(grid):
    return without_fringe(grid.occupancy, grid.occupied)


@pytest.mark.parametrize("cells", [1, 2, 3])
def test_a_fringe_is_taken_as_free(cells):
    values = filled(fringed(BUILDING, cells))

    lost = BUILDING.free & (values != FREE)  # narrow doors
    assert np.count_nonzero(lost) <= 0.02 * np.count_nonzero(BUILDING.free)
    np.testing.assert_array_equal(values == OCCUPIED, BUILDING.occupied)


def test_walls_beside_free_space_are_left_as_they_are():
    assert filled(BUILDING) is BUILDING.occupancy


def test_a_map_of_which_a_part_has_a_fringe_is_left_as_it_is():
    half = fringed(BUILDING, 3).occupancy.copy()
    half[:, 80:] = BUILDING.occupancy[:, 80:]
    assert without_fringe(half, half == OCCUPIED) is half


def test_the_unknown_farther_from_a_wall_stays_unknown():
    grid = fringed(BUILDING, 3)
    far = cv2.dilate(grid.occupied.view(np.uint8), np.ones((2 * REACH_CELLS + 1,) * 2, np.uint8)) == 0
    np.testing.assert_array_equal(filled(grid)[far], grid.occupancy[far])


def test_specks_of_free_cells_in_walls_and_of_obstacles_in_rooms_hide_no_fringe():
    grid = fringed(BUILDING, 3)
    noisy = grid.occupancy.copy()
    drawn = np.random.default_rng(3).random(grid.shape) < SPECKS
    noisy[drawn & grid.free] = OCCUPIED
    noisy[drawn & grid.occupied] = FREE
    cells = MapCells.from_grid(replace(grid, occupancy=noisy))

    assert np.count_nonzero(BUILDING.free & (cells.values == UNKNOWN)) <= 0.03 * np.count_nonzero(BUILDING.free)


@pytest.mark.parametrize("maps", ["both", "one"])
def test_maps_with_a_fringe_are_placed_as_those_without(maps):
    b = drawing.view(BUILDING, drawing.B_IN_A, (110, 120))
    expected = align(BUILDING, b).pixels
    found = align(fringed(BUILDING, 2), fringed(b, 2) if maps == "both" else b)

    assert found.verdict == "accepted"
    corners = np.array([[0, 0], [119, 0], [0, 109], [119, 109]])
    np.testing.assert_allclose(found.pixels.apply(corners), expected.apply(corners), atol=0.6)
