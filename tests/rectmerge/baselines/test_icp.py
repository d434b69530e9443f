import math

import cv2
import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.baselines.icp import Icp
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from tests import drawing
from tests.rectmerge.baselines.scenes import TRUTH, corners_apart, long_halls, view


@pytest.mark.parametrize("scale", ["free", (0.7, 0.85), TRUTH.scale])
def test_a_rescaled_view_is_placed_within_a_cell(scale):
    alignment = align(drawing.building(), view(), method="icp", scale=scale)

    assert alignment, alignment.reason
    assert corners_apart(alignment.candidates[0].pixels, TRUTH) < 1


def test_a_scale_that_is_known_is_kept():
    alignment = align(drawing.building(), view(), method="icp", scale=0.8)

    assert alignment.candidates[0].pixels.scale == pytest.approx(0.8)


def test_walls_are_taken_from_a_large_map_shrunk():
    large = OccupancyGrid(np.kron(drawing.building().occupancy, np.ones((4, 4), np.int8)))

    alignment = align(large, view(), method=Icp(side_cells=200), scale=(2, 4))

    assert alignment, alignment.reason
    assert alignment.candidates[0].pixels.scale == pytest.approx(4 * TRUTH.scale, rel=0.01)
    assert alignment.candidates[0].pixels.angle == pytest.approx(TRUTH.angle, abs=math.radians(0.5))


def test_the_walls_of_each_map_are_looked_up_once(monkeypatch):
    looked_up = []

    def counted(image, *rest, **more):
        looked_up.append(image.shape)
        return transform(image, *rest, **more)

    transform = cv2.distanceTransformWithLabels
    monkeypatch.setattr(cv2, "distanceTransformWithLabels", counted)

    assert align(drawing.building(), view(), method="icp", scale=TRUTH.scale)
    assert len(looked_up) == 2


def test_another_building_is_rejected():
    assert align(drawing.building(), long_halls(), method="icp").verdict == "rejected"


def test_a_map_without_walls_is_named():
    alignment = align(drawing.building(), OccupancyGrid(np.zeros((30, 30), np.int8)), method="icp")

    assert alignment.verdict == "rejected"
    assert "map B" in alignment.reason


@pytest.mark.parametrize(("field", "value"), [("angles", 0), ("kept_share", 1.5), ("accept_at", 0.0)])
def test_a_parameter_that_cannot_be_is_refused(field, value):
    with pytest.raises(InputError, match=field):
        Icp(**{field: value})
