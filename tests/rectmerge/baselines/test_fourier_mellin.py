import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.baselines.fourier_mellin import FourierMellin, find_shift, highest_maxima, phase_correlation
from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from tests.marking import some_slow
from tests.rectmerge.baselines import scenes


@pytest.mark.parametrize("layer", some_slow(["occupied", "free"], "occupied"))
@pytest.mark.parametrize(("scale", "degrees"), [(0.8, 25), (1.0, 200), (1.3, -70)])
def test_turn_scale_and_shift_are_found(layer, scale, degrees):
    b, truth = scenes.turned(scale, degrees)

    alignment = align(scenes.upright(), b, method=FourierMellin(layer=layer, peaks=3))

    assert scenes.farthest(alignment.candidates[0].pixels, truth, b) < 3


def test_a_known_scale_is_not_left():
    b, truth = scenes.turned(1.3, 40)

    alignment = align(scenes.upright(), b, method=FourierMellin(), scale=1.3)

    assert alignment.candidates[0].pixels.scale == pytest.approx(1.3, rel=0.02)
    assert scenes.farthest(alignment.candidates[0].pixels, truth, b) < 3


def test_another_building_is_rejected():
    assert not align(scenes.upright(), scenes.other(), method=FourierMellin())


@pytest.mark.parametrize(("dx", "dy"), [(0, 0), (-40, 9), (45, -30)])
def test_a_shift_is_found_in_either_direction(dx, dy):
    rng = np.random.default_rng(0)
    world = rng.random((192, 192)).astype(np.float32)
    a, b = world[64:128, 64:128], world[64 + dy : 128 + dy, 64 + dx : 128 + dx]

    shift, score = find_shift(a, b, Similarity(), 64)

    assert shift.apply([0.0, 0.0]) == pytest.approx([dx, dy], abs=0.6)
    assert 0 < score <= 1


def test_a_phase_correlation_peaks_at_one_where_the_second_image_has_moved():
    image = np.random.default_rng(1).random((32, 48)).astype(np.float32)

    surface = phase_correlation(np.roll(image, (5, -7), axis=(0, 1)), image)

    assert highest_maxima(surface, 1) == [(5, 48 - 7)]
    assert surface[5, 41] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("fields", [{"layer": "walls"}, {"side": 8}, {"peaks": 0}, {"accept_at": 0.0}])
def test_a_parameter_out_of_range_is_refused_by_name(fields):
    with pytest.raises(InputError, match=next(iter(fields))):
        FourierMellin(**fields)
