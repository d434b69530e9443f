import math
import re

import numpy as np
import pytest

from rectmerge.analysis.shared_area import SharedArea
from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from rectmerge.transfer.transform import Transform

ANSWER = Transform(Similarity(1.02, 0.5, 3.0, -1.0), SharedArea((4.0, 2.0), 1.5), "m")


def parsed(text):
    return [float(word) for word in re.findall(r"-?\d+\.\d+", text)]


def test_a_rigid_transform_keeps_the_middle_of_what_both_show_and_tells_its_misfit():
    centre = [4.0, 2.0]

    assert ANSWER.rigid.apply(centre) == pytest.approx(ANSWER.b_to_a.apply(centre))
    assert ANSWER.rigid.scale == 1.0
    ring = centre + 1.5 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    misses = np.linalg.norm(ANSWER.rigid.apply(ring) - ANSWER.b_to_a.apply(ring), axis=1)
    assert math.sqrt((misses**2).mean()) == pytest.approx(ANSWER.misfit)


def test_no_other_shift_misses_less():
    rng = np.random.default_rng(1)
    ring = [4.0, 2.0] + 1.5 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])

    def miss(rigid):
        return ((rigid.apply(ring) - ANSWER.b_to_a.apply(ring)) ** 2).sum()

    for step in rng.normal(0, 0.02, (50, 3)):
        other = Similarity(1.0, ANSWER.rigid.angle + step[0], ANSWER.rigid.tx + step[1], ANSWER.rigid.ty + step[2])
        assert miss(other) >= miss(ANSWER.rigid)


def test_the_forms_name_parent_and_child_and_carry_the_same_transform():
    ros1 = ANSWER.format("ros1", parent="world", child="robot")
    ros2 = ANSWER.format("ros2", parent="world", child="robot")

    assert ros1.endswith(" world robot")
    assert "--frame-id world --child-frame-id robot" in ros2
    assert (
        parsed(ros1)
        == parsed(ros2)
        == parsed(ANSWER.format("pose"))
        == pytest.approx([ANSWER.rigid.tx, ANSWER.rigid.ty, 0.5], abs=1e-6)
    )
    matrix = np.array([line.split() for line in ANSWER.format("matrix").splitlines()], float)
    assert matrix[:2] == pytest.approx(ANSWER.b_to_a.matrix)


@pytest.mark.parametrize(("scale", "is_small"), [(1 / 1.16, False), (1 / 1.14, True), (1.14, True), (1.16, False)])
def test_fifteen_percent_of_scale_may_be_left_out(scale, is_small):
    placed = Transform(Similarity(scale), ANSWER.shared, "m")

    assert (placed.scale_fault == "") == is_small
    if not is_small:
        with pytest.raises(InputError, match="one resolution is wrong; merge again"):
            placed.format("pose")


def test_a_pose_of_maps_in_cells_is_refused_with_their_remedy():
    placed = Transform(Similarity(0.06), SharedArea((4.0, 2.0), 1.5, "cells"), "m")

    with pytest.raises(InputError, match=r"scale of 0\.06: map B is in cells, .* --resolution-b METRES"):
        placed.format("pose")
