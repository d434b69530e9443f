import math
from dataclasses import replace

import numpy as np
import pytest

from rectmerge._kernels.placements import invert
from rectmerge.analysis.trinary_map import MapCells
from rectmerge.robust.correlation import correlate, scales_within
from rectmerge.robust.features import dominant_angles, extract_features
from rectmerge.robust.likelihood import WallNoise, face_gains
from rectmerge.robust.params import Params
from tests import naive
from tests.rectmerge.robust import plans

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

    placements, gains = correlate(on_a, on_b, [math.hypot(*truth[:2])], PARAMS.correlate, PARAMS.gain, max_shifts=5)

    best, points = placements[np.argmax(gains)], features_b.landmarks
    assert np.abs(naive.move(best, points) - naive.move(truth, points)).max() < 2 * CELLS * max(1.0, 1 / scale)


def test_the_gain_of_a_shift_is_about_that_of_its_faces_one_by_one():
    rooms = plans.office(2)
    on_a, on_b = faces_of(plans.see(rooms, degrees=0)), faces_of(plans.see(rooms, degrees=90))
    fine = replace(PARAMS.correlate, max_diagonal_cells=1000.0)  # cells of a larger map hold several faces

    placements, gains = correlate(on_a, on_b, [1.0], fine, PARAMS.gain, max_shifts=3)

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

    placements, gains = correlate(left, right, [1.0], PARAMS.correlate, PARAMS.gain, max_shifts=5)

    unturned = placements[:, 0] > 0.5
    assert gains[unturned].max() < 0.2 * gains[~unturned].max()


def test_scales_cover_their_bounds_evenly():
    scales = scales_within((0.5, 2.0), SCALE_STEP)

    assert scales[[0, -1]] == pytest.approx([0.5, 2.0])
    assert 0 < np.diff(np.log(scales)).max() <= SCALE_STEP + 1e-9
    assert np.ptp(np.diff(np.log(scales))) < 1e-9
    assert scales_within((1.0, 1.0), SCALE_STEP) == pytest.approx([1.0])
