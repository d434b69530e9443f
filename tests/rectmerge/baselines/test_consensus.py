import math

import cv2
import numpy as np
import pytest

from rectmerge.baselines.consensus import agreed_similarity, mutual_matches
from rectmerge.similarity import Similarity

TRUTH = Similarity(1.3, 2.0, 40.0, -7.0)


def matched(right: int, wrong: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of A and B: the first match under the truth, the others under nothing."""
    rng = np.random.default_rng(0)
    b = rng.uniform(0, 200, (right + wrong, 2))
    return np.concatenate([TRUTH.apply(b[:right]), rng.uniform(-200, 300, (wrong, 2))]), b


def fit(a, b, scale=(0.5, 2.0)):
    return agreed_similarity(a, b, scale=scale, reach=2.0, samples=2000, rng=np.random.default_rng(1))


def test_the_similarity_of_a_minority_of_right_matches_is_found():
    placement = fit(*matched(right=20, wrong=60))

    assert placement.pixels.scale == pytest.approx(TRUTH.scale)
    assert math.remainder(placement.pixels.angle - TRUTH.angle, math.tau) == pytest.approx(0, abs=1e-9)
    assert placement.score == pytest.approx(20 / (8 + 0.3 * 80))


def test_a_scale_out_of_bounds_is_not_considered():
    a, b = matched(right=20, wrong=0)

    assert fit(a, b, scale=(0.5, 1.0)) is None


@pytest.mark.parametrize("count", [0, 2])
def test_fewer_than_three_matches_say_nothing(count):
    a, b = matched(right=count, wrong=0)

    assert fit(a, b) is None


def test_matches_in_one_place_say_nothing():
    assert fit(np.ones((9, 2)), np.ones((9, 2))) is None


def test_the_same_draws_give_the_same_answer():
    a, b = matched(right=5, wrong=80)

    assert fit(a, b) == fit(a, b)


def test_matches_are_one_to_one():
    rng = np.random.default_rng(0)
    a, b = (cv2.GaussianBlur(rng.integers(0, 256, (120, 120), np.uint8), (0, 0), 1.5) for _ in range(2))

    at_a, at_b = mutual_matches(a, b, cv2.ORB.create())

    assert len(at_a) == len(at_b) > 3
    described = cv2.ORB.create().detectAndCompute(a, None)[0]
    assert len(at_a) < len(described)  # not every keypoint's nearest has it as its own nearest
