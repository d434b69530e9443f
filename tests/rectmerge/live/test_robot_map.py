from dataclasses import replace

import numpy as np
import pytest

from rectmerge.grid import UNKNOWN
from rectmerge.live.params import LiveParams
from rectmerge.live.robot_map import RobotMap, changed_share
from tests.rectmerge.live.growing import A, known_part


def in_a_larger_frame(grid, left, top):
    """The same map, with so many unknown columns on its left and rows on its top."""
    occupancy = np.pad(grid.occupancy, ((top, 3), (left, 5)), constant_values=UNKNOWN)
    x, y, yaw = grid.origin
    return replace(grid, occupancy=occupancy, origin=(x - left * grid.cell_size, y - 3 * grid.cell_size, yaw))


def test_a_map_in_a_larger_frame_has_not_changed():
    assert changed_share(A, in_a_larger_frame(A, 7, 11)) == 0.0
    assert changed_share(in_a_larger_frame(A, 7, 11), A) == 0.0


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_new_cells_count_wherever_the_frame_begins(share):
    part = known_part(A, share)
    new = np.count_nonzero(A.occupancy != part.occupancy) / np.count_nonzero(part.free)

    assert changed_share(part, A) == pytest.approx(new)
    assert changed_share(part, in_a_larger_frame(A, 4, 9)) == pytest.approx(new)


@pytest.mark.parametrize(
    "other",
    [replace(A, resolution=0.1), replace(A, origin=(-2.02, -1.5, 0.0)), replace(A, origin=(50.0, 50.0, 0.0))],
    ids=["resolution", "between cells", "elsewhere"],
)
def test_versions_on_other_cells_differ_in_all_of_them(other):
    assert changed_share(A, other) >= 1.0


def test_a_map_is_considered_again_only_where_it_has_changed_enough():
    params = LiveParams(growth=0.5)
    robot = RobotMap(known_part(A, 0.6))

    assert robot.consider(params)
    robot.newest = known_part(A, 0.65)
    assert not robot.consider(params)
    robot.newest = A
    assert robot.consider(params)
    assert robot.version == 2
    assert not robot.has_begun_anew(params)
    robot.newest = known_part(A, 0.2)
    assert robot.has_begun_anew(params)
