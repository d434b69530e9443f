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

placements = st.builds(
    Similarity, st.floats(0.4, 2.5), st.floats(-math.pi, math.pi), st.floats(-150, 150), st.floats(-150, 150)
)


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


def reached_from_corner(passable: np.ndarray) -> np.ndarray:
    """Return what a flood from the corner reaches, moving to the four neighbours."""
    image = passable.astype(np.uint8)
    cv2.floodFill(image, None, (0, 0), 2, flags=4)
    return image == 2
