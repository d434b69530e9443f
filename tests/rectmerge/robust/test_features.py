import dataclasses
import math

import cv2
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from rectmerge._kernels.placements import suppress
from rectmerge._kernels.profiles import profile_energies
from rectmerge._kernels.wall_cells import known_bounds
from rectmerge.analysis.trinary_map import MapCells, trinary
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.robust.features import extract_features, rectangles_in_frame, shrink
from rectmerge.robust.params import Params
from tests import drawing
from tests.rectmerge.robust import naive, plans

PARAMS = Params()
CELLS = arrays(np.int8, array_shapes(min_dims=2, max_dims=2, max_side=12), elements=st.sampled_from([-1, 0, 0, 100]))
ROUND_SPECK = np.pad(np.full((2, 2), 100, np.int8), 2)  # each cell touches all four


def large_view(degrees: float = 0.0) -> plans.PlanView:
    """Draw an office in cells so small that its working grid is twice as coarse."""
    return plans.see(plans.office(3), degrees=degrees, scale=0.4)


def test_known_bounds_frame_what_is_known():
    cells = np.full((9, 12), UNKNOWN, np.int8)
    cells[2, 5] = cells[6, 3] = cells[4, 8] = FREE

    assert known_bounds(cells) == (2, 6, 3, 8)
    assert known_bounds(np.full((9, 12), UNKNOWN, np.int8)) == (9, -1, 12, -1)


@example(ROUND_SPECK, 1.0)
@given(CELLS, st.floats(1, 4))
def test_shrinking_counts_what_a_slow_loop_counts(cells, factor):
    bounds = known_bounds(cells)
    if bounds[1] < 0:
        return

    counted = shrink(MapCells.from_values(cells), bounds, factor)

    for counts, slow_counts in zip(counted[:3], naive.shrunk_counts(cells, bounds, factor), strict=True):
        np.testing.assert_array_equal(counts, slow_counts)


@given(CELLS)
def test_without_shrinking_the_surface_is_summed_where_it_is(cells):
    bounds = known_bounds(cells)
    if bounds[1] < 0:
        return

    _, _, surface, sum_u, sum_v = shrink(MapCells.from_values(cells), bounds, 1.0)

    rows, cols = np.nonzero(surface)
    np.testing.assert_array_equal(sum_u[rows, cols], cols + bounds[2])
    np.testing.assert_array_equal(sum_v[rows, cols], rows + bounds[0])


@given(CELLS)
def test_the_cells_of_a_mirror_image_are_those_of_the_flipped_map(cells):
    mirrored, flipped = (
        MapCells.from_values(cells).mirrored(),
        MapCells.from_values(np.ascontiguousarray(cells[:, ::-1])),
    )

    order, flipped_order = (np.lexsort((each.cols, each.rows)) for each in (mirrored, flipped))
    np.testing.assert_array_equal(mirrored.values, flipped.values)
    for name in ("rows", "cols", "kinds", "normals"):
        np.testing.assert_array_equal(getattr(mirrored, name)[order], getattr(flipped, name)[flipped_order])


def test_a_map_is_read_as_three_values():
    grid = OccupancyGrid(np.array([[-1, 0, 25], [26, 64, 65]], np.int8))

    np.testing.assert_array_equal(trinary(grid), [[-1, 0, 0], [-1, -1, 100]])


@pytest.mark.parametrize("column", [200, 201, 202, 203, 204])
def test_shrinking_keeps_a_wall_where_it_is_to_a_fraction_of_a_cell(column):
    cells = np.zeros((800, 800), np.int8)
    cells[:, column] = OCCUPIED
    cells[[0, -1], :] = OCCUPIED

    features = extract_features(MapCells.from_values(cells), PARAMS.prepare)

    assert features is not None
    assert features.factor > 2
    walls = (features.walls - features.offset) * features.factor
    upright = walls[(walls[:, 1] > 50) & (walls[:, 1] < 750), 0]
    assert len(upright) > 100
    np.testing.assert_allclose(upright, column, atol=1e-9)


def test_pixels_and_working_cells_are_related_by_factor_and_offset():
    view = large_view(20)

    features = extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare)

    assert features is not None
    assert features.factor > 1.8
    rows, cols = np.nonzero(features.free)
    at = np.rint((np.stack([cols, rows], axis=1) - features.offset) * features.factor).astype(int)
    assert view.grid.free[at[:, 1], at[:, 0]].mean() > 0.98


def test_specks_are_removed_and_walls_are_not():
    view = large_view()
    rng = np.random.default_rng(0)
    cells = view.grid.occupancy.copy()
    deep = view.grid.free & (rng.random(cells.shape) < 0.005)
    cells[deep] = OCCUPIED

    clean, salted = (
        extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare),
        extract_features(MapCells.from_values(cells), PARAMS.prepare),
    )

    assert clean is not None
    assert salted is not None
    assert len(salted.walls) < 1.03 * len(clean.walls)
    u, v = np.rint(salted.walls).astype(int).T
    gaps = clean.distance[v, u]  # to the nearest clean wall
    assert (gaps > 1.5).mean() < 0.02


def test_what_is_no_larger_than_a_working_cell_is_a_speck_however_many_cells_of_the_map_it_has():
    building = drawing.building()
    larger = np.kron(building.occupancy, np.ones((20, 20), np.int8))
    free = cv2.erode((larger == FREE).view(np.uint8), np.ones((121, 121), np.uint8)) > 0
    salted = larger.copy()
    for row, col in np.argwhere(free)[::20011]:
        salted[row : row + 7, col : col + 7] = OCCUPIED

    clean, found = (extract_features(MapCells.from_values(each), PARAMS.prepare) for each in (larger, salted))

    assert (salted != larger).any()
    assert clean.factor > 7
    np.testing.assert_array_equal(found.walls, clean.walls)


def test_the_distance_counts_cells_to_the_next_wall():
    features = extract_features(MapCells.from_values(drawing.building().occupancy), PARAMS.prepare)

    assert features is not None
    assert features.factor == 1.0
    cells = np.argwhere(features.free | features.known)[::7]
    wanted = np.array([np.hypot(*(features.walls - cell[::-1]).T).min() for cell in cells])
    measured = features.distance[cells[:, 0], cells[:, 1]]
    np.testing.assert_allclose(measured, wanted, rtol=0.03, atol=0.01)
    assert (features.distance_bins[cells[:, 0], cells[:, 1]][wanted == 0] == 0).all()


@pytest.mark.parametrize("fill", [FREE, OCCUPIED, UNKNOWN])
def test_a_map_of_one_value_has_no_features(fill):
    assert extract_features(MapCells.from_values(np.full((30, 40), fill, np.int8)), PARAMS.prepare) is None


def test_walls_that_border_on_the_unknown_only_are_no_features():
    cells = np.full((30, 40), UNKNOWN, np.int8)
    cells[5, 5:30] = OCCUPIED

    assert extract_features(MapCells.from_values(cells), PARAMS.prepare) is None


@given(
    arrays(np.float64, st.tuples(st.integers(1, 30), st.just(2)), elements=st.floats(-40, 40)),
    st.floats(-4, 4),
    st.floats(0.5, 3),
)
def test_profile_energies_agree_with_a_slow_profile(points, angle, width):
    reach = float(np.hypot(*points.T).max())

    (energy,) = profile_energies(points, np.array([angle]), width)

    assert energy == pytest.approx(naive.profile_energy(points, angle, width, reach / width + 1), rel=1e-4)


@given(
    arrays(np.int32, st.tuples(st.integers(1, 12), st.just(4)), elements=st.integers(1, 6)),
    st.floats(0.1, 0.9),
    st.integers(1, 8),
    st.randoms(use_true_random=False),
)
def test_near_doubles_are_left_out_as_a_slow_loop_does(rectangles, iou, keep, random):
    order = random.sample(range(len(rectangles)), len(rectangles))

    kept = suppress(rectangles, np.array(order, np.int64), iou, keep)

    assert kept.tolist() == naive.suppress(rectangles, order, iou, keep)


@pytest.mark.parametrize("degrees", [0.0, 23.0, 118.0])
def test_the_rooms_of_a_building_are_among_its_rectangles(degrees):
    view = plans.see(plans.office(2), degrees=degrees)
    features = extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare)
    assert features is not None
    boxes = rectangles_in_frame(
        features, math.radians(-degrees), dataclasses.replace(PARAMS.prepare, max_rectangles=200)
    ).boxes
    middles = view.pixels.apply((boxes[:, :2] - features.offset) * features.factor)
    sides = np.sort(boxes[:, 2:], axis=1) * features.factor

    rooms = [room for room in plans.office(2) if min(np.ptp(room, axis=0)) > 20]
    matches = [
        (np.abs(middles - room.mean(axis=0)).max(axis=1) < 3)
        & (np.abs(sides - np.sort(np.ptp(room, axis=0))).max(axis=1) < 5)
        for room in rooms
    ]

    assert len(rooms) > 10
    assert np.mean([any(each) for each in matches]) > 0.9


def test_the_sides_of_a_closed_room_have_walls_and_an_open_end_has_none():
    cells = np.full((60, 90), UNKNOWN, np.int8)
    cells[10:50, 10:70] = FREE
    cells[9, 9:70] = cells[50, 9:70] = cells[9:51, 9] = OCCUPIED  # open to the right
    features = extract_features(MapCells.from_values(cells), PARAMS.prepare)

    assert features is not None
    frame = rectangles_in_frame(features, 0.0, dataclasses.replace(PARAMS.prepare, max_rectangles=10))

    assert frame.has_wall[0].tolist() == [True, False, True, True]
