import math

import pytest
import yaml

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from rectmerge.transfer.points import carry_points

TURNED = Similarity(2.0, math.pi / 2, 10.0, 0.0)  # (x, y) goes to (10 - 2 y, 2 x)
SAVED = """\
waypoints:
  waypoint0:
    pose:
      - 1
      - 2
      - 0.25
    orientation:
      - 1
      - 0
      - 0
      - 1e-06
  waypoint1:
    pose: [0.5, 0, 0]
    orientation: [0.7071067811865476, 0, 0, 0.7071067811865476]
    stop: true
"""


def test_waypoints_as_nav2_saves_them_are_carried_with_their_headings():
    waypoints = yaml.safe_load(carry_points(SAVED, "way.yaml", TURNED))["waypoints"]

    assert list(waypoints) == ["waypoint0", "waypoint1"]
    first, second = waypoints.values()
    assert first["pose"] == [6.0, 2.0, 0.25]
    assert first["orientation"] == pytest.approx([math.sqrt(0.5), 0, 0, math.sqrt(0.5)], abs=1e-6)
    assert second["pose"] == [10.0, 1.0, 0]
    assert second["orientation"] == pytest.approx([0, 0, 0, 1], abs=1e-9)
    assert second["stop"] is True


def test_one_place_that_two_waypoints_share_is_carried_once_for_each():
    text = "waypoints:\n  a: &a {pose: [1, 2, 0], orientation: [1, 0, 0, 0]}\n  b: *a\n"

    waypoints = yaml.safe_load(carry_points(text, "way.yml", TURNED))["waypoints"]

    assert waypoints["a"] == waypoints["b"]
    assert waypoints["a"]["pose"] == [6.0, 2.0, 0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("image: map.pgm\n", "there must be waypoints by name, of each a pose"),
        ("- 1\n", "there must be waypoints by name"),
        ("waypoints: {}\n", "there must be waypoints by name"),
        ("waypoints:\n- pose: [1, 2, 0]\n", "there must be waypoints by name"),
        ("waypoints: {a: 1}\n", "'a' must have a pose and an orientation, got 1"),
        ("waypoints: {a: {pose: [1, 2]}}\n", r"the pose of 'a' must be \[x, y, z\], got \[1, 2\]"),
        ("waypoints: {a: {pose: [1, 2, 0]}}\n", r"the orientation of 'a' must be \[w, x, y, z\], got None"),
        ("waypoints: {a: {pose: [1, two, 0]}}\n", "the pose of 'a': 'two' is not a finite number"),
        ("waypoints: {a: {pose: [1, true, 0]}}\n", "the pose of 'a': True is not a finite number"),
        ("waypoints: {a: {pose: [1, 2, 0], orientation: [0, 0, 0, 0]}}\n", "'a': a quaternion of zeros"),
        ("waypoints: {\n", "while parsing"),
        ("waypoints: !!timestamp x\n", ""),
        ("[" * 9999, ""),
    ],
)
def test_what_are_no_waypoints_is_refused_by_name(text, message):
    with pytest.raises(InputError, match=f"^p.yaml: not nav2's waypoints: {message}"):
        carry_points(text, "p.yaml", TURNED)
