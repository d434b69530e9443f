import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge._kernels.placements import distinct, invert, pair_by_both_sides, pair_by_one_side
from rectmerge.robust.features import Frame
from rectmerge.robust.hypotheses import propose
from rectmerge.robust.params import ProposeParams
from rectmerge.similarity import Similarity
from tests.rectmerge.robust import naive
from tests.rectmerge.robust.plans import as_placement

PARAMS = ProposeParams()
LANDMARKS = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 100.0], [100.0, 100.0]])
PLACEMENTS = st.tuples(st.floats(0.3, 3), st.floats(-math.pi, math.pi), st.floats(-200, 200), st.floats(-200, 200))
BOUNDS = (math.log(0.5), math.log(2.0))
TURN_OF_FRAME = 0.4  # of A's first axis


def rooms_seen_by_b(quarter: int, *, cut: float = 0.0) -> tuple[Frame, Frame, Similarity]:
    """Draw five rooms in A's turned frame, and the same as B sees them; B may miss a share of each at its right end.

    The truth takes B's frame, turned by 0.1, to A's frame, turned by 0.4, with so many quarter turns between.
    """
    truth = Similarity(1.25, TURN_OF_FRAME - 0.1 + quarter * math.pi / 2, 30.0, -12.0)
    rng = np.random.default_rng(0)
    boxes_a = np.column_stack([rng.uniform(0, 200, (5, 2)), rng.uniform(30, 90, (5, 2))])
    centres, sides = boxes_a[:, :2].copy(), boxes_a[:, 2:].copy()
    seen = np.ones((5, 4), np.bool_)
    if cut:
        off = cut * sides[:, 0]  # along A's first axis the right end is not seen
        centres -= off[:, None] / 2 * [math.cos(TURN_OF_FRAME), math.sin(TURN_OF_FRAME)]
        sides[:, 0] -= off
        seen[:, 1] = False
    sides_b = sides[:, ::-1] if quarter % 2 else sides
    boxes_b = np.column_stack([truth.inverse().apply(centres), sides_b / truth.scale])
    return (
        Frame(TURN_OF_FRAME, boxes_a, np.ones((5, 4), np.bool_)),
        Frame(0.1, boxes_b, sides_of_b(seen, quarter)),
        truth,
    )


def sides_of_b(seen: np.ndarray, quarter: int) -> np.ndarray:
    """Reorder flags of A's left, right, top and bottom sides as B's, whose frame is so many quarter turns behind."""
    outward = np.array([[-1, 0], [1, 0], [0, -1], [0, 1]])  # left, right, top, bottom
    back = np.round(Similarity(1.0, -quarter * math.pi / 2).apply(outward)).astype(int)
    flags = np.zeros_like(seen)
    for side, normal in enumerate(back):
        flags[:, (outward == normal).all(axis=1).argmax()] = seen[:, side]
    return flags


def nearest(placements: np.ndarray, truth: Similarity) -> float:
    return min(np.abs(naive.move(p, LANDMARKS) - truth.apply(LANDMARKS)).max() for p in placements)


@given(st.lists(PLACEMENTS, min_size=1, max_size=5))
def test_the_inverse_undoes_a_placement(drawn):
    placements = np.array([as_placement(Similarity(*each)) for each in drawn])

    for there, back in zip(placements, invert(placements), strict=True):
        np.testing.assert_allclose(naive.move(back, naive.move(there, LANDMARKS)), LANDMARKS, atol=1e-9)
    np.testing.assert_allclose(invert(invert(placements)), placements, atol=1e-9)


@pytest.mark.parametrize("quarter", range(4))
def test_pairs_of_whole_rooms_give_the_placement_in_every_quarter_turn(quarter):
    a, b, truth = rooms_seen_by_b(quarter)
    placements = np.empty((500, 4))
    turn = a.angle - b.angle + quarter * math.pi / 2

    count = pair_by_both_sides(a.boxes, b.boxes, turn, quarter % 2 == 1, BOUNDS, 0.01, placements, 0)

    right = [np.abs(naive.move(p, LANDMARKS) - truth.apply(LANDMARKS)).max() < 1e-6 for p in placements[:count]]
    assert sum(right) == 5


@pytest.mark.parametrize("quarter", range(4))
def test_pairs_of_rooms_cut_off_by_the_unknown_give_it_too(quarter):
    a, b, truth = rooms_seen_by_b(quarter, cut=0.5)
    placements = np.empty((2000, 4))

    count = pair_by_one_side(
        a.boxes, b.boxes, a.has_wall, b.has_wall, a.angle, b.angle, quarter, BOUNDS, 0.0, placements, 0
    )

    right = [np.abs(naive.move(p, LANDMARKS) - truth.apply(LANDMARKS)).max() < 1e-6 for p in placements[:count]]
    assert sum(right) == 5


@pytest.mark.parametrize("quarter", range(4))
def test_rooms_without_walls_at_the_ends_of_an_extent_tell_no_length(quarter):
    a, b, _ = rooms_seen_by_b(quarter, cut=0.5)
    placements = np.empty((2000, 4))

    count = pair_by_one_side(
        a.boxes, b.boxes, a.has_wall, np.zeros_like(b.has_wall), a.angle, b.angle, quarter, BOUNDS, 0.0, placements, 0
    )

    assert count == 0


@pytest.mark.parametrize("quarter", range(4))
@pytest.mark.parametrize("cut", [0.0, 0.3, 0.5])
def test_the_truth_is_proposed(quarter, cut):
    a, b, truth = rooms_seen_by_b(quarter, cut=cut)

    assert nearest(propose([a], [b], (0.5, 2.0), PARAMS), truth) < 1e-6


def test_a_second_frame_adds_what_the_first_does_not_see():
    a, b, truth = rooms_seen_by_b(0)
    astray = Frame(a.angle + 0.5, a.boxes, a.has_wall)

    assert nearest(propose([astray], [b], (0.5, 2.0), PARAMS), truth) > 5
    assert nearest(propose([astray, a], [b], (0.5, 2.0), PARAMS), truth) < 1e-6


@pytest.mark.parametrize("bounds", [(0.5, 0.8), (0.9, 1.0), (1.2, 1.3), (1.0, 1.0)])
def test_proposals_stay_within_the_bounds_and_a_little(bounds):
    a, b, _ = rooms_seen_by_b(1)

    placements = propose([a], [b], bounds, PARAMS)
    scales = np.hypot(placements[:, 0], placements[:, 1])

    assert len(placements)
    assert scales.min() >= bounds[0] * 0.96
    assert scales.max() <= bounds[1] * 1.04


def test_more_pairs_than_there_is_room_for_are_left_out():
    rng = np.random.default_rng(0)
    boxes = np.column_stack([rng.uniform(0, 200, (500, 2)), rng.uniform(30, 40, (500, 2))])
    frame = Frame(0.0, boxes, np.ones((500, 4), np.bool_))

    assert propose([frame], [frame], (0.5, 2.0), PARAMS).shape == (PARAMS.max_hypotheses, 4)


def test_no_rectangles_no_proposals():
    empty = Frame(0.0, np.empty((0, 4)), np.empty((0, 4), np.bool_))

    assert propose([empty], [rooms_seen_by_b(0)[1]], (0.5, 2.0), PARAMS).shape == (0, 4)


@given(st.lists(PLACEMENTS, min_size=1, max_size=12), st.floats(1, 300), st.integers(1, 6))
def test_distinct_agrees_with_a_slow_loop(drawn, apart, keep):
    placements = np.array([as_placement(Similarity(*each)) for each in drawn])

    kept = distinct(placements, LANDMARKS, apart, keep)

    assert kept.tolist() == naive.distinct(placements, LANDMARKS, apart, keep)
