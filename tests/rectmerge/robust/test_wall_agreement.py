import math

import numpy as np
import pytest

from rectmerge._kernels.code_counts import count_codes
from rectmerge.grid import OccupancyGrid
from rectmerge.robust.params import Params
from rectmerge.robust.wall_agreement import AgreementScorer
from tests.rectmerge.robust import naive, plans

PARAMS = Params()
IDENTITY = np.array([[1.0, 0.0, 0.0, 0.0]])


def office(**how):
    return plans.prepared(plans.see(plans.office(3), **how).grid)


def scorer_of(map_a, map_b):
    working, detailed = (map_a.walled, map_b.walled), (map_a.detailed, map_b.detailed)
    return AgreementScorer(working, detailed, (map_a.angles[0][0], map_b.angles[0][0]), PARAMS)


@pytest.mark.parametrize("seed", range(4))
def test_the_fast_count_is_the_slow_one(seed):
    rng = np.random.default_rng(seed)
    ways = (1, 4)[seed % 2]
    codes = rng.integers(0, 100, (ways, 20, 30)).astype(np.uint8)
    points, kinds = rng.uniform(-5, 35, (50, 2)), rng.integers(0, 3, (50, ways)).astype(np.uint8)
    angles = rng.uniform(0, 7, 6)
    placements = np.stack([np.cos(angles), np.sin(angles), *rng.uniform(0, 20, (2, 6))], axis=1)
    quarters = rng.integers(0, 4, 6)
    counts = np.zeros((6, 2, 256), np.int32)

    count_codes(placements, quarters, points, kinds, codes, counts)

    np.testing.assert_array_equal(counts, naive.count_codes(placements, quarters, points, kinds, codes))


def test_a_map_on_itself_meets_all_its_faces():
    features = office(degrees=0)

    weights = scorer_of(features, features).score(IDENTITY)

    assert weights.matched[0] == weights.near[0] == weights.clutter_matched[0] == 1.0
    assert weights.contradicted[0] == weights.clutter_contradicted[0] == weights.violations[0] == 0.0
    assert weights.on_floor[0] == weights.beside[0] == weights.corners_missed[0] == weights.corners_denied[0] == 0.0
    assert weights.overlap[0] == pytest.approx(1.0)
    assert weights.iou[0] == pytest.approx(1.0)
    assert weights.judged[0] > weights.clutter[0] > 0


def test_a_shifted_map_meets_less_and_contradicts_more():
    features = office(degrees=0)

    weights = scorer_of(features, features).score(IDENTITY + np.array([[0, 0, 0, 0], [0, 0, 15.0, 11.0]]))

    assert weights.matched[1] < 0.5 < weights.matched[0]
    assert weights.contradicted[1] > 0.2 > weights.contradicted[0]
    assert weights.violations[1] > 0.1 > weights.violations[0]
    assert weights.on_floor[1] > 0.05
    assert weights.beside[1] > 0.1
    assert weights.corners_missed[1] > 0.1


@pytest.mark.parametrize("quarter", range(4))
def test_weights_do_not_depend_on_how_a_map_is_turned(quarter):
    features = office(degrees=0, noise=1)
    grid = plans.see(plans.office(3), noise=1).grid
    turned = plans.prepared(OccupancyGrid(np.ascontiguousarray(np.rot90(grid.occupancy, quarter))))
    height, width = turned.walled.free.shape
    angle = quarter * math.pi / 2
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    shift = (np.array(features.walled.free.shape[::-1]) - 1) / 2 - turn @ ((np.array([width, height]) - 1) / 2)

    weights = scorer_of(features, turned).score(np.array([[*turn[:, 0], *shift]]))

    assert weights.matched[0] > 0.99
    assert weights.violations[0] < 0.01


def test_what_falls_outside_is_not_judged():
    features = office(degrees=0)

    weights = scorer_of(features, features).score(np.array([[1.0, 0.0, 5000.0, 0.0]]))

    assert (
        weights.judged[0]
        == weights.clutter[0]
        == weights.matched[0]
        == weights.violations[0]
        == weights.overlap[0]
        == 0
    )


def test_swapped_maps_weigh_the_same():
    map_a, map_b = office(degrees=0, noise=1), office(degrees=0, scale=1.4)
    features_a, features_b = map_a.walled, map_b.walled
    scale = features_b.factor / features_a.factor / 1.4
    placement = np.array([[scale, 0.0, *(features_a.offset - scale * features_b.offset)]])
    back = np.array([[1 / scale, 0.0, *(features_b.offset - features_a.offset / scale)]])

    there, here = scorer_of(map_a, map_b).score(placement), scorer_of(map_b, map_a).score(back)

    for name in ("judged", "matched", "contradicted", "violations", "overlap", "iou"):
        assert getattr(there, name)[0] == pytest.approx(getattr(here, name)[0], abs=0.02, rel=0.05)
