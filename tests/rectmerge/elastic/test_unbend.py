import json
import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import rectmerge as rm
from rectmerge.alignment import Alignment
from rectmerge.elastic.faces import Faces
from rectmerge.elastic.fit import ElasticFit
from rectmerge.elastic.lattice import Displacement
from rectmerge.elastic.matching import FacePair
from rectmerge.elastic.params import FaceParams, FitParams
from rectmerge.elastic.transform import BentTransform
from rectmerge.grid import pixels_to_map_frame
from rectmerge.io.json_text import to_json
from tests.drawing import building
from tests.rectmerge.elastic.bent_maps import bent_view, large_building, random_displacement

PIXELS = rm.Similarity(0.8, 0.3, 60.0, -40.0)
SHAPE = (560, 720)


@cache
def bent_case(seed):
    """A, B that is bent against it, the true place of B's free cells in A, and their best similarity."""
    a = large_building()
    truth = random_displacement(seed, a.shape, spacing=200, size=14)
    b = bent_view(a, PIXELS, truth, SHAPE)
    cells = np.argwhere(b.free)[::197, ::-1].astype(float)
    true = truth.apply(PIXELS.apply(cells))
    return a, b, cells, true, rm.Similarity.fit(cells, true)


@cache
def bend_of(seed):
    a, b, _, _, fit = bent_case(seed)
    return rm.unbend(a, b, fit)


def rmse(points, true):
    return float(np.sqrt(((points - true) ** 2).sum(axis=-1).mean()))


@pytest.mark.parametrize("seed", range(4))
def test_a_known_bend_is_recovered(seed):
    a, b, cells, true, fit = bent_case(seed)

    bend = bend_of(seed)

    found = a.map_to_pixel(bend.apply(b.pixel_to_map(cells)))
    assert bend, bend.reason
    assert rmse(found, true) <= 0.5 * rmse(fit.apply(cells), true)
    assert bend.evidence.walls_after < 0.5 * bend.evidence.walls_before
    assert "walls held back from the fit agree" in bend.reason


@pytest.mark.parametrize("pixels", [rm.Similarity(), PIXELS, rm.Similarity(1.3, -2.0, 30.0, 500.0)])
def test_rigid_maps_are_left_as_they_are(pixels):
    a = large_building()
    b = bent_view(a, pixels, Displacement.none(random_displacement(0, a.shape, spacing=160, size=1).lattice), SHAPE)

    bend = rm.unbend(a, b, pixels)

    assert not bend
    assert "do not bend measurably" in bend.reason
    assert_allclose(bend.apply(b.pixel_to_map([[3.0, 4.0]])), a.pixel_to_map(pixels.apply([[3.0, 4.0]])))


@pytest.mark.parametrize(("turn", "tx", "ty"), [(0.7, 0, 0), (1.57, 0, 0), (4.0, 0, 0), (0, 150, 0), (0, -90, 120)])
def test_a_wrong_placement_is_not_bent_into_a_right_one(turn, tx, ty):
    a = large_building()
    middle = np.array([a.shape[1], a.shape[0]]) / 2
    turned = rm.Similarity(1.0, turn)

    bend = rm.unbend(a, a, rm.Similarity(1.0, turn, *(middle - turned.apply(middle) + [tx, ty])))

    assert not bend
    assert bend.warp is None
    assert bend.reason


@settings(max_examples=20)
@given(st.integers(0, 3), st.floats(-3, 3), st.floats(0.01, 0.2), st.floats(-10, 10))
def test_the_inverse_holds_within_a_twentieth_of_a_cell_in_any_map_frame(seed, yaw, resolution, shift):
    plain_a, plain_b, *_ = bent_case(seed)
    a = rm.OccupancyGrid(plain_a.occupancy, resolution, (shift, -shift, yaw))
    b = rm.OccupancyGrid(plain_b.occupancy, 1.2 * resolution, (2 * shift, 1.0, -yaw / 2))
    warp, b_to_a = bend_of(seed).warp, pixels_to_map_frame(bend_of(seed).pixels, a, b)
    std = np.ones(warp.displacement.lattice.node_count)
    bent = BentTransform.from_pixels(b_to_a, warp.displacement, std, a)
    pixels = np.random.default_rng(seed).uniform(-100, 800, (100, 2))
    points = b.pixel_to_map(pixels)

    moved = bent.apply(points)

    assert_allclose(a.map_to_pixel(moved), warp.apply(pixels), atol=1e-5)
    assert np.abs(b.map_to_pixel(bent.inverse().apply(moved)) - pixels).max() < 0.05
    assert_allclose(bent.between_pixels(a, b).apply(pixels), warp.apply(pixels), atol=1e-5)
    assert_allclose(bent.std(points), resolution)
    step = 1e-3 * resolution * np.eye(2)
    sides = [(bent.apply(points + e) - bent.apply(points - e)) / (2e-3 * resolution) for e in step]
    inside = bent.contains(points)
    assert_allclose(bent.jacobian(points)[inside], np.stack(sides, axis=-1)[inside], atol=1e-3)
    read = BentTransform.from_dict(json.loads(to_json(bent.as_dict())))
    assert np.abs(read.apply(points) - moved).max() < 0.01 * resolution


def test_the_file_of_a_bend_is_small():
    for seed in range(4):
        assert len(to_json(bend_of(seed).transform.as_dict())) < 50_000


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schema": "other/1"}, "no schema 'other/1'"),
        ({"lattice": {"x": [[1.0, 2.0], [3.0, 4.0]]}}, "of one shape, 4 x 4 nodes or more"),
        ({"lattice": {"origin": [float("nan"), 0.0]}}, "finite numbers"),
        ({"lattice": {"axis_1": [1.0, 2.0, 3.0], "axis_2": [1.0, 2.0, 3.0]}}, "finite numbers"),
    ],
)
def test_a_file_that_is_no_bend_is_refused(change, message):
    record = bend_of(0).transform.as_dict()
    changed = {k: {**record[k], **v} if isinstance(v, dict) else v for k, v in change.items()}

    with pytest.raises(ValueError, match=message):
        BentTransform.from_dict({**record, **changed})


def test_a_bend_is_nowhere_folded():
    for seed in range(4):
        determinant, least, greatest = bend_of(seed).warp.displacement.extremes()

        assert determinant > 0.5
        assert 0.65 <= least <= greatest <= 1.4


def test_near_a_point_the_bend_is_a_similarity():
    bend, point, step = bend_of(0), np.array([250.0, 300.0]), 2.0
    near = bend.similarity_at(point)

    assert_allclose(near.apply(point), bend.apply(point))
    assert near.angle == pytest.approx(float(bend.local_angle(point)))
    for e in step * np.eye(2):
        assert np.abs(near.apply(point + e) - bend.apply(point + e)).max() < 0.1 * step


def test_the_standard_deviation_is_larger_where_there_are_no_walls():
    a, b, cells, _, _ = bent_case(0)
    bend = bend_of(0)

    inside = bend.std(b.pixel_to_map(cells))

    assert inside.shape == (len(cells),)
    assert 0 < np.median(inside) < 3
    assert np.isnan(rm.unbend(a, a, rm.Similarity()).std([[1.0, 2.0]])).all()


def test_the_angle_of_a_refused_bend_is_that_of_the_similarity():
    a = large_building()
    bend = rm.unbend(a, a, rm.Similarity())

    assert bend.local_angle([[5.0, 5.0]]) == pytest.approx([0.0])
    assert not bend.contains([[5.0, 5.0]]).any()
    assert_allclose(bend.inverse().apply([5.0, 5.0]), [5.0, 5.0])


def test_the_same_maps_give_the_same_bend():
    a, b, _, _, fit = bent_case(1)

    again = rm.unbend(a, b, fit)

    assert (again.warp.displacement.coefficients == bend_of(1).warp.displacement.coefficients).all()
    assert again.as_dict() == bend_of(1).as_dict()


@pytest.mark.parametrize("value", [0, -1])
def test_a_map_without_walls_gives_a_reason(value):
    empty = rm.OccupancyGrid(np.full((50, 60), value, np.int8))

    bend = rm.unbend(large_building(), empty, rm.Similarity())

    assert not bend
    assert "too few walls" in bend.reason


def test_maps_that_share_nothing_give_a_reason():
    a = large_building()

    assert "too few walls in common" in rm.unbend(a, a, rm.Similarity(tx=5000.0)).reason


def test_an_alignment_without_candidate_is_refused():
    a = large_building()

    with pytest.raises(rm.InputError, match="no candidate to bend: rejected, map B has no free cell"):
        rm.unbend(a, a, Alignment(verdict="rejected", reason="map B has no free cell", method="robust"))


def test_a_building_laid_on_itself_half_turned_is_refused_once_it_is_judged():
    a = large_building()
    half = np.array([a.shape[1] - 1, a.shape[0] - 1])
    turned = rm.Similarity(1.0, math.pi, float(half[0]), float(half[1]))

    judged = rm.check(a, a, turned)
    bend = rm.unbend(a, a, judged)

    assert judged.verdict == "rejected"
    assert not bend
    assert bend.warp is None
    assert "the placement is rejected" in bend.reason
    assert judged.reason in bend.reason


def test_an_alignment_gives_its_best_candidate():
    a = large_building()
    alignment = rm.align(a, a)

    bend = rm.unbend(a, a, alignment)

    assert bend.pixels == alignment.candidates[0].pixels
    assert math.isclose(bend.evidence.walls_before, 0.0, abs_tol=0.5)


def test_a_small_map_in_a_large_one_has_a_small_lattice_and_labels():
    a = building()
    b = rm.OccupancyGrid(np.pad(np.tile(a.occupancy, (12, 12)), 3000, constant_values=-1))

    faces = Faces.from_grid(b, FaceParams())
    pair = FacePair.under(rm.Similarity(tx=-3000.0, ty=-3000.0), Faces.from_grid(a, FaceParams()), faces, FaceParams())

    assert max(faces.labels.shape[1:]) < 600
    assert max(ElasticFit.of_pair(pair, FitParams()).lattice.counts) < 30
