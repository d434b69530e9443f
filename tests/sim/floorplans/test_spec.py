import math
from dataclasses import asdict

import pytest

from rectmerge.errors import InputError
from sim.floorplans import FAMILIES, Hall, Hospital, Office, WorldSpec


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({"size_m": (20.0, 5.0)}, "size_m must be 6 to 60"),
        ({"size_m": (math.nan, 20.0)}, "size_m must be 6 to 60"),
        ({"size_m": (7.0, 6.5)}, "size_m: .* do not fit"),
        ({"size_m": (9.0, 9.0), "door_m": (2.4, 2.4), "wall_m": (0.4, 0.4)}, "size_m: .* do not fit"),
        ({"furniture": -1.0}, "furniture must be 0 to 5 pieces"),
        ({"wall_m": (0.05, 0.2)}, "wall_m must be two ascending numbers within 0.06 to 0.4"),
        ({"wall_m": (0.2, 0.5)}, "wall_m must be"),
        ({"wall_m": (0.3, 0.2)}, "wall_m must be"),
        ({"door_m": (0.6, 1.0)}, "door_m must be two ascending numbers within 0.7 to 2.4"),
        ({"door_m": (0.9, 2.5)}, "door_m must be"),
        ({"door_m": (0.9,)}, "door_m must be"),
        ({"yaw_deg": "north"}, "yaw_deg must be a number of degrees or"),
        ({"yaw_deg": True}, "yaw_deg must be"),
        ({"yaw_deg": math.inf}, "yaw_deg must be"),
        ({"glass": 1.5}, "glass must be a share"),
        ({"shut": -0.1}, "shut must be a share"),
        ({"changed": math.nan}, "changed must be a share"),
    ],
)
def test_every_family_says_what_is_wrong_with_a_common_knob(family, values, complaint):
    with pytest.raises(InputError, match=complaint):
        FAMILIES[family](**values)


@pytest.mark.parametrize(
    ("family", "values", "complaint"),
    [
        ("office", {"rooms": 5}, "rooms must be 6 to 12"),
        ("office", {"rooms": 12, "size_m": (12.0, 12.0)}, "12 rooms .* do not fit into 12.0 x 12.0"),
        ("office", {"oblique": 1.5}, "oblique must be a share"),
        ("apartment", {"rooms": 9}, "rooms must be 3 to 8"),
        ("apartment", {"hall": 2.0}, "hall must be a share"),
        ("warehouse", {"aisle_m": 1.0}, "aisle_m must be 1.8 to 5.0 m"),
        ("warehouse", {"fill": -1.0}, "fill must be a share"),
        ("loop", {"rooms": 1}, "rooms must be 2 to 16"),
        ("loop", {"core": 5}, "core must be 0 to 4"),
        ("hospital", {"rooms": 7}, "rooms must be even"),
        ("hospital", {"rooms": 16}, "16 rooms .* do not fit"),
        ("hospital", {"jitter_m": 0.7}, "jitter_m must be 0.0 to 0.6 m"),
        ("polygonal", {"rooms": 2}, "rooms must be 3 to 9"),
        ("polygonal", {"oblique": -1.0}, "oblique must be a share"),
        ("two-wing", {"rooms": 3}, "rooms must be 4 to 16"),
        ("two-wing", {"angle_deg": (20.0, 40.0)}, "angle_deg must be two ascending numbers within 25 to 65"),
        ("two-wing", {"angle_deg": (50.0, 40.0)}, "angle_deg must be"),
        ("round", {"rooms": 4}, "rooms must be 5 to 12"),
        ("round", {"rooms": 12}, "12 rooms around a rotunda .* do not fit"),
        ("hall", {"spacing_m": 2.0}, "spacing_m must be 3.0 to 10.0 m"),
        ("hall", {"jitter_m": 2.0}, "jitter_m must be"),
        ("hall", {"missing": 1.1}, "missing must be a share"),
        ("hall", {"side_rooms": 5}, "side_rooms must be 0 to 4"),
        ("clutter", {"rooms": 1}, "rooms must be 2 to 9"),
        ("clutter", {"turned": 1.1}, "turned must be a share"),
    ],
)
def test_a_family_says_what_is_wrong_with_its_own_knobs(family, values, complaint):
    with pytest.raises(InputError, match=complaint):
        FAMILIES[family](**values)


def test_the_family_is_part_of_a_spec_but_not_a_knob():
    assert asdict(Hospital())["family"] == Hospital.family == "hospital"
    with pytest.raises(TypeError, match="family"):
        Office(family="hall")


def test_a_spec_is_a_value():
    assert Hall() == Hall()
    assert Hall(missing=0.2) != Hall()
    assert len({Hall(), Hall(), Office()}) == 2
    assert all(issubclass(kind, WorldSpec) for kind in FAMILIES.values())
