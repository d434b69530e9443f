import math

import numpy as np
import pytest

from rectmerge.composing.compose import compose
from rectmerge.drawing import maps as picture
from rectmerge.grid import OccupancyGrid
from rectmerge.rectangles import Rectangle
from rectmerge.similarity import Similarity
from tests import drawing


def count(image: np.ndarray, color: tuple[int, int, int], *, legend: bool = False) -> int:
    shown = image if legend else image[: -picture.LEGEND_PX]
    return int((shown == color).all(axis=-1).sum())


def test_thin_walls_survive_in_the_picture_of_a_large_map():
    occupancy = np.zeros((3000, 3000), np.int8)
    occupancy[1000] = 100

    image = picture.draw_map(OccupancyGrid(occupancy))

    assert (image == 0).all(axis=-1).any(axis=0).all()


def test_the_conflict_picture_marks_where_the_maps_differ():
    free = np.zeros((60, 60), np.bool_)
    free[5:55, 5:55] = True
    a = drawing.grid_of(free)
    with_box = np.array(a.occupancy)
    with_box[20:30, 20:30] = 100

    image = picture.draw_conflict(compose([a, OccupancyGrid(with_box)], [None, Similarity()]))

    zoom = min(picture.LARGEST_ZOOM, picture.SIDE_PX // 60)
    assert count(image, picture.CONFLICT) == (10 * zoom + 2) ** 2
    assert (image[25 * zoom, 25 * zoom] == picture.CONFLICT).all()


def test_rectangles_are_drawn_where_they_are():
    a = drawing.building()

    image = picture.draw_rectangles(a, [Rectangle(12, 12, 60, 38)], numbered=0)
    plain = picture.draw_map(a)

    changed = (image != plain).any(axis=-1)
    rows, cols = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
    assert (cols[0], rows[0], cols[-1] + 1, rows[-1] + 1) == (12 * 7, 12 * 7, 72 * 7, 50 * 7)


def test_only_the_first_rectangles_are_numbered():
    a = drawing.building()
    boxes = [Rectangle(*room) for room in drawing.ROOMS]

    none, first, all_six = (picture.draw_rectangles(a, boxes, numbered=n) for n in (0, 1, 6))

    x, y, w, h = (7 * v for v in drawing.ROOMS[0])
    differs = (first != none).any(axis=-1)
    assert differs[y : y + h, x : x + w].any()
    assert differs.sum() == differs[y : y + h, x : x + w].sum()
    assert (all_six != first).any()


def test_the_axes_point_where_the_turn_takes_them():
    a = OccupancyGrid(np.zeros((100, 100), np.int8))

    image = picture.draw_parallels(a, [], math.radians(-30.0))[: -picture.LEGEND_PX]

    v, u = np.argwhere((image == picture.CONFLICT).all(axis=-1)).T
    right = np.argmax(u)  # the tip of the first axis: 30 degrees up, to be turned down by 30
    middle = image.shape[0] / 2
    assert math.degrees(math.atan2(middle - v[right], u[right] - middle)) == pytest.approx(30, abs=2)


def test_a_series_is_drawn_with_its_direction_in_the_legend():
    a = drawing.building()
    boxes = [Rectangle(*room) for room in drawing.ROOMS]

    image = picture.draw_series(a, boxes, {"right": [0, 1, 2], "down": [0, 3]})

    assert count(image, picture.SERIES[0]) > 100
    assert count(image, picture.SERIES[1]) > 100
    assert count(image, picture.SERIES[2], legend=True) == 0


def test_a_triangle_joins_the_centres_of_its_rectangles():
    a = drawing.building()
    boxes = [Rectangle(*room) for room in drawing.ROOMS[:3]]

    green = (picture.draw_triangle(a, boxes) == picture.GREEN).all(axis=-1)

    centres = np.array([box.centre for box in boxes])
    for one, other in ((0, 1), (1, 2), (2, 0)):
        u, v = np.rint(7 * (0.75 * centres[one] + 0.25 * centres[other]) + 3).astype(int)
        assert green[v - 4 : v + 5, u - 4 : u + 5].any()


def test_pictures_beside_each_other_keep_their_pixels():
    small, large = np.full((40, 50, 3), 7, np.uint8), np.full((60, 80, 3), 9, np.uint8)

    image = picture.side_by_side([small, large, small], ["", "", ""])

    assert count(image, (7, 7, 7), legend=True) == 2 * 40 * 50
    assert count(image, (9, 9, 9), legend=True) == 60 * 80


def test_a_legend_takes_more_rows_where_the_picture_is_narrow_and_is_never_cut():
    entries = {f"colour number {i}": (i, 50, 50) for i in range(5)}

    wide, narrow, tiny = (picture.with_legend(np.zeros((10, width, 3), np.uint8), entries) for width in (1200, 400, 10))

    assert wide.shape == (10 + picture.LEGEND_PX, 1200, 3)
    assert narrow.shape == (10 + 3 * picture.LEGEND_PX, 400, 3)
    assert tiny.shape[0] == 10 + 5 * picture.LEGEND_PX
    for image in (wide, narrow, tiny):
        assert (image[10:, -2:] == 255).all()
        assert all((image == color).all(axis=-1).any() for color in entries.values())
