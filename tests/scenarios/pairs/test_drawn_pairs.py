import cv2
import numpy as np
import pytest

from scenarios.pairs.drawn_pairs import easy_pairs
from scenarios.pairs.truth import control_point_rmse

PAIRS = pytest.mark.parametrize("pair", easy_pairs(), ids=lambda pair: pair.pair_id)


@PAIRS
def test_the_truth_lays_walls_on_walls(pair):
    u, v = np.rint(pair.control_points[:, :2]).astype(int).T
    at_b = np.rint(pair.control_points[:, 2:]).astype(int)

    inside = ((at_b >= 0) & (at_b < pair.b.shape[::-1])).all(axis=1)
    near_a = cv2.dilate(pair.a.occupied.view(np.uint8), np.ones((3, 3), np.uint8))
    on_a = near_a[v.clip(0, pair.a.shape[0] - 1), u.clip(0, pair.a.shape[1] - 1)]
    near_b = cv2.dilate(pair.b.occupied.view(np.uint8), np.ones((3, 3), np.uint8))
    on_b = near_b[at_b[inside, 1], at_b[inside, 0]]
    assert control_point_rmse(pair.pixels.matrix, pair.control_points) < 1e-9
    assert min(on_a.mean(), on_b.mean()) > 0.99  # or beside: large cells lose parts of thin walls


@PAIRS
def test_most_of_a_map_is_in_the_other(pair):
    assert pair.overlap > 0.7
