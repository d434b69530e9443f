import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.baselines.regions import Regions, region_boxes
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from tests import drawing
from tests.rectmerge.baselines.scenes import TRUTH, corners_apart, long_halls, view


@pytest.mark.parametrize("scale", ["free", TRUTH.scale])
def test_a_rescaled_view_is_placed_within_two_cells(scale):
    alignment = align(drawing.building(), view(), method="regions", scale=scale)

    assert alignment, alignment.reason
    assert corners_apart(alignment.candidates[0].pixels, TRUTH) < 2


def test_a_scale_that_is_known_is_kept():
    alignment = align(drawing.building(), view(), method="regions", scale=TRUTH.scale)

    assert alignment.candidates[0].pixels.scale == pytest.approx(TRUTH.scale)


def test_another_building_is_rejected():
    assert align(drawing.building(), long_halls(), method="regions").verdict == "rejected"


def test_the_box_of_a_turned_room_lies_on_its_walls():
    free = np.zeros((80, 120), np.bool_)
    free[20:60, 10:110] = True

    boxes = region_boxes(drawing.grid_of(free), 5)

    corners = boxes[0]
    assert sorted(np.abs(np.diff(np.append(corners, corners[0])))) == pytest.approx([40, 40, 100, 100], abs=2)
    assert corners.mean() == pytest.approx(59.5 + 39.5j, abs=1)


def test_a_map_without_a_region_is_named():
    occupancy = np.full((40, 40), -1, np.int8)
    occupancy[20, 20:23] = 0

    alignment = align(drawing.building(), OccupancyGrid(occupancy), method="regions")

    assert alignment.verdict == "rejected"
    assert "map B has no region" in alignment.reason


@pytest.mark.parametrize(("field", "value"), [("max_regions", 0), ("shape_tolerance", 0.0), ("accept_at", 1.5)])
def test_a_parameter_that_cannot_be_is_refused(field, value):
    with pytest.raises(InputError, match=field):
        Regions(**{field: value})
