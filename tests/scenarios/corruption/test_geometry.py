import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from scenarios.corruption.geometry import bend, kink, resize_cells, stretch, turn_image
from tests.scenarios.corruption.small_map import small_map

turns = st.floats(-180.0, 180.0)
seeds = st.integers(0, 1000)
bends = st.floats(0.0, 10.0)
kinks = st.floats(-45.0, 45.0)
factors = st.floats(0.1, 4.0)


def random_grid(seed: int) -> OccupancyGrid:
    rng = np.random.default_rng(seed)
    return OccupancyGrid(rng.choice([-1, 0, 100], rng.integers(2, 40, 2)).astype(np.int8), 0.05, (3.0, -4.0, 0.7))


def centres(grid: OccupancyGrid) -> np.ndarray:
    """Pixel centres (H, W, 2)."""
    return np.stack(np.indices(grid.shape)[::-1], axis=-1).astype(float)


def values_at(grid: OccupancyGrid, pixels: np.ndarray) -> np.ndarray:
    """The values of the cells nearest to pixels (..., 2), unknown outside."""
    at = np.floor(pixels + 0.5).astype(int)
    padded = np.pad(grid.occupancy, 1, constant_values=UNKNOWN)
    u, v = (np.clip(at[..., k] + 1, 0, padded.shape[1 - k] - 1) for k in (0, 1))
    return padded[v, u]


def is_clear(pixels: np.ndarray) -> np.ndarray:
    """Whether a pixel is not as near to one cell as to the next."""
    return (np.abs(pixels % 1 - 0.5) > 1e-6).all(axis=-1)


@settings(max_examples=40, deadline=None)
@given(st.sampled_from([bend, stretch]), seeds, bends)
def test_every_bent_or_stretched_cell_shows_the_old_cell_that_moved_there(do, seed, strength):
    grid = random_grid(seed)
    bent = do(grid, strength, np.random.default_rng(seed))
    waves, shift = bent.motions
    old = waves.undo(shift.inverse().apply(centres(bent.grid)))

    assert np.allclose(bent.map_points(old), centres(bent.grid), atol=1e-7)
    clear = is_clear(old)
    assert np.array_equal(bent.grid.occupancy[clear], values_at(grid, old)[clear])


@settings(max_examples=40, deadline=None)
@given(st.sampled_from([bend, stretch]), seeds, bends)
def test_what_is_undone_is_where_it_was_and_nothing_leaves_the_image(do, seed, strength):
    grid = random_grid(seed)
    bent = do(grid, strength, np.random.default_rng(seed))
    moved = bent.map_points(centres(grid))
    waves, shift = bent.motions

    assert np.allclose(waves.undo(shift.inverse().apply(moved)), centres(grid), atol=1e-7)
    assert (moved > -0.5).all()
    assert (moved < np.array(bent.grid.shape[::-1]) - 0.5).all()


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(seeds, st.floats(0.5, 10.0))
def test_a_bend_turns_no_wall_by_more_than_it_says_and_some_by_about_that(seed, degrees):
    grid = OccupancyGrid(np.zeros((300, 400), np.int8))
    bent = bend(grid, degrees, np.random.default_rng(seed))
    start, headings = centres(grid)[::20, ::20].reshape(-1, 1, 2), np.linspace(0, math.pi, 36, endpoint=False)
    ahead = 1e-3 * np.stack([np.cos(headings), np.sin(headings)], axis=-1)  # (36, 2)
    step = bent.map_points(start + ahead) - bent.map_points(start)
    turned = np.abs(np.remainder(np.degrees(np.arctan2(step[..., 1], step[..., 0]) - headings) + 90, 180) - 90)

    assert turned.max() < 1.3 * degrees  # where both waves are steep, their shears add up
    assert turned.max() > 0.5 * degrees


@settings(max_examples=40, deadline=None)
@given(seeds, kinks)
def test_a_kink_leaves_one_side_and_turns_the_other_rigidly(seed, degrees):
    grid = random_grid(seed)
    torn = kink(grid, degrees, np.random.default_rng(seed))
    slip, shift = torn.motions
    old = centres(grid)
    beyond, moved = slip.is_beyond(old), shift.inverse().apply(torn.map_points(old))

    assert np.array_equal(moved[~beyond], old[~beyond])
    away, back = (points - slip.about for points in (old[beyond], slip.turn.inverse().apply(moved[beyond])))
    assert np.allclose(away, back)
    assert np.allclose(np.hypot(*away.T), np.hypot(*(moved[beyond] - slip.about).T))
    assert slip.turn.angle == pytest.approx(-math.radians(degrees))


@settings(max_examples=40, deadline=None)
@given(seeds, kinks)
def test_every_cell_of_a_torn_map_shows_the_strongest_of_the_old_cells_that_came_there(seed, degrees):
    grid = random_grid(seed)
    torn = kink(grid, degrees, np.random.default_rng(seed))
    slip, shift = torn.motions
    here = shift.inverse().apply(centres(torn.grid))
    there = slip.turn.inverse().apply(here)
    stayed = np.where(slip.is_beyond(here), UNKNOWN, values_at(grid, here))
    came = np.where(slip.is_beyond(there), values_at(grid, there), UNKNOWN)

    clear = is_clear(there)
    assert np.array_equal(torn.grid.occupancy[clear], np.maximum(stayed, came)[clear])


@settings(max_examples=40, deadline=None)
@given(seeds, factors)
def test_a_resampled_map_lies_over_the_same_floor(seed, factor):
    grid = random_grid(seed)
    done = resize_cells(grid, factor)
    corners = np.array([[-0.5, -0.5], [grid.shape[1] - 0.5, grid.shape[0] - 0.5]])

    assert done.grid.resolution == pytest.approx(0.05 / factor)
    assert np.allclose(done.grid.pixel_to_map(done.map_points(corners)), grid.pixel_to_map(corners))


@settings(max_examples=40, deadline=None)
@given(seeds, st.integers(1, 5))
def test_whole_factors_repeat_cells_and_their_inverses_keep_the_strongest(seed, factor):
    grid = random_grid(seed)
    fine = resize_cells(grid, factor)
    coarse = resize_cells(grid, 1 / factor)

    assert np.array_equal(fine.grid.occupancy, grid.occupancy.repeat(factor, axis=0).repeat(factor, axis=1))
    tall, wide = (-side % factor for side in grid.shape)
    padded = np.pad(grid.occupancy, ((0, tall), (0, wide)), constant_values=UNKNOWN)
    blocks = padded.reshape(padded.shape[0] // factor, factor, padded.shape[1] // factor, factor)
    assert np.array_equal(coarse.grid.occupancy, blocks.max(axis=(1, 3)))


def spotted(at: tuple[int, int]) -> OccupancyGrid:
    """Free space with one occupied spot of 9 x 9 cells about a pixel."""
    cells = np.full((90, 120), FREE, np.int8)
    cells[at[1] - 4 : at[1] + 5, at[0] - 4 : at[0] + 5] = OCCUPIED
    return OccupancyGrid(cells, 0.05, (1.0, 2.0, 0.3))


@settings(max_examples=40, deadline=None)
@given(st.sampled_from([(bend, 6.0), (kink, 8.0), (stretch, 10.0)]), seeds, st.integers(10, 110), st.integers(10, 80))
def test_a_spot_is_found_where_its_middle_moved_and_the_map_frame_stays(kind, seed, u, v):
    do, degrees = kind
    grid = spotted((u, v))
    done = do(grid, degrees, np.random.default_rng(seed))
    around = centres(grid)[v - 4 : v + 5, u - 4 : u + 5]
    if do is kink and len(np.unique(done.motions[0].is_beyond(around))) == 2:
        return  # the spot is torn
    middle = np.argwhere(done.grid.occupied).mean(axis=0)[::-1]

    off_cells = np.hypot(*(middle - done.map_points([u, v])))
    assert off_cells < 0.7  # a square that hardly turned is off by up to half a cell
    shift = done.motions[1]
    assert np.allclose(done.grid.pixel_to_map(shift.apply([u, v])), grid.pixel_to_map([u, v]))


@settings(max_examples=20, deadline=None)
@given(seeds, st.floats(-20.0, 20.0))
def test_a_stretched_map_is_longer_by_the_percentage_one_way_and_as_it_was_the_other(seed, percent):
    done = stretch(random_grid(seed), percent, np.random.default_rng(seed))
    arms = done.map_points([[1.0, 0.0], [0.0, 1.0]]) - done.map_points([[0.0, 0.0]])

    lengths = np.linalg.svd(arms, compute_uv=False)
    assert sorted(lengths) == pytest.approx(sorted([1.0, 1.0 + percent / 100]))


@pytest.mark.parametrize("factor", [0.37, 0.5, 1.6, 3.0])
def test_a_spot_of_a_resampled_map_is_found_where_its_middle_moved(factor):
    done = resize_cells(spotted((50, 40)), factor)

    middle = np.argwhere(done.grid.occupied).mean(axis=0)[::-1]
    assert np.hypot(*(middle - done.map_points([50.0, 40.0]))) < 0.8


@pytest.mark.parametrize("do", [bend, kink])
def test_the_map_frame_stays_where_nothing_moved(do):
    done = do(small_map(), 0.0, np.random.default_rng(0))

    assert (done.grid.resolution, done.grid.shape) == (0.05, (200, 200))
    assert np.allclose(done.grid.origin, small_map().origin)


def test_a_map_without_known_cells_is_not_torn():
    grid = OccupancyGrid(np.full((5, 6), UNKNOWN, np.int8))

    assert kink(grid, 5.0, np.random.default_rng(0)).grid is grid


@pytest.mark.parametrize("quarter", range(-2, 3))
def test_turning_by_quarters_moves_every_cell_exactly(quarter):
    cells = np.random.default_rng(0).choice([-1, 0, 100], (7, 12)).astype(np.int8)
    turned, _ = turn_image(OccupancyGrid(cells), 90.0 * quarter)

    assert np.array_equal(turned.occupancy, np.rot90(cells, quarter))


@settings(max_examples=30, deadline=None)
@given(turns, st.integers(1, 12), st.integers(1, 12), st.none() | st.tuples(st.integers(1, 20), st.integers(1, 20)))
def test_every_turned_cell_is_the_nearest_cell_of_the_old_image(turn, width, height, canvas):
    cells = np.random.default_rng(width).choice([0, 100], (height, width)).astype(np.int8)
    turned, pixels = turn_image(OccupancyGrid(cells), turn, canvas)

    assert canvas is None or turned.shape == canvas[::-1]
    for v, u in np.ndindex(turned.shape):
        x, y = pixels.inverse().apply([u, v])
        if min(abs(x % 1 - 0.5), abs(y % 1 - 0.5)) < 1e-9:
            continue  # as near to one cell as to the next
        col, row = math.floor(x + 0.5), math.floor(y + 0.5)
        inside = 0 <= row < height and 0 <= col < width
        assert turned.occupancy[v, u] == (cells[row, col] if inside else UNKNOWN)


def test_a_grown_canvas_holds_the_whole_image():
    grid = OccupancyGrid(np.zeros((202, 302), dtype=np.int8))
    turned, _ = turn_image(grid, 27.0)

    assert turned.free.sum() == pytest.approx(302 * 202, rel=0.002)
