import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels, pixels_to_map_frame
from rectmerge.similarity import Similarity

metres = st.floats(-500, 500)
origins = st.tuples(metres, metres, st.floats(-math.pi, math.pi))
resolutions = st.none() | st.floats(0.01, 1.0)
grids = st.builds(
    lambda height, width, resolution, origin: OccupancyGrid(np.zeros((height, width), np.int8), resolution, origin),
    st.integers(1, 60),
    st.integers(1, 60),
    resolutions,
    origins,
)
pixel_similarities = st.builds(
    Similarity, st.floats(0.3, 3), st.floats(-math.pi, math.pi), st.floats(-99, 99), st.floats(-99, 99)
)


@settings(max_examples=50)
@given(grids)
def test_the_origin_is_the_lower_left_corner_of_the_lower_left_pixel(grid):
    height, _ = grid.shape

    np.testing.assert_allclose(grid.pixel_to_map([-0.5, height - 0.5]), grid.origin[:2], atol=1e-9)


@settings(max_examples=50)
@given(grids, st.data())
def test_a_pixel_its_cell_and_its_map_point_agree(grid, data):
    height, width = grid.shape
    row, col = data.draw(st.integers(0, height - 1)), data.draw(st.integers(0, width - 1))
    x0, y0, yaw = grid.origin
    right, up = (col + 0.5) * grid.cell_size, (height - row - 0.5) * grid.cell_size  # from the corner, unturned
    by_hand = [x0 + math.cos(yaw) * right - math.sin(yaw) * up, y0 + math.sin(yaw) * right + math.cos(yaw) * up]

    np.testing.assert_allclose(grid.pixel_to_map([col, row]), by_hand, atol=0.01 * grid.cell_size)
    np.testing.assert_allclose(grid.map_to_pixel(by_hand), [col, row], atol=0.01)


@settings(max_examples=50)
@given(grids, st.floats(-100, 100), st.floats(-100, 100))
def test_map_to_pixel_undoes_pixel_to_map(grid, u, v):
    np.testing.assert_allclose(grid.map_to_pixel(grid.pixel_to_map([u, v])), [u, v], atol=1e-6)


@settings(max_examples=50)
@given(grids, grids, pixel_similarities)
def test_the_two_forms_of_a_placement_are_each_others_inverse(a, b, pixels):
    back = map_frame_to_pixels(pixels_to_map_frame(pixels, a, b), a, b)

    np.testing.assert_allclose(back.matrix, pixels.matrix, rtol=1e-6, atol=1e-4)


@settings(max_examples=50)
@given(grids, grids, pixel_similarities, st.floats(0, 60), st.floats(0, 60))
def test_the_two_forms_of_a_placement_move_a_point_alike(a, b, pixels, u, v):
    by_map = a.map_to_pixel(pixels_to_map_frame(pixels, a, b).apply(b.pixel_to_map([u, v])))

    np.testing.assert_allclose(by_map, pixels.apply([u, v]), atol=1e-3)


@settings(max_examples=50)
@given(grids, pixel_similarities)
def test_a_turn_in_the_map_frame_is_the_opposite_turn_to_the_pixels(grid, pixels):
    b_to_a = pixels_to_map_frame(pixels, grid, grid)

    assert math.remainder(b_to_a.angle + pixels.angle, math.tau) == pytest.approx(0, abs=1e-9)
    assert b_to_a.scale == pytest.approx(pixels.scale)


def test_the_pixel_scale_is_the_ratio_of_resolutions_for_maps_of_one_place():
    a, b = (OccupancyGrid(np.zeros((9, 9), np.int8), resolution) for resolution in (0.05, 0.10))

    assert map_frame_to_pixels(Similarity(), a, b).scale == pytest.approx(2.0)


def test_every_cell_is_free_or_occupied_or_unknown():
    grid = OccupancyGrid(np.arange(-1, 101, dtype=np.int8).reshape(6, 17))

    assert (grid.free.astype(int) + grid.occupied + grid.unknown == 1).all()
    assert grid.unknown[0, 0]
    assert grid.free[0, 1]
    assert grid.occupied[-1, -1]


def test_a_grid_cannot_be_changed_through_the_array_it_was_made_of():
    array = np.zeros((2, 2), np.int8)
    grid = OccupancyGrid(array)
    array[0, 0] = 100

    assert not grid.occupied.any()
    with pytest.raises(ValueError, match="read-only"):
        grid.occupancy[0, 0] = 100


@pytest.mark.parametrize(
    "array", [np.zeros((0, 3)), np.zeros(3), np.zeros((2, 2)), np.full((2, 2), 101), np.full((2, 2), -2)]
)
def test_an_array_that_is_no_occupancy_is_refused(array):
    with pytest.raises(InputError):
        OccupancyGrid(array)


@pytest.mark.parametrize("resolution", [0.0, -0.05, math.nan, math.inf])
def test_a_resolution_that_is_not_positive_and_finite_is_refused(resolution):
    with pytest.raises(InputError, match="resolution"):
        OccupancyGrid(np.zeros((2, 2), np.int8), resolution)


@pytest.mark.parametrize("origin", [(0.0, 0.0), (0.0, math.nan, 0.0), (math.inf, 0.0, 0.0)])
def test_an_origin_that_is_not_three_finite_numbers_is_refused(origin):
    with pytest.raises(InputError, match="origin"):
        OccupancyGrid(np.zeros((2, 2), np.int8), 0.05, origin)
