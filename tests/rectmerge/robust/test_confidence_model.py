import numpy as np
import pytest

from rectmerge.robust.confidence_model import (
    RIGID_TERMS,
    bent_handicap,
    bent_odds,
    plausibility,
    rigid_odds,
    rigid_terms,
    surface_exact_odds,
)
from rectmerge.robust.params import ConfidenceParams
from rectmerge.robust.wall_agreement import WallAgreement

PARAMS = ConfidenceParams()
GOOD = WallAgreement(
    judged=np.array([800.0]),
    matched=np.array([0.95]),
    near=np.array([0.98]),
    contradicted=np.array([0.01]),
    clutter=np.array([400.0]),
    clutter_matched=np.array([0.8]),
    clutter_contradicted=np.array([0.05]),
    violations=np.array([0.02]),
    overlap=np.array([0.7]),
    iou=np.array([0.5]),
    on_floor=np.array([0.0]),
    beside=np.array([0.0]),
    corners_missed=np.array([0.05]),
    corners_denied=np.array([0.0]),
)


def test_there_is_a_weight_for_every_term():
    assert rigid_terms(GOOD, PARAMS).shape == (1, len(RIGID_TERMS))
    assert len(PARAMS.rigid) == len(RIGID_TERMS)


def test_walls_that_meet_are_plausible():
    assert rigid_odds(GOOD, PARAMS)[0] > 3


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("matched", 0.2),
        ("clutter_matched", 0.3),
        ("violations", 0.2),
        ("overlap", 0.1),
        ("clutter", 10.0),
        ("on_floor", 0.1),
        ("beside", 0.1),
        ("corners_missed", 0.5),
    ],
)
def test_less_that_speaks_for_it_is_less_plausible_as_rigid_maps(name, value):
    assert rigid_odds(GOOD._replace(**{name: np.array([value])}), PARAMS)[0] < rigid_odds(GOOD, PARAMS)[0] - 0.2


def test_bent_maps_need_support_and_little_that_is_missing():
    support = np.array([0.8])

    assert bent_odds(GOOD, support, PARAMS)[0] > bent_odds(GOOD, 0.2 * support, PARAMS)[0]
    assert (
        bent_odds(GOOD, support, PARAMS)[0]
        > bent_odds(GOOD._replace(violations=np.array([0.2])), support, PARAMS)[0] + 4
    )


def test_walls_that_meet_exactly_speak_against_bent_maps():
    odds = surface_exact_odds(np.array([0.0, 0.3, 0.5, 0.9]), PARAMS)

    assert odds[0] == odds[1] == 0.0
    assert odds[2] > odds[3]
    assert odds[2] < -1.0


def test_bent_maps_count_where_no_rigid_ones_convince():
    bent = np.array([6.0, -5.0])

    assert plausibility(np.array([-9.0, -9.0]), bent)[0] == pytest.approx(6.0, abs=0.01)
    assert plausibility(np.array([-9.0, 8.0]), bent)[0] < 0


def test_maps_with_thin_walls_are_less_likely_bent():
    assert bent_handicap(PARAMS.fat_wall_cells, PARAMS) == bent_handicap(5.0, PARAMS) == 0.0
    assert bent_handicap(1.0, PARAMS) < bent_handicap(2.0, PARAMS) < 0.0
