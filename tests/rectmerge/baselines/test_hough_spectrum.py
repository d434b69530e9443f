import math

import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.baselines.hough_spectrum import HoughSpectrum, hough_spectrum, shifts_between, turns_between
from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from tests.rectmerge.baselines import scenes

SEARCHING = HoughSpectrum(scale_search=True, rank_by="walls", accept_at=0.5)


@pytest.mark.parametrize(("scale", "degrees"), [(0.8, 25), (1.3, -70), (1.3, 160)])
def test_a_scale_search_finds_scale_turn_and_shift(scale, degrees):
    b, truth = scenes.turned(scale, degrees)

    alignment = align(scenes.upright(), b, method=SEARCHING)

    assert alignment, alignment.reason
    assert scenes.farthest(alignment.candidates[0].pixels, truth, b) < 4


def test_the_rigid_method_takes_one_where_the_scale_is_not_known_and_what_is_known():
    b, truth = scenes.turned(1.3, 40)

    free = align(scenes.upright(), b, method=HoughSpectrum())
    known = align(scenes.upright(), b, method=HoughSpectrum(), scale=1.3)

    assert {round(candidate.pixels.scale, 9) for candidate in free.candidates} == {1.0}
    assert scenes.farthest(known.candidates[0].pixels, truth, b) < 3


def test_another_building_is_rejected_by_its_walls():
    assert not align(scenes.upright(), scenes.other(), method=SEARCHING)


@pytest.mark.parametrize("degrees", [0, 31, 90, 154])
def test_the_spectrum_peaks_at_the_normal_of_a_line(degrees):
    along = Similarity(1.0, math.radians(degrees + 90))
    points = along.apply([[t, 0.0] for t in range(60)])

    spectrum = hough_spectrum(points, np.radians(np.arange(180)))

    assert np.argmax(spectrum) == degrees


def test_turns_go_from_the_second_spectrum_to_the_first_with_their_half_turns():
    first = np.random.default_rng(0).random(180)

    turns = turns_between(np.roll(first, 25), first, max_peaks=1)

    assert np.degrees(turns) == pytest.approx([25, 205])


def test_shifts_go_from_the_second_coordinates_to_the_first():
    b = np.array([0.0, 0.0, 0.0, 7.0, 19.0, 19.0])

    assert shifts_between(b - 12.0, b, max_peaks=1) == [-12.0]


@pytest.mark.parametrize("field", ["turns", "shifts", "longest_cells", "angle_step_deg", "scale_step", "accept_at"])
def test_a_parameter_that_is_not_positive_is_refused_by_name(field):
    with pytest.raises(InputError, match=field):
        HoughSpectrum(**{field: 0})


def test_an_unknown_score_is_refused():
    with pytest.raises(InputError, match="rank_by"):
        HoughSpectrum(rank_by="overlap")
