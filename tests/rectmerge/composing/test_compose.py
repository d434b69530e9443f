import itertools
import math

import cv2
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rectmerge.composing.compose import RULES, compose
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.similarity import Similarity
from tests import drawing
from tests.rectmerge.composing.placements import placements, reached_from_corner


def part_of_a(composition, a):
    """Cut A's own cells out of the merged map."""
    row, col = composition.corner
    return composition.grid.occupancy[row : row + a.shape[0], col : col + a.shape[1]]


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("resolution", [None, 0.05])
def test_a_map_composed_with_itself_is_itself(rule, resolution):
    a = drawing.building(resolution=resolution, origin=(-3.0, 7.0, 0.4))

    merged = compose([a, a, a], [None, Similarity(), Similarity()], rule=rule)

    assert (merged.grid.occupied == a.occupied).all()
    assert (merged.grid.free == a.free).all()
    assert merged.grid.origin == pytest.approx(a.origin)
    assert merged.grid.resolution == resolution
    assert not merged.conflict.any()


@settings(max_examples=30, deadline=None)
@given(placements, st.sampled_from(RULES), st.floats(-math.pi, math.pi), st.none() | st.floats(0.02, 0.2))
def test_a_cell_that_only_a_knows_keeps_its_place_and_value(pixels, rule, yaw, resolution):
    a = drawing.building(resolution=resolution, origin=(5.0, -4.0, yaw))
    b = drawing.building(resolution=0.03)

    merged = compose([a, b], [None, pixels_to_map_frame(pixels, a, b)], rule=rule)

    v, u = np.mgrid[: a.shape[0], : a.shape[1]]
    in_b = np.floor(pixels.inverse().apply(np.stack([u, v], axis=-1)) + 0.5).astype(int)
    near_b = (in_b >= -4).all(axis=-1) & (in_b[..., 0] < b.shape[1] + 4) & (in_b[..., 1] < b.shape[0] + 4)
    assert (part_of_a(merged, a) == a.occupancy)[~near_b].all()
    row, col = merged.corner
    waypoint = a.pixel_to_map([10.0, 20.0])
    np.testing.assert_allclose(merged.grid.map_to_pixel(waypoint), [10 + col, 20 + row], atol=1e-6)
    assert merged.grid.origin[2] == yaw
    assert merged.grid.resolution == resolution


@settings(max_examples=30, deadline=None)
@example(Similarity(0.5))  # many centres fall midway between cells
@given(placements)
def test_every_known_cell_of_b_lies_on_the_merged_map(pixels):
    a, b = drawing.building(), drawing.building()

    merged = compose([a, b], [None, pixels_to_map_frame(pixels, a, b)])

    row, col = merged.corner
    walls = pixels.apply(np.argwhere(b.occupied)[:, ::-1]) + np.array([col, row])
    shown = np.zeros(len(walls), np.bool_)
    for tie in itertools.product([0.5 - 1e-8, 0.5 + 1e-8], repeat=2):  # midway, the wall may stand on either side
        u, v = np.floor(walls + tie).astype(int).clip(0).T
        at = v.clip(max=merged.grid.shape[0] - 1), u.clip(max=merged.grid.shape[1] - 1)
        shown |= merged.grid.occupied[at]
    assert shown.all()
    assert (walls > -0.5 - 1e-6).all()
    assert (walls < np.array(merged.grid.shape)[::-1] - 0.5 + 1e-6).all()


def test_the_merged_map_is_no_larger_than_its_known_cells_need():
    round_room = np.full((101, 101), -1, np.int8)
    cv2.circle(round_room, (50, 50), 50, 0, cv2.FILLED)

    merged = compose(
        [OccupancyGrid(np.zeros((3, 3), np.int8)), OccupancyGrid(round_room)], [None, Similarity(angle=0.7)]
    )

    known = merged.grid.occupancy != -1
    rows, cols = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    assert max(rows[0], cols[0]) <= 1  # a cell's corner may reach into a merged cell whose centre it misses
    assert known.shape[0] - rows[-1] <= 2
    assert known.shape[1] - cols[-1] <= 2


def test_the_maps_grow_by_whole_cells_where_b_reaches_out():
    a = OccupancyGrid(np.zeros((10, 10), np.int8), 0.1, (1.0, 2.0, 0.0))

    merged = compose([a, a], [None, Similarity(tx=-0.32, ty=0.5)])

    assert merged.corner == (5, 4)  # B reaches 5 cells up and 3.2 to the left
    assert merged.grid.shape == (15, 14)
    assert merged.grid.origin == pytest.approx((1.0 - 0.4, 2.0, 0.0))


@pytest.mark.parametrize("scale", [0.3, 0.5, 0.77, 1.0])
@pytest.mark.parametrize("angle", [0.0, 0.3, 1.1])
def test_a_thin_wall_of_a_finer_map_stays_whole(scale, angle):
    free = np.zeros((150, 200), np.bool_)
    free[20:130, 20:180] = True
    b = drawing.grid_of(free)
    a = OccupancyGrid(np.full((5, 5), -1, np.int8))

    merged = compose([a, b], [None, Similarity(scale, angle)]).grid

    outside = np.pad(~merged.occupied, 1, constant_values=True)  # flood from outside, through everything but walls
    assert not (reached_from_corner(outside)[1:-1, 1:-1] & merged.free).any()


def test_the_rules_say_what_wins():
    wall, free, unknown = (OccupancyGrid(np.full((1, 1), value, np.int8)) for value in (100, 0, -1))

    def merged(rule, *grids):
        return int(compose(grids, [None] + [Similarity()] * (len(grids) - 1), rule=rule).grid.occupancy[0, 0])

    for first, second in ((wall, free), (free, wall)):
        assert merged("occupied", first, second) == 100
        assert merged("free", first, second) == 0
        assert 65 <= merged("log-odds", first, second) < 100
    assert merged("newest", wall, free) == 0
    assert merged("newest", free, wall) == 100
    assert merged("newest", free, wall, unknown) == 100
    assert merged("log-odds", wall, free, free, free) <= 25  # free space seen three times outweighs one wall
    assert merged("log-odds", wall, wall, free) >= 97
    for rule in RULES:
        assert merged(rule, unknown, wall) == 100
        assert merged(rule, free, unknown) == 0
        assert merged(rule, unknown, unknown) == -1


def test_conflict_marks_walls_on_free_space_and_nothing_near_a_wall():
    free = np.zeros((60, 60), np.bool_)
    free[5:55, 5:55] = True
    a = drawing.grid_of(free)
    with_box = np.array(a.occupancy)
    with_box[20:30, 20:30] = 100
    shifted = Similarity(tx=1.0)

    merged = compose([a, OccupancyGrid(with_box)], [None, Similarity()])

    assert (merged.conflict == (merged.grid.occupied & a.free)).all()
    assert merged.conflict.sum() == 100
    assert not compose([a, a], [None, shifted]).conflict.any()


@pytest.mark.parametrize(
    "b_to_a", [Similarity(1e6), Similarity(1.0, 0.0, 1e9, 0.0), Similarity(1e300, 0.0, 1e300, 0.0)]
)
def test_an_absurd_size_is_refused_before_it_fills_the_memory(b_to_a):
    a = drawing.building(resolution=0.05)

    with pytest.raises(InputError, match="is the scale right"):
        compose([a, a], [None, b_to_a])


@pytest.mark.parametrize(
    ("count", "b_to_as", "rule"),
    [
        (2, [None], "occupied"),
        (0, [], "occupied"),
        (2, [None, None], "occupied"),
        (2, [Similarity()] * 2, "free"),
        (1, [None], "max"),
    ],
)
def test_lists_and_rules_that_cannot_be_are_refused(count, b_to_as, rule):
    with pytest.raises(InputError):
        compose([drawing.building()] * count, b_to_as, rule=rule)


def test_evidence_tells_the_mass_of_conflict_and_the_other_rules_do_not():
    a = drawing.building()

    for rule in RULES:
        mass = compose([a, a], [None, Similarity(tx=4.0)], rule=rule).conflict_mass
        assert (mass is None) == (rule != "evidence")
    merged = compose([a, a], [None, Similarity(tx=4.0)], rule="evidence")
    assert merged.conflict_mass.shape == merged.grid.shape
    assert merged.conflict_mass.dtype == np.float32
    assert (merged.conflict_mass[merged.conflict] > 0.5).all()


def test_one_map_alone_is_kept():
    a = drawing.building(resolution=0.05)

    assert (compose([a], [None]).grid.occupancy == a.occupancy).all()
