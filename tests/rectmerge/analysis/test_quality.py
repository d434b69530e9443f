import math

import cv2
import numpy as np
import pytest

from rectmerge.analysis.quality import measure_quality
from rectmerge.grid import OccupancyGrid
from tests import drawing


def walls(thickness: int) -> OccupancyGrid:
    occupancy = np.zeros((200, 200), np.int8)
    for at in (30, 90, 150):
        occupancy[at : at + thickness, 20:180] = 100
    return OccupancyGrid(occupancy)


def one_line(angle: float) -> OccupancyGrid:
    occupancy = np.zeros((200, 200), np.uint8)
    along = 80 * np.array([math.cos(angle), math.sin(angle)])
    cv2.line(occupancy, np.rint(100 - along).astype(int).tolist(), np.rint(100 + along).astype(int).tolist(), 100, 1)
    return OccupancyGrid(occupancy.astype(np.int8))


@pytest.mark.parametrize("thickness", [1, 2, 3, 4, 7])
def test_the_thickness_of_drawn_walls_is_measured_exactly(thickness):
    assert measure_quality(walls(thickness)).wall_thickness_cells == thickness


@pytest.mark.parametrize("degrees", [0, 10, 27, 45, 63])
def test_a_straight_wall_is_straight_in_every_direction(degrees):
    assert measure_quality(one_line(math.radians(degrees))).straightness > 0.9


def test_a_jagged_wall_is_less_straight():
    rng = np.random.default_rng(0)
    occupancy = np.zeros((200, 200), np.int8)
    columns = np.arange(20, 180)
    occupancy[100 + np.cumsum(rng.integers(-2, 3, 160)).clip(-60, 60), columns] = 100

    assert measure_quality(OccupancyGrid(occupancy)).straightness < 0.6


def test_a_clean_building_has_no_specks():
    assert measure_quality(drawing.building()).speckle == 0.0


@pytest.mark.parametrize("share", [0.01, 0.05])
def test_speckle_is_the_share_of_salted_cells_that_stand_alone(share):
    rng = np.random.default_rng(0)
    occupancy = np.where(rng.random((400, 400)) < share, np.int8(100), np.int8(0))

    assert measure_quality(OccupancyGrid(occupancy)).speckle == pytest.approx(share * (1 - share) ** 8, rel=0.1)


def test_salt_is_not_taken_for_walls():
    rng = np.random.default_rng(0)
    clean = drawing.building()
    salted = np.where((rng.random(clean.shape) < 0.01) & clean.free, np.int8(100), clean.occupancy)

    before, after = measure_quality(clean), measure_quality(OccupancyGrid(salted))

    assert after.speckle > 0.003
    assert after.wall_thickness_cells == before.wall_thickness_cells
    assert after.straightness == pytest.approx(before.straightness, abs=0.1)


def test_what_cannot_be_measured_is_not_told():
    empty = measure_quality(OccupancyGrid(np.zeros((20, 20), np.int8)))

    assert (empty.wall_thickness_cells, empty.straightness) == (None, None)
    assert empty.as_dict() == {"speckle": 0.0}


def test_a_map_of_one_cell_has_a_quality():
    assert measure_quality(OccupancyGrid(np.full((1, 1), 100, np.int8))).speckle == 1.0
