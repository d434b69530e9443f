import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rectmerge._kernels.placements import add_bent_scores, add_scores
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.robust.features import extract_features
from rectmerge.robust.likelihood import STEPS_PER_NAT, WallLikelihood, WallNoise, likelihood_field
from rectmerge.robust.params import Params
from rectmerge.robust.refinement import invert
from tests import drawing
from tests.rectmerge.robust import naive, plans

PARAMS = Params()
SEARCH_NOISE = WallNoise(PARAMS.propose.noise_spreads_cells, PARAMS.propose.noise_outliers)
NOISES = (
    SEARCH_NOISE,
    *(
        WallNoise((spread,), share)
        for spread, share in zip(PARAMS.rank.spreads_cells, PARAMS.rank.outliers, strict=True)
    ),
)
QUARTERS = st.integers(-120, 120).map(lambda k: k / 4 + 0.125)  # never halfway between two cells


def building_features():
    features = extract_features(MapCells.from_values(drawing.building().occupancy), PARAMS.prepare)
    assert features is not None
    return features


@given(
    arrays(np.int32, st.tuples(st.integers(3, 20), st.integers(3, 20)), elements=st.integers(-3000, 3000)),
    st.lists(st.tuples(QUARTERS, QUARTERS), min_size=1, max_size=20),
    st.lists(st.tuples(st.sampled_from([1.0, 0.5, 0.0]), st.sampled_from([1.0, -0.5]), QUARTERS, QUARTERS), min_size=1),
)
def test_scores_are_those_of_a_slow_loop(field, points, placements):
    field[[0, -1], :] = field[:, [0, -1]] = 0
    rows, walls = np.array(placements), np.array(points)
    x, y = (walls + 60) % 20, rows  # inside for about half of the shifts
    scores = np.full(len(rows), 7, np.int64)

    add_scores(rows, np.ascontiguousarray(x.T, np.float32), field, scores)

    assert scores.tolist() == [7 + naive.score(placement, x, field) for placement in y]


@given(st.integers(0, 2**32 - 1))
def test_scores_of_blocks_that_shift_are_those_of_a_slow_loop(seed):
    rng = np.random.default_rng(seed)
    field = rng.integers(-50, 50, (18, 23)).astype(np.int32)
    field[[0, -1], :] = field[:, [0, -1]] = 0
    # eighths of a cell, so that both ways of adding round alike
    points, placement = rng.integers(-40, 200, (12, 2)) / 8, np.array([1.0, 0.0, *(rng.integers(-40, 40, 2) / 8)])
    price = {"reach": 4, "step": 2, "cost": 3, "fixed_cost": 20}
    scores = np.full(1, 7, np.int64)

    add_bent_scores(
        placement[None], np.ascontiguousarray(points.T, np.float32), np.array([0, 5, 12]),
        np.pad(field, 2 * 4), *price.values(), scores,
    )  # fmt: skip

    blocks = [np.arange(5), np.arange(5, 12)]
    assert scores[0] == 7 + naive.bent_score(placement, points, blocks, field, **price)


@pytest.mark.parametrize("noise", NOISES)
def test_the_field_is_positive_at_walls_and_nothing_in_the_unknown(noise):
    features = extract_features(
        MapCells.from_values(plans.see(plans.office(0), degrees=40).grid.occupancy), PARAMS.prepare
    )
    assert features is not None
    field = likelihood_field(features, noise, PARAMS.gain)
    far = ~features.known & (features.distance > 3 * min(noise.spreads))
    u, v = np.rint(features.walls).astype(int).T

    assert far.any()
    assert (field[far] == 0).all()
    assert (field[v, u] >= 0).all()
    assert (field[v, u] > 0).any() or max(noise.spreads) == 4  # where walls are dense, such a loose match says nothing
    assert not field[[0, -1], :].any()
    assert not field[:, [0, -1]].any()


@pytest.mark.parametrize("noise", NOISES)
def test_walls_deep_in_free_space_speak_against_a_placement(noise):
    features = building_features()
    field = likelihood_field(features, noise, PARAMS.gain)

    assert (field[features.free & (features.distance > 4 * max(noise.spreads))] < 0).all()
    assert field.max() <= 3 * STEPS_PER_NAT


def test_a_wall_met_in_an_empty_hall_says_more_than_one_met_among_shelves():
    hall, shelves = np.zeros((120, 120), np.int8), np.zeros((120, 120), np.int8)
    for cells in (hall, shelves):
        cells[[0, -1], :] = cells[:, [0, -1]] = 100
    shelves[::4, 10:110] = 100

    gains = []
    for features in (extract_features(MapCells.from_values(cells), PARAMS.prepare) for cells in (hall, shelves)):
        assert features is not None
        u, v = np.rint(features.walls).astype(int).T
        gains.append(likelihood_field(features, SEARCH_NOISE, PARAMS.gain)[v, u].max())

    assert gains[0] > 2 * gains[1]


@pytest.mark.parametrize("noise", NOISES)
def test_the_truth_scores_best_among_its_neighbours_and_both_ways_alike(noise):
    a, b = plans.see(plans.office(0), degrees=10), plans.see(plans.office(0), degrees=75, scale=1.2)
    features_a, features_b = (
        extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare) for view in (a, b)
    )
    assert features_a is not None
    assert features_b is not None
    judge = WallLikelihood(features_a, features_b, features_a.walls, features_b.walls, noise, PARAMS.gain)
    true = in_working_cells(plans.truth(a, b).matrix, features_a, features_b)
    spread = 3 * max(noise.spreads)
    off = np.array([[0, 0, x, y] for x in (-spread, 0, spread) for y in (-spread, 0, spread) if (x, y) != (0, 0)])

    assert judge.score(true[None])[0] > 1.2 * judge.score(true + off).max()
    swapped = WallLikelihood(features_b, features_a, features_b.walls, features_a.walls, noise, PARAMS.gain).score(
        invert(true[None])
    )
    assert swapped == pytest.approx(judge.score(true[None]), rel=1e-6)


def test_a_sample_of_the_points_stands_for_all():
    a = extract_features(MapCells.from_values(plans.see(plans.office(0), degrees=10).grid.occupancy), PARAMS.prepare)
    assert a is not None
    walls = np.random.default_rng(0).permutation(a.walls)
    judge = WallLikelihood(a, a, walls, walls, SEARCH_NOISE, PARAMS.gain)
    identity = np.array([[1.0, 0.0, 0.0, 0.0]])

    assert judge.score(identity, most_points=300) == pytest.approx(judge.score(identity), rel=0.05)


def in_working_cells(pixels, features_a, features_b):
    """Turn a matrix between pixels into a placement between working grids."""
    linear = pixels[:, :2] * features_b.factor / features_a.factor
    shift = pixels[:, 2] / features_a.factor + features_a.offset - linear @ features_b.offset
    placement = np.array([linear[0, 0], linear[1, 0], *shift])
    assert math.hypot(*placement[:2]) > 0
    return placement
