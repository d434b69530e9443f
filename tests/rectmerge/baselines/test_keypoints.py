import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.baselines.keypoints import Keypoints, to_image
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from tests.rectmerge.baselines import scenes

EVERY = [(detector, variant) for detector in ("akaze", "orb", "sift") for variant in ("stitching", "plain")]


@pytest.mark.parametrize(("detector", "variant"), EVERY)
@pytest.mark.parametrize("scale", ["free", 1.3])
def test_turn_scale_and_shift_are_found(detector, variant, scale):
    b, truth = scenes.turned(1.3, 40)

    alignment = align(scenes.upright(), b, method=Keypoints(detector=detector, variant=variant), scale=scale)

    assert scenes.farthest(alignment.candidates[0].pixels, truth, b) < 5


@pytest.mark.parametrize(("detector", "variant"), EVERY)
def test_another_building_is_rejected(detector, variant):
    assert not align(scenes.upright(), scenes.other(), method=Keypoints(detector=detector, variant=variant))


@pytest.mark.parametrize(("detector", "variant"), EVERY)
@pytest.mark.parametrize("shape", [(1, 60), (60, 3), (40, 40)])
def test_a_map_in_which_nothing_is_found_is_rejected_with_a_reason(detector, variant, shape):
    narrow = OccupancyGrid(np.zeros(shape, np.int8))

    alignment = align(scenes.upright(), narrow, method=Keypoints(detector=detector, variant=variant))

    assert (alignment.verdict, alignment.candidates) == ("rejected", ())
    assert detector in alignment.reason


def test_matches_that_agree_on_a_single_point_are_no_placement():
    blocks = np.random.default_rng(13).choice([-1, 0, 100], (24, 24))
    noise = OccupancyGrid(np.kron(blocks, np.ones((6, 6), np.int64)))

    assert not align(scenes.other(), noise, method=Keypoints()).candidates


def test_the_image_shows_unknown_as_white_and_occupied_as_a_hundred():
    grid = OccupancyGrid(np.array([[-1, 0, 40, 100]], np.int8))

    assert to_image(grid).tolist() == [[255.0, 0.0, 40.0, 100.0]]


@pytest.mark.parametrize(
    "fields",
    [
        {"detector": "surf"},
        {"variant": "fancy"},
        {"match_conf": 1.0},
        {"match_conf": -0.1},
        {"reach_cells": 0.0},
        {"samples": 0},
        {"longest_cells": 0},
        {"accept_at": 0.0},
    ],
)
def test_a_parameter_out_of_range_is_refused_by_name(fields):
    with pytest.raises(InputError, match=next(iter(fields))):
        Keypoints(**fields)
