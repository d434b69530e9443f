"""What people know of a placement: a guess decides between equals, what is placed by hand is judged like the rest."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.aligning import align, check
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.robust.refinement import to_pixels, to_working
from rectmerge.similarity import Similarity
from tests.marking import some_slow
from tests.rectmerge.robust import plans


@pytest.fixture(scope="module")
def hall():
    """Two views of a symmetric hall, which fits two ways, and the truth."""
    a = plans.see([plans.box(0, 0, 300, 150)], degrees=20, noise=0, seed=1)
    b = plans.see([plans.box(0, 0, 300, 150)], degrees=77, scale=1.1, noise=0, seed=2)
    return a, b, pixels_to_map_frame(plans.truth(a, b), a.grid, b.grid)


@pytest.fixture(scope="module")
def office():
    rooms = plans.office(3)
    a, b = plans.see(rooms, degrees=10, noise=1, seed=1), plans.see(rooms, degrees=150, scale=1.2, noise=1, seed=2)
    return a, b, plans.truth(a, b)


def half_turned(hall):
    """The other placement of the hall: a half turn about its middle on map A."""
    a, _, b_to_a = hall
    free = np.argwhere(a.grid.free)[:, ::-1].mean(axis=0)
    x, y = a.grid.pixel_to_map(free)
    return Similarity(1.0, math.pi, 2 * x, 2 * y) @ b_to_a


def distance(grid, one, other):
    corners = grid.pixel_to_map(np.argwhere(grid.free)[:: max(1, grid.free.sum() // 50), ::-1])
    return float(np.abs(one.apply(corners) - other.apply(corners)).max())


@pytest.mark.parametrize("which", some_slow(["truth", "half turned"], "half turned"))
@pytest.mark.parametrize("off", [(0.0, 0.0, 0.0), (15.0, -10.0, 0.1)])
def test_a_guess_decides_between_placements_that_the_walls_do_not_tell_apart(hall, which, off):
    a, b, b_to_a = hall
    wanted = b_to_a if which == "truth" else half_turned(hall)
    guess = (wanted.tx + off[0], wanted.ty + off[1], wanted.angle + off[2])

    unaided = align(a.grid, b.grid, scale=b_to_a.scale)
    alignment = align(a.grid, b.grid, scale=b_to_a.scale, guess=guess)

    assert unaided.verdict == "ambiguous"
    assert alignment.verdict == "accepted"
    assert distance(b.grid, alignment.b_to_a, wanted) < 3.0


def test_a_guess_that_is_wrong_is_not_borne_out(office):
    a, b, pixels = office
    b_to_a = pixels_to_map_frame(pixels, a.grid, b.grid)

    alignment = align(a.grid, b.grid, guess=(b_to_a.tx + 150, b_to_a.ty - 90, b_to_a.angle + 2))

    assert alignment.verdict != "accepted"
    assert "guess" in alignment.reason


def test_a_guess_makes_no_answer_of_maps_of_different_places():
    a, b = (plans.see(plans.office(seed), degrees=0, noise=0, seed=seed) for seed in (5, 11))

    assert align(a.grid, b.grid, guess=(0.0, 0.0, 0.0)).verdict != "accepted"


def test_swapped_maps_and_the_inverse_guess_give_the_inverse(hall):
    a, b, b_to_a = hall
    back = b_to_a.inverse()

    alignment = align(b.grid, a.grid, scale=1 / b_to_a.scale, guess=(back.tx, back.ty, back.angle))

    assert alignment.verdict == "accepted"
    assert distance(a.grid, alignment.b_to_a, back) < 3.0


def test_the_true_placement_passes_a_check_and_is_made_exact(office):
    a, b, pixels = office
    sloppy = Similarity(pixels.scale * 1.01, pixels.angle + 0.01, pixels.tx + 3, pixels.ty - 2)

    judged = check(a.grid, b.grid, sloppy)

    assert judged.verdict == "accepted"
    assert plans.error(judged.candidates[0].pixels, a, b) < 0.5


def test_a_check_of_the_best_placement_says_what_align_says(office):
    a, b, _ = office
    alignment = align(a.grid, b.grid)

    checked = check(a.grid, b.grid, alignment.candidates[0].pixels)

    assert (checked.verdict, checked.confidence) == (alignment.verdict, pytest.approx(alignment.confidence, abs=0.02))


def test_a_wrong_placement_fails_a_check_that_points_to_the_better_one(office):
    a, b, pixels = office
    wrong = Similarity(pixels.scale, pixels.angle + math.pi / 2, pixels.tx + 60, pixels.ty)

    judged = check(a.grid, b.grid, wrong)

    assert judged.verdict == "rejected"
    assert judged.reason.startswith("the walls agree better elsewhere")
    assert plans.is_right(judged.candidates[1].pixels, a, b)
    plausible = [candidate.evidence["plausibility"] for candidate in judged.candidates[1:]]
    assert plausible == sorted(plausible, reverse=True)


@pytest.mark.slow
@pytest.mark.parametrize("shift", [(5, -8), (60, 0), (-30, 45)])
def test_the_better_placement_comes_second_wherever_the_wrong_one_lies(office, shift):
    a, b, pixels = office
    wrong = Similarity(pixels.scale, pixels.angle + 0.4, pixels.tx + shift[0], pixels.ty + shift[1])

    judged = check(a.grid, b.grid, wrong)

    assert plans.is_right(judged.candidates[1].pixels, a, b)


def test_one_of_two_placements_that_fit_as_well_is_ambiguous_in_a_check(hall):
    a, b, _ = hall

    judged = check(a.grid, b.grid, plans.truth(a, b), scale="free")

    assert judged.verdict == "ambiguous"


def test_far_away_maps_share_nothing_and_fail_a_check(office):
    a, b, pixels = office

    assert check(a.grid, b.grid, Similarity(pixels.scale, 0.0, 1e6, -1e6)).verdict == "rejected"


def test_only_methods_that_take_hints_are_given_one(office):
    a, b, pixels = office

    with pytest.raises(InputError, match="'paper' takes neither"):
        check(a.grid, b.grid, pixels, method="paper")
    with pytest.raises(InputError, match="three finite numbers"):
        align(a.grid, b.grid, guess=(0.0, math.nan, 0.0))


class Working:
    def __init__(self, factor, offset):
        self.factor, self.offset = factor, np.array(offset)


@given(
    st.floats(0.5, 2), st.floats(-3, 3), st.floats(-500, 500), st.floats(-500, 500), st.floats(1, 5), st.floats(1, 5)
)
def test_working_cells_and_pixels_are_inverse_to_each_other(scale, angle, tx, ty, factor_a, factor_b):
    a, b = Working(factor_a, (3.0, -7.5)), Working(factor_b, (0.5, 11.0))
    pixels = Similarity(scale, angle, tx, ty)

    assert np.allclose(plans.as_similarity(to_pixels(to_working(pixels, a, b), a, b)).matrix, pixels.matrix)


def test_an_empty_map_has_its_reason_whatever_the_hint():
    empty = OccupancyGrid(np.full((40, 40), -1, np.int8))
    full = plans.see([plans.box(0, 0, 100, 80)], degrees=0, noise=0, seed=1).grid

    assert "no free cell" in check(full, empty, Similarity()).reason
