import math

import cv2
import numpy as np
import pytest

from rectmerge._kernels.correlating import highest_peaks
from rectmerge._kernels.placements import invert
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.robust.correlation import _correlated, correlate, scales_within
from rectmerge.robust.directions import dominant_angles
from rectmerge.robust.features import extract_features
from rectmerge.robust.likelihood import WallNoise, face_gains
from rectmerge.robust.params import Params
from tests.rectmerge.robust import naive, plans

PARAMS = Params()
CELLS, SCALE_STEP = PARAMS.correlate.cell_cells, PARAMS.correlate.scale_step


def features_of(view):
    return extract_features(MapCells.from_values(view.grid.occupancy), PARAMS.prepare)


def faces_of(view):
    features = features_of(view)
    return features.faces(dominant_angles(features, PARAMS.prepare)[0][0], PARAMS.faces)


def true_placement(a, b, features_a, features_b):
    """The truth between the working grids, (a, b, tx, ty)."""
    m = plans.truth(a, b).matrix
    linear = m[:, :2] * features_b.factor / features_a.factor
    return np.array([*linear[:, 0], *(m[:, 2] / features_a.factor + features_a.offset - linear @ features_b.offset)])


@pytest.mark.parametrize("turn", [0, 90, 180, 270, 201])
@pytest.mark.parametrize("scale", [0.7, 1.0, 1.5])
def test_the_best_shift_at_the_true_scale_is_the_true_one(turn, scale):
    rooms = plans.office(1)
    a, b = plans.see(rooms, degrees=10, noise=1, seed=1), plans.see(rooms, degrees=turn, scale=scale, noise=1, seed=2)
    on_a, on_b = faces_of(a), faces_of(b)
    features_a, features_b = features_of(a), features_of(b)
    truth = true_placement(a, b, features_a, features_b)

    placements, gains = correlate(on_a, [on_b], [math.hypot(*truth[:2])], PARAMS.correlate, PARAMS.gain, max_shifts=5)

    best, points = placements[np.argmax(gains)], features_b.landmarks
    assert np.abs(naive.move(best, points) - naive.move(truth, points)).max() < 2 * CELLS * max(1.0, 1 / scale)


def test_the_gain_of_a_shift_is_about_that_of_its_faces_one_by_one():
    rooms = plans.office(2)
    on_a, on_b = faces_of(plans.see(rooms, degrees=0)), faces_of(plans.see(rooms, degrees=90))

    placements, gains = correlate(on_a, [on_b], [1.0], PARAMS.correlate, PARAMS.gain, max_shifts=3)

    best = placements[[np.argmax(gains)]]
    quarter = round((on_b.angle + math.atan2(best[0, 1], best[0, 0]) - on_a.angle) / (math.pi / 2)) % 4
    noise = WallNoise((CELLS * PARAMS.correlate.spread_cells,), PARAMS.correlate.outliers)
    back = invert(best)
    slow = 0.0
    for k in range(4):
        for there, here, way, placement in (
            (on_a, on_b, (k + quarter) % 4, best),
            (on_b, on_a, (k - quarter) % 4, back),
        ):
            facing = here.faces[:, [k]].astype(np.uint8)
            met = naive.count_codes(placement, [0], here.walls, facing, there.codes[[way]])[0, 0]
            slow += met @ face_gains(there, noise, PARAMS.gain)[way]
    assert gains.max() == pytest.approx(slow, rel=0.15)


def test_walls_back_to_back_gain_nothing():
    cells = np.full((60, 160), -1, np.int8)
    cells[10:50, 10] = 100
    cells[10:50, 11:60] = 0
    left = extract_features(MapCells.from_values(cells), PARAMS.prepare).faces(0.0, PARAMS.faces)
    right = extract_features(MapCells.from_values(np.ascontiguousarray(cells[:, ::-1])), PARAMS.prepare).faces(
        0.0, PARAMS.faces
    )

    placements, gains = correlate(left, [right], [1.0], PARAMS.correlate, PARAMS.gain, max_shifts=5)

    unturned = placements[:, 0] > 0.5
    assert gains[unturned].max() < 0.2 * gains[~unturned].max()


def test_scales_cover_their_bounds_evenly():
    scales = scales_within((0.5, 2.0), SCALE_STEP)

    assert scales[[0, -1]] == pytest.approx([0.5, 2.0])
    assert 0 < np.diff(np.log(scales)).max() <= SCALE_STEP + 1e-9
    assert np.ptp(np.diff(np.log(scales))) < 1e-9
    assert scales_within((1.0, 1.0), SCALE_STEP) == pytest.approx([1.0])


@pytest.mark.parametrize("quarter", range(4))
def test_the_sum_of_products_is_that_of_the_turned_images(quarter):
    rng, side = np.random.default_rng(quarter), 12
    a, b = (
        rng.normal(size=(4, side, side)).astype(np.float32) + 1j * rng.normal(size=(4, side, side)).astype(np.float32)
        for _ in range(2)
    )
    turned = b
    for _ in range(quarter):  # from u towards v about the first cell: what is at (u, v) goes to (-v, u)
        turned = np.roll(np.rot90(turned, -1, axes=(1, 2)), 1, axis=2)
    spectra = np.fft.fft2(np.roll(a, -quarter, axis=0)), np.fft.fft2(turned)

    scores = [*_correlated(np.fft.fft2(a).astype(np.complex64), np.fft.fft2(b).astype(np.complex64))][quarter]

    slow = np.fft.ifft2((spectra[0] * spectra[1].conj()).sum(axis=0)).real
    np.testing.assert_allclose(scores, slow, atol=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_the_highest_peaks_are_those_of_a_sorted_list(seed):
    scores = np.random.default_rng(seed).integers(0, 50, (9, 13)).astype(np.float32)
    cells, values = np.empty(6, np.int64), np.empty(6, np.float32)

    count = highest_peaks(scores, cells, values)

    is_peak = scores >= cv2.dilate(scores, np.ones((3, 3), np.uint8))
    slow = sorted((-scores.flat[cell], cell) for cell in np.flatnonzero(is_peak))[:6]
    assert [(-value, cell) for value, cell in zip(values[:count], cells[:count], strict=True)] == slow
