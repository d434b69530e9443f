import math

import numpy as np
import pytest

from rectmerge.elastic.transform import BentTransform
from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from rectmerge.transfer.trajectory import carry_trajectory
from tests.drawing import building
from tests.rectmerge.elastic.bent_maps import random_displacement

TURNED = Similarity(2.0, math.pi / 2, 10.0, 0.0)  # (x, y) goes to (10 - 2 y, 2 x)


def test_poses_are_carried_and_all_else_stays():
    text = "# by hand\n1305031102.1758 1 2 0.50 0 0 0 1\n\n1305031102.2000 0 0 0 0 0 1 0\n"

    carried = carry_trajectory(text, "b.tum", TURNED)

    half = f"{math.sqrt(0.5):.9g}"
    assert carried.splitlines() == [
        "# by hand",
        f"1305031102.1758 6.000000 2.000000 0.50 0 0 {half} {half}",
        "",
        f"1305031102.2000 10.000000 0.000000 0 0 0 {half} -{half}",
    ]


def test_a_bend_turns_each_pose_by_the_turn_at_its_place(caplog):
    a = building()
    displacement = random_displacement(0, a.shape, spacing=50, size=4)
    bent = BentTransform.from_pixels(TURNED, displacement, np.ones(len(displacement.coefficients)), a)
    places = np.array([[20.0, -30.0], [45.0, -10.0], [4000.0, 0.0]])
    text = "".join(f"{k} {x} {y} 0 0 0 0 1\n" for k, (x, y) in enumerate(places))

    rows = [list(map(float, line.split())) for line in carry_trajectory(text, "b.tum", bent).splitlines()]

    assert np.abs(np.array(rows)[:, 1:3] - bent.apply(places)).max() < 1e-5
    turns = [2 * math.atan2(row[6], row[7]) for row in rows]
    assert np.abs(np.exp(1j * np.array(turns)) - np.exp(1j * bent.local_angle(places))).max() < 1e-6
    assert "poses lie outside the bend" in caplog.text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "b.tum: it holds no poses"),
        ("# nothing\n", "it holds no poses"),
        ("1 2 3\n", "line 1 must be time x y z qx qy qz qw, got '1 2 3'"),
        ("0 1 2 0 0 0 0 1\n1 a 2 0 0 0 0 1\n", "line 2: 'a' is not a finite number"),
        ("nan 1 2 0 0 0 0 1\n", "line 1: 'nan' is not a finite number"),
        ("1 1 2 0 0 0 0 0\n", "line 1: a quaternion of zeros is no heading"),
        ("1 1e400 2 0 0 0 0 1\n", "is not a finite number"),
    ],
)
def test_what_is_no_trajectory_is_refused_by_its_line(text, message):
    with pytest.raises(InputError, match=r"^b\.tum: ") as refused:
        carry_trajectory(text, "b.tum", TURNED)

    assert message in str(refused.value)
