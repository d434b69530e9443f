import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge._kernels.fitting import inverse, nearest_facing, set_equations, slopes, solve, stepped
from rectmerge._kernels.placements import invert
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.robust.features import extract_features
from rectmerge.robust.params import Params
from rectmerge.robust.refinement import (
    Fit,
    Surface,
    fit_surfaces,
    refine,
    to_pixels,
)
from rectmerge.similarity import Similarity
from tests import naive
from tests.rectmerge.robust import plans
from tests.rectmerge.robust.plans import as_placement, as_similarity

PARAMS = Params()
EXACT = PARAMS.exact
NUMBERS = st.floats(-50, 50)
TURNS = st.floats(-math.pi, math.pi)
SCALES = st.floats(0.4, 2.5)


def nudged(
    similarity: Similarity, turn: float, grow: float, shift: tuple[float, float], about: np.ndarray
) -> Similarity:
    """Turn and grow about a point (of the source), then shift."""
    at = similarity.apply(about)
    linear = Similarity(math.exp(grow), turn)
    tx, ty = at - linear.apply(at) + shift
    return Similarity(linear.scale, linear.angle, float(tx), float(ty)) @ similarity


def views(
    noise: int = 0, *, seed: int = 0, walls: tuple[int, int] = (1, 1), scale: float = 1.25
) -> tuple[plans.PlanView, plans.PlanView]:
    rooms = plans.office(seed)
    a = plans.see(rooms, degrees=17, window=(-8, -8, 250, 236), wall_cells=walls[0], noise=noise, seed=1)
    b = plans.see(rooms, degrees=141, scale=scale, window=(60, -8, 248, 236), wall_cells=walls[1], noise=noise, seed=2)
    return a, b


@given(
    st.lists(st.lists(NUMBERS, min_size=4, max_size=4), min_size=4, max_size=4),
    st.lists(NUMBERS, min_size=4, max_size=4),
)
def test_elimination_solves_what_numpy_solves(rows, right):
    matrix = np.array(rows)
    if np.linalg.cond(matrix) > 1e8:
        return

    np.testing.assert_allclose(matrix @ solve(matrix, np.array(right)), right, atol=1e-5)
    assert np.isfinite(solve(np.zeros((4, 4)), np.array(right))).all()  # singular: numbers, not an error


@given(SCALES, TURNS, NUMBERS, NUMBERS, NUMBERS, NUMBERS)
def test_an_inverse_takes_points_back(scale, turn, tx, ty, x, y):
    placement = as_placement(Similarity(scale, turn, tx, ty))
    back = np.array(inverse(tuple(placement.tolist())))

    there = naive.move(placement, np.array([[x, y]]))

    assert naive.move(back, there)[0] == pytest.approx((x, y), abs=1e-9)
    assert back == pytest.approx(invert(placement[None])[0])


@pytest.mark.parametrize("backward", [False, True])
@given(SCALES, TURNS, NUMBERS, NUMBERS, NUMBERS, NUMBERS, TURNS)
def test_slopes_are_the_numerical_derivatives(backward, scale, turn, tx, ty, x, y, facing):
    placement = as_placement(Similarity(scale, turn, tx, ty))
    gx, gy = math.cos(facing), math.sin(facing)

    def way(step: np.ndarray) -> tuple[float, float, float, float]:
        there = stepped(tuple(placement.tolist()), -step, 1.0, (1e-9, 1e9))
        return inverse(there) if backward else there

    def residual(step: np.ndarray) -> float:
        return float(naive.move(np.array(way(step)), np.array([[x, y]]))[0] @ [gx, gy])

    here = way(np.zeros(4))
    found = slopes(here, *naive.move(np.array(here), np.array([[x, y]]))[0], gx, gy, backward)

    steps = 1e-5 * np.eye(4)
    wanted = [(residual(step) - residual(-step)) / 2e-5 for step in steps]
    np.testing.assert_allclose(found, wanted, atol=1e-4)


@given(st.lists(st.floats(-9, 9), min_size=4, max_size=4), st.floats(0.1, 5))
def test_a_step_keeps_to_its_limits(step, longest):
    a, b, tx, ty = stepped((1.0, 0.0, 3.0, 4.0), np.array(step), longest, (0.95, 1.02))

    assert 0.95 - 1e-9 <= math.hypot(a, b) <= 1.02 + 1e-9
    assert abs(math.atan2(b, a)) <= 0.1 + 1e-9
    assert max(abs(tx - 3), abs(ty - 4)) <= longest + 1e-9


def test_the_surface_is_where_walls_face_free_space():
    cells = np.full((12, 20), -1, np.int8)
    cells[2:10, 2:10] = 0
    cells[2:10, 10:13] = 100  # three cells thick, the unknown behind

    surface = Surface.from_cells(MapCells.from_values(cells)).cells

    assert set(surface[:, 0]) == {10.0}
    assert sorted(surface[:, 1]) == list(range(2, 10))
    np.testing.assert_allclose(surface[2:-2, 2:], [[-1.0, 0.0]] * 4)


def test_a_wall_free_on_both_sides_faces_nowhere_but_at_its_ends():
    cells = np.zeros((9, 9), np.int8)
    cells[:, 4] = 100

    assert set(Surface.from_cells(MapCells.from_values(cells)).cells[:, 1]) == {0.0, 1.0, 7.0, 8.0}


@settings(max_examples=25)
@given(st.floats(0, 95), st.floats(0, 95), TURNS, st.floats(0.6, 8))
def test_the_nearest_facing_surface_is_that_of_a_slow_loop(x, y, facing, reach):
    surface = Surface.from_cells(MapCells.from_values(plans.see(plans.office(0), scale=3.0).grid.occupancy))
    normal = math.cos(facing), math.sin(facing)

    found = nearest_facing(surface.index, surface.cells, x, y, *normal, reach)

    wanted = naive.nearest_facing(surface.cells, (x, y), normal, reach)
    distance = math.inf if found < 0 else math.dist(surface.cells[found, :2], (x, y))
    assert distance == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize("noise", [0, 2])
@pytest.mark.parametrize("off", [(0.05, 0.04, (6, -5)), (-0.06, -0.03, (-7, 4)), (0.0, 0.06, (3, 8))])
def test_fields_pull_a_placement_to_the_truth(noise, off):
    a, b = views(noise)
    one, two = (extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare) for view in (a, b))
    assert one is not None
    assert two is not None
    rng = np.random.default_rng(0)
    walls = rng.permutation(one.walls)[:300], rng.permutation(two.walls)[:300]
    true = to_working(plans.truth(a, b), one, two)
    start = as_placement(nudged(true, *off, about=two.walls.mean(axis=0)))

    fitted = refine(
        start[None],
        one,
        two,
        walls,
        PARAMS.propose.coarse_reaches_cells + PARAMS.propose.fine_reaches_cells,
        (0.3, 3.0),
    )[0]

    assert plans.error(as_similarity(to_pixels(start, one, two)), a, b) > 5
    assert plans.error(as_similarity(to_pixels(fitted, one, two)), a, b) < (1.0 if noise else 0.7)


def test_pixels_and_working_grids_tell_the_same_placement():
    a, b = plans.see(plans.office(0), scale=0.4, degrees=9), plans.see(plans.office(0), scale=0.3, degrees=200)
    one, two = (extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare) for view in (a, b))
    assert one is not None
    assert two is not None
    true = plans.truth(a, b)

    back = to_pixels(as_placement(to_working(true, one, two)), one, two)

    np.testing.assert_allclose(back, as_placement(true), atol=1e-9)
    assert min(one.factor, two.factor) > 1.5


@pytest.mark.parametrize("walls", [(1, 1), (3, 1), (1, 3)])
def test_surfaces_bring_a_placement_within_a_tenth_of_a_cell(walls):
    before, after = [], []
    for seed in range(5):
        # cells of one size: drawn walls begin half a cell behind the last free one, of each map
        a, b = views(seed=seed, walls=walls, scale=1.0)
        sign = 1 - 2 * (seed % 2)
        off = nudged(plans.truth(a, b), 0.007 * sign, 0.006, (1.5, -2.0 * sign), np.array(b.grid.shape[::-1]) / 2)
        fit = fitted(as_placement(off), a, b)
        before.append(plans.error(off, a, b))
        after.append(plans.error(as_similarity(fit.placement), a, b))
        assert fit.surface_matched > 0.75

    assert min(before) > 1.5
    assert np.median(after) < 0.1
    assert max(after) < 0.2


def test_a_placement_that_matches_too_little_stays_where_it_was():
    a, b = views()
    astray = as_placement(plans.truth(a, b)) + np.array([0, 0, 31.0, 17.0])

    np.testing.assert_array_equal(fitted(astray, a, b).placement, astray)


def test_the_scale_is_kept_within_its_bounds():
    a, b = views()
    start = as_placement(plans.truth(a, b))

    fit = fitted(start, a, b, (1.26, 1.5))

    assert math.hypot(*fit.placement[:2]) == pytest.approx(1.26)


@pytest.mark.parametrize("points", [EXACT.rival_points, EXACT.surface_points])
def test_points_are_spread_over_what_the_other_map_covers(points):
    a, b = views()
    true = plans.truth(a, b)

    seen = Surface.from_cells(MapCells.from_values(b.grid.occupancy)).seen_by(
        as_placement(true), a.grid.shape, points, EXACT.looked_at
    )

    at = true.apply(seen[:, :2])
    assert points / 2 < len(seen) <= points
    assert ((at >= 0) & (at < a.grid.shape[::-1])).all()


def test_the_inverse_of_a_fit_is_the_fit_the_other_way_round_and_twice_is_itself():
    a, b = views(1)
    fit = fitted(as_placement(plans.truth(a, b)), a, b)

    back, again = fit.inverse(), fit.inverse().inverse()

    np.testing.assert_allclose(back.placement, invert(fit.placement[None])[0])
    np.testing.assert_allclose(again.placement, fit.placement, rtol=1e-9)
    np.testing.assert_allclose(again.covariance, fit.covariance, rtol=1e-9, atol=1e-15)
    assert (again.residual_cells, again.surface_matched) == pytest.approx((fit.residual_cells, fit.surface_matched))


def made_fit() -> tuple[Fit, np.ndarray, np.ndarray]:
    """Make a fit with a drawn covariance about a pivot of B, and 2000 placements drawn from it."""
    rng = np.random.default_rng(0)
    root = rng.normal(size=(4, 4)) * [[1e-3], [2e-3], [0.1], [0.05]]
    covariance = root @ root.T
    true, pivot = Similarity(1.3, 0.7, 12.0, -5.0), np.array([80.0, 35.0])
    steps = rng.multivariate_normal(np.zeros(4), covariance, 2000)
    drawn = [as_placement(nudged(true, turn, grow, (x, y), pivot)) for turn, grow, x, y in steps]
    return Fit(as_placement(true), covariance, 1.0, 0.3), np.array(drawn), pivot


def spread_about(pivots: np.ndarray, similarities: list[Similarity], mean: Similarity) -> np.ndarray:
    """Covariance of (angle, ln scale, x, y) of drawn similarities, x and y being where they put a point."""
    rows = [
        [math.remainder(s.angle - mean.angle, math.tau), math.log(s.scale / mean.scale), *(s.apply(pivots))]
        for s in similarities
    ]
    return np.cov(np.array(rows).T)


def assert_alike(found: np.ndarray, drawn: np.ndarray) -> None:
    """Compare covariances in units of their own standard deviations; 2000 draws tell them to about 3 %."""
    unit = np.sqrt(np.diag(drawn))
    np.testing.assert_allclose(found / np.outer(unit, unit), drawn / np.outer(unit, unit), atol=0.1)


def test_the_covariance_of_the_inverse_is_that_of_inverted_draws():
    fit, drawn, pivot = made_fit()
    at_a = as_similarity(fit.placement).apply(pivot)

    back = fit.inverse()

    draws = [as_similarity(p) for p in invert(drawn)]
    assert_alike(back.covariance, spread_about(at_a, draws, as_similarity(back.placement)))


@pytest.mark.parametrize(
    ("resolution", "origin"), [(None, (0.0, 0.0, 0.0)), (0.05, (3.0, -2.0, 0.6)), (0.2, (1.0, 1.0, -2.5))]
)
def test_the_covariance_in_the_map_frame_is_that_of_draws_taken_there(origin, resolution):
    fit, drawn, pivot = made_fit()
    a = OccupancyGrid(np.zeros((70, 90), np.int8), resolution, origin)
    b = OccupancyGrid(np.zeros((60, 50), np.int8), 0.07, (0.3, 0.2, 1.0))

    found = fit.covariance_in_map_frame(a)

    mean = pixels_to_map_frame(as_similarity(fit.placement), a, b)
    draws = [pixels_to_map_frame(as_similarity(p), a, b) for p in drawn]
    assert_alike(found, spread_about(b.pixel_to_map(pivot), draws, mean))


def test_a_fit_that_is_refused_tells_of_the_placement_that_stays():
    a, b = views()
    start = as_placement(plans.truth(a, b)) + np.array([0.0, 0.0, 40.0, 25.0])
    one, two = (
        Surface.from_cells(MapCells.from_values(a.grid.occupancy)),
        Surface.from_cells(MapCells.from_values(b.grid.occupancy)),
    )
    points = (
        two.seen_by(start, one.index.shape, EXACT.surface_points, EXACT.looked_at),
        one.seen_by(invert(start[None])[0], two.index.shape, EXACT.surface_points, EXACT.looked_at),
    )

    fit = fitted(start, a, b)

    squares, partners, _ = set_equations(
        np.zeros((4, 4)), np.zeros(4), tuple(start), points[0], one.index, one.cells, points[1], two.index, two.cells,
        EXACT.reaches_cells[-1],
    )  # fmt: skip
    assert fit.surface_matched < EXACT.min_matched_share
    np.testing.assert_array_equal(fit.placement, start)
    assert fit.residual_cells == pytest.approx(math.sqrt(squares / partners))


@pytest.mark.slow
def test_the_covariance_of_noisy_pairs_is_of_the_size_of_their_errors():
    squares = []
    for seed in range(30):
        rooms = plans.office(seed)
        a = plans.see(rooms, degrees=11 * seed, noise=1, seed=seed)
        b = plans.see(rooms, degrees=37 * seed, scale=1.1, noise=1, seed=seed + 100)
        fit = fitted(as_placement(plans.truth(a, b)), a, b)
        off = plans.truth(a, b).inverse() @ as_similarity(fit.placement)
        squares.append([off.angle**2 / fit.covariance[0, 0], math.log(off.scale) ** 2 / fit.covariance[1, 1]])

    for square in np.median(squares, axis=0):
        assert 0.45 / 10 < square < 0.45 * 10  # 0.45 is the median of a chi-square variable of one degree


def fitted(start: np.ndarray, a: plans.PlanView, b: plans.PlanView, bounds: tuple[float, float] = (0.5, 2.0)) -> Fit:
    surfaces = (
        Surface.from_cells(MapCells.from_values(a.grid.occupancy)),
        Surface.from_cells(MapCells.from_values(b.grid.occupancy)),
    )
    return fit_surfaces(start, *surfaces, bounds, EXACT, points=EXACT.surface_points)


def to_working(pixels: Similarity, one, two) -> Similarity:
    """Turn a placement between pixels into one between working grids."""
    ours = Similarity(1 / one.factor, 0.0, *one.offset.tolist())
    theirs = Similarity(1 / two.factor, 0.0, *two.offset.tolist())
    return ours @ pixels @ theirs.inverse()
