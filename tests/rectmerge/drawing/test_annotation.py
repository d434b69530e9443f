import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.drawing.annotation import MAX_CIRCLES, circle_spots, draw_origins, find_spots, round_length, with_title


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 299), st.integers(0, 399)), max_size=40))
def test_every_mark_is_in_a_circle_of_bounded_size(points):
    marks = np.zeros((300, 400), np.bool_)
    for point in points:
        marks[point] = True

    spots = find_spots(marks)

    for v, u in points:
        assert any(np.hypot(u - s.centre[0], v - s.centre[1]) <= s.radius + 1 for s in spots)
    assert sum(spot.pixels for spot in spots) == marks.sum()
    assert all(spot.radius <= 45 for spot in spots)  # half the diagonal of a window, and the margin


def test_marks_near_each_other_are_one_place_and_far_ones_are_not():
    marks = np.zeros((300, 400), np.bool_)
    marks[100, 100:130] = marks[115, 110] = marks[250, 300] = True

    near, far = find_spots(marks)

    assert (near.pixels, far.pixels) == (31, 1)
    assert far.centre == pytest.approx((300, 250))


def test_only_the_fullest_places_are_circled():
    marks = np.zeros((900, 900), np.bool_)
    marks[50::200, 50::200] = True  # 25
    marks[50:54, 50] = True
    image = np.full((900, 900, 3), 255, np.uint8)

    circled = circle_spots(image, find_spots(marks))

    assert circled == MAX_CIRCLES
    assert find_spots(marks)[0].pixels == 4


def test_no_marks_make_no_circle():
    assert find_spots(np.zeros((50, 50), np.bool_)) == []


@given(st.floats(1e-6, 1e9))
def test_a_round_length_is_one_two_or_five_and_fills_its_room(most):
    length = round_length(most)

    assert 0.399 * most <= length <= most * (1 + 1e-9)
    assert f"{length:.0e}"[0] in "125"


@pytest.mark.parametrize("width", [60, 300, 1000])
def test_a_title_is_never_cut(width):
    title = "ambiguous: candidate 2 of 3, confidence 0.41"

    image = with_title(np.full((20, width, 3), 200, np.uint8), title)

    strip = image[: image.shape[0] - 20]
    assert (strip[:, -4:] == 255).all()
    assert (strip[-2:] == 255).all()
    assert image.shape[1] >= width
    assert (image[-20:, :width] == 200).all()


@pytest.mark.parametrize("at", [(2.0, 2.0), (2.0, 197.0), (297.0, 197.0), (150.0, 100.0), (-50.0, 900.0)])
def test_names_of_origins_at_one_place_do_not_cover_each_other(at):
    def drawn(*names):
        image = np.full((200, 300, 3), 128, np.uint8)
        axes = np.array([at, [1.0, 0.0], [0.0, -1.0]])
        draw_origins(image, {name: ((0, i, 200), axes) for i, name in enumerate("AB") if name in names})
        return (image[..., 2] == 200) & (image[..., 0] == 0)

    alone = drawn("A")
    assert alone.sum() > 50
    covered = alone & ~drawn("A", "B")
    assert covered.sum() < 0.5 * alone.sum()
