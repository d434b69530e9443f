import math

import numpy as np
import pytest

from rectmerge.analysis.distance_codes import BINS, IN_UNKNOWN, ON_BORDER
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.robust.features import extract_features
from rectmerge.robust.likelihood import WallNoise, face_gains
from rectmerge.robust.params import Params
from tests.rectmerge.robust import plans

PARAMS = Params()
LONG_CELLS = PARAMS.faces.min_run_cells
OFFSET = -6.0  # of the working grid of `room`: its margin of 4 less 10 cells
RIGHT, DOWN, LEFT, UP = range(4)


def room(width=120, height=80):
    """A room with walls all round, one cell thick, unknown outside, and a thing of 8 x 8 cells in it."""
    cells = np.full((height, width), -1, np.int8)
    cells[10 : height - 10, 10 : width - 10] = 100
    cells[11 : height - 11, 11 : width - 11] = 0
    cells[30:38, 40:48] = 100
    return extract_features(MapCells.from_values(cells), PARAMS.prepare)


def at(sides, u, v):
    """Row of the wall point nearest to a pixel of `room`, whose margin of the working grid is 4 less 10 cells."""
    return int(np.argmin(np.hypot(*(sides.walls - OFFSET - [u, v]).T)))


def test_walls_face_the_room_and_things_face_out():
    sides = room().faces(0.0, PARAMS.faces)

    assert sides.faces[at(sides, 10, 50)].tolist() == [True, False, False, False]
    assert sides.faces[at(sides, 60, 10)].tolist() == [False, True, False, False]
    assert sides.faces[at(sides, 109, 50)].tolist() == [False, False, True, False]
    assert sides.faces[at(sides, 60, 69)].tolist() == [False, False, False, True]
    assert sides.faces[at(sides, 47, 34), RIGHT]
    assert not sides.faces[at(sides, 47, 34), LEFT]


def test_ways_turn_with_the_angle():
    upright, turned = room().faces(0.0, PARAMS.faces), room().faces(math.pi / 2, PARAMS.faces)

    np.testing.assert_array_equal(turned.faces, np.roll(upright.faces, -1, axis=1))
    np.testing.assert_array_equal(turned.codes, np.roll(upright.codes, -1, axis=0))


def test_long_runs_are_walls_and_short_ones_things():
    sides = room().faces(0.0, PARAMS.faces)

    assert sides.is_long[at(sides, 10, 50), RIGHT]
    assert not sides.is_long[at(sides, 47, 34), RIGHT]
    assert not (sides.is_long & ~sides.faces).any()


@pytest.mark.parametrize("length", [LONG_CELLS - 3, LONG_CELLS + 3])
def test_a_run_is_long_from_a_length_on(length):
    sides = room(height=int(length) + 21).faces(0.0, PARAMS.faces)

    assert sides.is_long[sides.faces[:, RIGHT] & (sides.walls[:, 0] < 10), RIGHT].any() == (length >= LONG_CELLS)


def test_a_distance_is_to_the_next_wall_that_faces_the_way():
    sides = room().faces(0.0, PARAMS.faces)
    u, v = np.rint(sides.walls[at(sides, 10, 50)]).astype(int)

    assert sides.codes[RIGHT, v, u + 6] == 12  # half cells
    assert sides.codes[LEFT, v, u + 6] == BINS - 1
    assert (sides.codes[:, 0] == ON_BORDER).all()


def test_where_the_map_is_not_free_a_wall_contradicts_nothing():
    sides = room().faces(0.0, PARAMS.faces)
    gains = face_gains(sides, WallNoise((1.0,), 0.03), PARAMS.gain)
    behind = sides.codes[RIGHT, 40, 1]

    assert behind >= IN_UNKNOWN
    assert gains[RIGHT, behind] == 0
    assert gains[RIGHT, 0] > 1
    assert gains[RIGHT, BINS - 1] < -1


def test_a_map_whose_walls_face_one_way_only_has_gains_all_the_same():
    cells = np.full((60, 60), -1, np.int8)
    cells[20, 10:50] = 100
    cells[21:50, 10:50] = 0
    sides = extract_features(MapCells.from_values(cells), PARAMS.prepare).faces(0.0, PARAMS.faces)

    assert not sides.faces[:, [RIGHT, LEFT, UP]].any()
    assert np.isfinite(face_gains(sides, WallNoise((1.0,), 0.03), PARAMS.gain)).all()


def test_an_office_has_walls_that_face_every_way():
    view = plans.see(plans.office(0), degrees=20, noise=1)
    sides = extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare).faces(
        math.radians(-20) % (math.pi / 2), PARAMS.faces
    )

    assert (sides.faces.sum(axis=0) > 100).all()
    assert (sides.is_long.sum(axis=0) > 100).all()
