import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge._kernels.fitting import nearest_facing, set_equations
from rectmerge._kernels.placements import invert
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.robust.features import extract_features
from rectmerge.robust.refinement import Surface, fit_surfaces, refine, to_pixels
from rectmerge.similarity import Similarity
from tests.rectmerge.robust import naive, plans
from tests.rectmerge.robust.fits import EXACT, PARAMS, fitted, nudged, views
from tests.rectmerge.robust.plans import as_placement, as_similarity

TURNS = st.floats(-math.pi, math.pi)


def test_the_surface_is_where_walls_face_free_space():
    cells = np.full((12, 20), -1, np.int8)
    cells[2:10, 2:10] = 0
    cells[2:10, 10:13] = 100  # three cells thick, the unknown behind

    surface = Surface.from_cells(MapCells.from_values(cells)).cells

    assert set(surface[:, 0]) == {10.0}
    assert sorted(surface[:, 1]) == list(range(2, 10))
    in_the_middle = np.abs(surface[:, 1] - 5.5) < 2
    np.testing.assert_allclose(surface[in_the_middle, 2:], [[-1.0, 0.0]] * 4)


def test_a_wall_free_on_both_sides_faces_nowhere_but_at_its_ends():
    cells = np.zeros((9, 9), np.int8)
    cells[:, 4] = 100

    assert set(Surface.from_cells(MapCells.from_values(cells)).cells[:, 1]) == {0.0, 1.0, 7.0, 8.0}


@settings(max_examples=25)
@given(st.floats(0, 95), st.floats(0, 95), TURNS, st.floats(0.6, 8))
def test_the_nearest_facing_surface_is_that_of_a_slow_loop(x, y, facing, reach):
    surface = Surface.from_cells(MapCells.from_values(plans.see(plans.office(0), scale=3.0).grid.occupancy))
    normal = math.cos(facing), math.sin(facing)

    nearest = nearest_facing(surface.index, surface.cells, x, y, *normal, reach)

    wanted = naive.nearest_facing(surface.cells, (x, y), normal, reach)
    distance = math.inf if nearest < 0 else math.dist(surface.cells[nearest, :2], (x, y))
    assert distance == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize("noise", [0, 2])
@pytest.mark.parametrize("off", [(0.05, 0.04, (6, -5)), (-0.06, -0.03, (-7, 4)), (0.0, 0.06, (3, 8))])
def test_fields_pull_a_placement_to_the_truth(noise, off):
    a, b = views(noise)
    features_a, features_b = (
        extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare) for view in (a, b)
    )
    assert features_a is not None
    assert features_b is not None
    rng = np.random.default_rng(0)
    walls = rng.permutation(features_a.walls)[:300], rng.permutation(features_b.walls)[:300]
    true = to_working(plans.truth(a, b), features_a, features_b)
    start = as_placement(nudged(true, *off, about=features_b.walls.mean(axis=0)))

    fitted = refine(
        start[None],
        features_a,
        features_b,
        walls,
        PARAMS.propose.coarse_reaches_cells + PARAMS.propose.fine_reaches_cells,
        (0.3, 3.0),
    )[0]

    assert plans.error(as_similarity(to_pixels(start, features_a, features_b)), a, b) > 5
    assert plans.error(as_similarity(to_pixels(fitted, features_a, features_b)), a, b) < (1.0 if noise else 0.7)


def test_pixels_and_working_grids_tell_the_same_placement():
    a, b = plans.see(plans.office(0), scale=0.4, degrees=9), plans.see(plans.office(0), scale=0.3, degrees=200)
    features_a, features_b = (
        extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare) for view in (a, b)
    )
    assert features_a is not None
    assert features_b is not None
    true = plans.truth(a, b)

    back = to_pixels(as_placement(to_working(true, features_a, features_b)), features_a, features_b)

    np.testing.assert_allclose(back, as_placement(true), atol=1e-9)
    assert min(features_a.factor, features_b.factor) > 1.5


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

    surface_a, surface_b = (Surface.from_cells(MapCells.from_values(each.grid.occupancy)) for each in (a, b))

    seen = surface_b.seen_by(as_placement(true), surface_a, points, EXACT.looked_at)

    at = true.apply(seen[:, :2])
    low, high = surface_a.cells[:, :2].min(axis=0), surface_a.cells[:, :2].max(axis=0)
    everywhere = true.apply(surface_b.cells[:, :2])
    covered = ((everywhere >= low - 0.5) & (everywhere <= high + 0.5)).all(axis=1)
    assert min(points, np.count_nonzero(covered)) / 2 < len(seen) <= points
    assert ((at >= low - 0.5) & (at <= high + 0.5)).all()


def test_a_box_on_itself_has_as_many_partners_a_little_beside_it():
    cells = np.full((80, 120), -1, np.int8)
    cells[10:70, 10:110] = 100
    cells[11:69, 11:109] = 0
    surface = Surface.from_cells(MapCells.from_values(cells))

    seen = [surface.seen_by(np.array([1.0, 0.0, shift, 0.0]), surface, 5000, 1) for shift in (0.0, 0.001, 0.4)]

    assert [len(points) for points in seen] == [len(surface.cells)] * 3


def test_partners_are_counted_on_cells_that_the_other_map_knows():
    cells = np.full((80, 200), -1, np.int8)
    cells[10:70, 10:190] = 100
    cells[11:69, 11:189] = 0
    half = cells.copy()
    half[:, 80:] = -1
    start = np.array([1.0, 0.0, 0.4, -0.3])

    fit = fit_surfaces(
        start, *(Surface.from_cells(MapCells.from_values(each)) for each in (cells, half)), (0.9, 1.1), EXACT,
        points=EXACT.surface_points,
    )  # fmt: skip

    assert fit.surface_matched > 0.9
    np.testing.assert_allclose(fit.placement, [1.0, 0.0, 0.0, 0.0], atol=0.02)


def test_a_fit_that_is_refused_tells_of_the_placement_that_stays():
    a, b = views()
    start = as_placement(plans.truth(a, b)) + np.array([0.0, 0.0, 40.0, 25.0])
    surface_a, surface_b = (
        Surface.from_cells(MapCells.from_values(a.grid.occupancy)),
        Surface.from_cells(MapCells.from_values(b.grid.occupancy)),
    )
    points = (
        surface_b.seen_by(start, surface_a, EXACT.surface_points, EXACT.looked_at),
        surface_a.seen_by(invert(start[None])[0], surface_b, EXACT.surface_points, EXACT.looked_at),
    )

    fit = fitted(start, a, b)

    squares, partners, _ = set_equations(
        np.zeros((4, 4)), np.zeros(4), tuple(start), points[0], surface_a.index, surface_a.cells,
        surface_a.known, points[1], surface_b.index, surface_b.cells, surface_b.known,
        EXACT.reaches_cells[-1], 1,
    )  # fmt: skip
    assert fit.surface_matched < EXACT.min_matched_share
    np.testing.assert_array_equal(fit.placement, start)
    assert fit.residual_cells == pytest.approx(math.sqrt(squares / partners))


def to_working(pixels: Similarity, features_a, features_b) -> Similarity:
    """Turn a placement between pixels into one between working grids."""
    ours = Similarity(1 / features_a.factor, 0.0, *features_a.offset.tolist())
    theirs = Similarity(1 / features_b.factor, 0.0, *features_b.offset.tolist())
    return ours @ pixels @ theirs.inverse()
