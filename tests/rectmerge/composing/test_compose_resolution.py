"""Cells of the merged map of another size than those of A."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.composing.compose import compose
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.similarity import Similarity
from tests import drawing
from tests.rectmerge.composing.placements import placements, reached_from_corner

resolutions = st.sampled_from(["a", "b", "finer"]) | st.floats(0.02, 0.3)
frames = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-math.pi, math.pi))


def spotted(at, resolution, origin):
    """Draw free space with a single wall cell at (u, v)."""
    occupancy = np.zeros((30, 40), np.int8)
    occupancy[at[1], at[0]] = 100
    return OccupancyGrid(occupancy, resolution, origin)


@settings(max_examples=100, deadline=None)
@given(placements, resolutions, frames, frames, st.floats(0.04, 0.2), st.floats(0.04, 0.2), st.booleans())
def test_a_point_of_the_world_survives_to_half_a_cell(pixels, resolution, frame_a, frame_b, size_a, size_b, stated):
    a = spotted((11, 23), size_a if stated else None, frame_a)
    b = spotted((31, 7), size_b, frame_b)
    b_to_a = pixels_to_map_frame(pixels, a, b)
    wanted = resolution if stated or isinstance(resolution, str) else 10 * resolution

    merged = compose([a, b], [None, b_to_a], resolution=wanted).grid

    assert merged.origin[2] == a.origin[2]
    for point in (a.pixel_to_map([11, 23]), b_to_a.apply(b.pixel_to_map([31, 7]))):
        u, v = merged.map_to_pixel(point)
        cells = {(int(np.rint(v + e)), int(np.rint(u + f))) for e in (-1e-6, 1e-6) for f in (-1e-6, 1e-6)}
        assert any(merged.occupied[cell] for cell in cells)


@pytest.mark.parametrize(
    ("resolution", "size"), [("a", 0.05), ("b", 0.06), ("finer", 0.025), (0.1, 0.1), (np.float32(0.5), 0.5)]
)
def test_the_cells_of_the_merged_map_are_as_large_as_asked_for(resolution, size):
    a = drawing.building(resolution=0.05, origin=(1.0, 2.0, 0.3))
    b, c = drawing.building(resolution=0.06), drawing.building(resolution=0.025)

    merged = compose([a, b, c], [None, Similarity(1.1), Similarity()], resolution=resolution).grid

    assert merged.resolution == pytest.approx(size)


def test_without_a_resolution_cells_are_as_large_as_the_placement_makes_them():
    a, b = drawing.building(), drawing.building(resolution=0.05)

    for resolution, scale in (("b", 2.5), ("finer", 0.4), (0.25, 0.4)):
        merged = compose([a, b], [None, Similarity(scale / 0.05)], resolution=resolution).grid
        assert merged.resolution == pytest.approx(0.25 if resolution == 0.25 else scale)
    kept = compose([a, b], [None, Similarity(2.5 / 0.05)], resolution="finer").grid
    assert kept.resolution is None  # A's cells are the finest


def test_a_map_that_does_not_grow_keeps_its_origin_at_every_resolution():
    a = drawing.building(resolution=0.05, origin=(1.0, 2.0, 0.3))

    for size in (0.013, 0.05, 0.11, 3.0, 100.0):
        merged = compose([a, a], [None, Similarity()], resolution=size)
        assert merged.grid.origin == pytest.approx(a.origin)
        assert merged.corner == (0, 0)
        assert merged.grid.shape == tuple(math.ceil(cells * 0.05 / size - 1e-6) for cells in a.shape)


@pytest.mark.parametrize("resolution", [0.01, 0.03, 0.08, 0.2])
def test_a_closed_wall_of_either_map_stays_closed_at_every_resolution(resolution):
    free = np.zeros((60, 70), np.bool_)
    cv2.circle(free.view(np.uint8), (35, 30), 25, 1, cv2.FILLED)
    a, b = drawing.grid_of(free, resolution=0.05), drawing.grid_of(free, resolution=0.05)

    merged = compose([a, b], [None, Similarity(1.0, 0.6, 6.0, 0.0)], resolution=resolution).grid

    outside = np.pad(~merged.occupied, 1, constant_values=True)
    assert not (reached_from_corner(outside)[1:-1, 1:-1] & merged.free).any()


@pytest.mark.parametrize("resolution", [0.0, -1.0, math.nan, math.inf, "c", "0.05"])
def test_a_resolution_that_cannot_be_is_refused(resolution):
    with pytest.raises(InputError, match="resolution"):
        compose([drawing.building()] * 2, [None, Similarity()], resolution=resolution)


def test_the_resolution_of_a_second_map_needs_one():
    with pytest.raises(InputError, match="only one"):
        compose([drawing.building()], [None], resolution="b")


def test_an_absurd_resolution_is_refused_before_it_fills_the_memory():
    a = drawing.building(resolution=0.05)

    with pytest.raises(InputError, match="resolution"):
        compose([a, a], [None, Similarity()], resolution=1e-9)


def test_conflict_reaches_two_cells_of_a_at_every_resolution():
    free = np.zeros((60, 60), np.bool_)
    free[5:55, 5:55] = True
    a = drawing.grid_of(free, resolution=0.1)

    for size in (0.025, 0.1):
        assert not compose([a, a], [None, Similarity(tx=0.2)], resolution=size).conflict.any()
        assert compose([a, a], [None, Similarity(tx=0.4)], resolution=size).conflict.any()
