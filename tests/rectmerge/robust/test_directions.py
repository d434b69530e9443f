import math

import numpy as np
import pytest

from rectmerge.analysis.trinary_map import MapCells
from rectmerge.robust.correlation_params import AllRoundParams
from rectmerge.robust.directions import direction_energies, dominant_angles, meeting_turns
from rectmerge.robust.features import extract_features
from rectmerge.robust.params import Params
from tests.rectmerge.robust import plans

PARAMS = Params()
TURNS = np.radians(np.arange(0.0, 90.0, 6.0))


def energies_of(rooms, degrees):
    features = extract_features(MapCells.from_values(plans.see(rooms, degrees=degrees).grid.occupancy), PARAMS.prepare)
    assert features is not None
    return direction_energies(features, PARAMS.prepare)


@pytest.mark.parametrize("degrees", [0, 7.3, 31, 44.5, 60, 88])
def test_the_dominant_angle_is_the_one_the_building_was_turned_by(degrees):
    features = extract_features(
        MapCells.from_values(plans.see(plans.office(1), degrees=degrees, noise=1).grid.occupancy), PARAMS.prepare
    )

    assert features is not None
    angle = math.degrees(dominant_angles(features, PARAMS.prepare)[0][0])
    assert abs((angle + degrees + 45) % 90 - 45) < 0.3


def test_two_wings_at_an_angle_have_two_dominant_angles():
    features = extract_features(
        MapCells.from_values(plans.see(plans.two_wings(0), degrees=10).grid.occupancy), PARAMS.prepare
    )

    assert features is not None
    (first, strong), (second, weaker), *rest = dominant_angles(features, PARAMS.prepare)
    assert sorted(math.degrees(angle) % 90 for angle in (first, second)) == pytest.approx([20, 80], abs=0.5)
    assert weaker >= 0.5 * strong
    assert all(contrast < 0.5 * strong for _, contrast in rest)


def test_there_is_always_a_dominant_angle():
    features = extract_features(MapCells.from_values(np.array([[0, 100]], np.int8)), PARAMS.prepare)

    assert features is not None
    assert len(dominant_angles(features, PARAMS.prepare)) == 1


def test_only_turns_that_lay_walls_along_walls_are_kept():
    kept = meeting_turns(energies_of(plans.office(1), 10), energies_of(plans.office(2), 40), TURNS, AllRoundParams())

    assert 30 in np.rint(np.degrees(kept))
    assert np.abs(np.degrees(kept) - 30).max() < 15


def test_of_two_wings_every_wing_may_meet_every_other():
    kept = meeting_turns(
        energies_of(plans.two_wings(0), 0), energies_of(plans.two_wings(1), 0), TURNS, AllRoundParams()
    )

    assert {0, 30, 60} <= set(np.rint(np.degrees(kept)).astype(int))


def test_where_walls_pile_up_nowhere_no_turn_is_ruled_out():
    flat = np.full(90, 7.0)

    assert meeting_turns(flat, energies_of(plans.office(1), 10), TURNS, AllRoundParams()) is TURNS
