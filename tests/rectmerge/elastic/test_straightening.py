import cv2
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import rectmerge as rm
from rectmerge.elastic.lattice import Displacement
from rectmerge.elastic.straightening import straighten
from rectmerge.elastic.warp import Warp
from rectmerge.grid import UNKNOWN
from tests.rectmerge.composing.test_resampling import INSIDE, OUTSIDE, leaks, ring_around
from tests.rectmerge.elastic.bent_maps import random_displacement
from tests.rectmerge.elastic.test_unbend import bend_of, bent_case

PIXELS = rm.Similarity(0.7, 0.4, 12.0, -5.0)


@settings(max_examples=40)
@given(st.integers(0, 999), st.integers(6, 25), st.integers(6, 25), st.floats(0, 1.2))
def test_no_closed_wall_of_one_cell_leaks(seed, height, width, size):
    inside = np.zeros((44, 50), np.bool_)
    inside[8 : 8 + height, 10 : 10 + width] = True
    inside |= cv2.circle(np.zeros((44, 50), np.uint8), (25, 20), 11, 1, cv2.FILLED) > 0
    bend = random_displacement(seed, (60, 60), spacing=15, size=size)

    assert not leaks(straighten(ring_around(inside), Warp(rm.Similarity(), bend)).occupancy)


def test_without_a_bend_the_map_is_the_same():
    b = ring_around(np.pad(np.ones((9, 12), np.bool_), 3))
    none = Displacement.none(random_displacement(0, b.shape, spacing=5, size=1).lattice)

    assert (straighten(b, Warp(PIXELS, none)).occupancy == b.occupancy).all()


def test_a_larger_canvas_keeps_the_map_frame():
    b = rm.OccupancyGrid(np.full((20, 30), 0, np.int8), 0.1, (2.0, -1.0, 0.3))
    lattice = random_displacement(0, (20, 30), spacing=10, size=1).lattice
    shifted = Displacement(lattice, np.tile([-7.0, 4.0], (lattice.node_count, 1)))

    straight = straighten(b, Warp(rm.Similarity(), shifted))

    assert straight.shape == (24, 37)
    assert np.abs(straight.pixel_to_map([7.0, 0.0]) - b.pixel_to_map([0.0, 0.0])).max() < 1e-9
    assert (straight.occupancy[4:, :30] == 0).all()
    assert (straight.occupancy[:4] == UNKNOWN).all()


def test_the_similarity_alone_lays_a_straightened_map_on_a():
    a, b, *_ = bent_case(2)
    bend = bend_of(2)

    before = rm.compose([a, b], [None, bend.b_to_a])
    after = rm.compose([a, bend.straighten(b)], [None, bend.b_to_a])

    assert after.conflict.sum() < 0.4 * before.conflict.sum()


def test_a_map_of_nothing_stays_as_it_is():
    b = rm.OccupancyGrid(np.full((5, 6), UNKNOWN, np.int8))
    bend = random_displacement(0, b.shape, spacing=5, size=1)

    assert straighten(b, Warp(PIXELS, bend)) is b


def test_inside_and_outside_keep_their_values():
    ring = ring_around(np.pad(np.ones((20, 20), np.bool_), 8))
    bend = random_displacement(4, ring.shape, spacing=20, size=1.0)

    straight = straighten(ring, Warp(PIXELS, bend)).occupancy

    assert {INSIDE, OUTSIDE, 100} <= set(np.unique(straight))
