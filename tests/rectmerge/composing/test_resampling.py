import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.composing.resampling import resample
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from tests import drawing

INSIDE, OUTSIDE, WALL = 0, 10, 100  # both are free, and can be told apart
placements = st.builds(
    Similarity, st.floats(0.25, 4.0), st.floats(-math.pi, math.pi), st.floats(-3, 3), st.floats(-3, 3)
)
round_numbers = st.builds(
    lambda scale, degrees, u, v: Similarity(scale, math.radians(degrees), u, v),
    st.sampled_from([0.25, 0.5, 0.75, 1.0, 1.25, 1.4, 2.0, 4.0]),
    st.sampled_from([0, 1, 30, 45, 60, 89, 90, 135, 180, 225]),
    st.sampled_from([0.0, 0.25, 0.5]),
    st.sampled_from([0.0, 0.25, 0.5]),
)


def ring_around(inside: np.ndarray) -> OccupancyGrid:
    """Wall in a region by the cells beside it: one cell thick, neighbours by side or by corner alone."""
    around = cv2.dilate(inside.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))) > 0
    return OccupancyGrid(np.where(inside, INSIDE, np.where(around, WALL, OUTSIDE)).astype(np.int8))


def leaks(layer: np.ndarray) -> bool:
    """Tell whether a path of neighbours by side leads from the inside to the outside without touching a wall."""
    _, places = cv2.connectedComponents((layer != WALL).astype(np.uint8), connectivity=4)
    return bool(np.intersect1d(places[layer == INSIDE], places[layer == OUTSIDE]).size)


@st.composite
def rooms(draw):
    inside = np.zeros((44, 50), np.bool_)
    top, left, height, width = (draw(st.integers(4, 18)) for _ in range(4))
    inside[top : top + height, left : left + width] = True
    return ring_around(inside)


@st.composite
def caves(draw):
    inside = np.zeros((40, 44), np.uint8)
    for _ in range(draw(st.integers(1, 6))):
        at = draw(st.integers(9, 34)), draw(st.integers(9, 30))
        cv2.circle(inside, at, draw(st.integers(0, 6)), 1, cv2.FILLED)
    inside |= (np.random.default_rng(draw(st.integers(0, 99))).random(inside.shape) < 0.02) & (inside == 0)
    return ring_around(np.pad(inside[2:-2, 2:-2] > 0, 2))


@settings(max_examples=150, deadline=None)
@given(rooms() | caves(), placements | round_numbers)
def test_no_closed_wall_of_one_cell_leaks(ring, pixels):
    (layer,), _ = resample([ring], [pixels])

    assert not leaks(layer)


@settings(max_examples=50, deadline=None)
@given(rooms() | caves(), placements | round_numbers)
def test_walls_are_not_thickened_noticeably(ring, pixels):
    (layer,), _ = resample([ring], [pixels])

    length = ring.occupied.sum() * pixels.scale  # lattice cells along the wall, where it runs along the axes
    assert (layer == WALL).sum() <= 1.5 * length * max(1.0, pixels.scale) + 10


@pytest.mark.parametrize("turn", [0.0, 0.5, 1.0, 1.5])
@pytest.mark.parametrize("shift", [(0.5, 0.0), (0.0, 0.5), (0.5, 0.5), (-0.5, 1.5)])
def test_a_wall_midway_between_cells_stays_one_cell_thick(turn, shift):
    cells = np.zeros((21, 31), np.int8)
    cells[5:16, 7] = cells[5:16, 20] = cells[5, 7:21] = cells[15, 7:21] = WALL
    grid = OccupancyGrid(cells)

    (layer,), _ = resample([grid], [Similarity(1.0, turn * np.pi, *shift)])

    assert (layer == WALL).sum() == grid.occupied.sum()


@pytest.mark.parametrize("scale", [1.0, 1.7, 3.0])
@pytest.mark.parametrize("angle", [0.0, 0.4, math.pi / 4])
def test_a_straight_wall_keeps_its_area_on_a_finer_lattice(scale, angle):
    inside = np.zeros((100, 120), np.bool_)
    inside[5:95, 5:115] = True
    ring = ring_around(inside)

    (layer,), _ = resample([ring], [Similarity(scale, angle)])

    most = 1.45 if scale == 1 else 1.2  # every wall cell is kept, though two may lie beside one lattice cell
    assert 0.8 <= (layer == WALL).sum() / (ring.occupied.sum() * scale**2) <= most


@pytest.mark.parametrize("scale", [1.0, 1.5, 2.0, 3.3])
def test_a_coarser_map_leaves_no_holes(scale):
    (layer,), _ = resample([OccupancyGrid(np.zeros((30, 30), np.int8))], [Similarity(scale)])

    known = layer == 0
    rows, cols = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    assert known[rows[0] : rows[-1] + 1, cols[0] : cols[-1] + 1].all()
    assert known.sum() == pytest.approx((30 * scale) ** 2, rel=0.1)


@pytest.mark.parametrize("quarters", range(4))
def test_whole_quarters_and_whole_cells_change_no_cell(quarters):
    cells = np.random.default_rng(0).choice([-1, 0, 40, 100], (30, 40)).astype(np.int8)
    cells[0, 0] = cells[-1, -1] = 0

    (layer,), _ = resample([OccupancyGrid(cells)], [Similarity(1.0, quarters * math.pi / 2, 3.0, -8.0)])

    assert (layer == np.rot90(cells, -quarters)).all()


def test_a_side_too_long_to_be_read_is_refused():
    with pytest.raises(InputError, match="a side of a map"):
        resample([drawing.building(), OccupancyGrid(np.zeros((1, 32_767), np.int8))], [Similarity()] * 2)


def test_a_lattice_of_cells_larger_than_the_map_has_one_cell():
    (layer,), _ = resample([OccupancyGrid(np.zeros((3, 3), np.int8))], [Similarity(1e-9)])

    assert layer.shape == (1, 1)


@given(st.integers(-9, 9), st.integers(-9, 9))
def test_a_map_moved_by_whole_cells_keeps_its_cells_and_is_unknown_around(u, v):
    a, b = OccupancyGrid(np.zeros((4, 5), np.int8)), ring_around(np.pad(np.ones((2, 3), np.bool_), 1))

    (_, layer), (row, col) = resample([a, b], [Similarity(), Similarity(tx=float(u), ty=float(v))])

    expected = np.full(layer.shape, -1, np.int8)
    expected[row + v :, col + u :][: b.shape[0], : b.shape[1]] = b.occupancy
    assert np.array_equal(layer, expected)
