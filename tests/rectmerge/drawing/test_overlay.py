import itertools
import math

import cv2
import numpy as np
import pytest

from rectmerge.drawing import annotation, overlay
from rectmerge.drawing import maps as picture
from rectmerge.drawing.overlay import draw_overlay
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from tests import drawing

TITLE_PX = 38
STRIPS_PX = 2 * picture.LEGEND_PX  # the legend in one row, and the scale bar
# G. M. Machado et al., TVCG 2009, DOI 10.1109/TVCG.2009.113: linear RGB as those see it who lack red or green cones.
VISION = {
    "normal": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
}


def count(image: np.ndarray, color: tuple[int, int, int]) -> int:
    return int((image[:-STRIPS_PX] == color).all(axis=-1).sum())


def room(*, box: tuple[slice, slice] | None = None, origin=(0.0, 0.0, 0.0), resolution=0.1) -> OccupancyGrid:
    """Draw a room of 60 x 80 cells without unknown space around it, with a box in it."""
    occupancy = np.zeros((60, 80), np.int8)
    occupancy[[0, -1]] = occupancy[:, [0, -1]] = 100
    if box:
        occupancy[box] = 100
    return OccupancyGrid(occupancy, resolution, origin)


FAR = (500.0, 500.0, 0.0)  # an origin that is an arrow at the border, away from what is looked at
BOX = np.s_[20:24, 30:34]
ZOOM = 14  # of that room: 1200 pixels less the margins over 80 cells


def test_an_overlay_of_a_map_on_itself_shows_agreement_only():
    a = drawing.building(origin=(500.0, 0.0, 0.0))

    image = draw_overlay(a, a, Similarity())

    zoom = 8 * 8  # 1200 pixels less the margins over 141 known cells, a multiple of a half
    assert count(image, overlay.BOTH) == pytest.approx(a.free.sum() * zoom, rel=0.01)  # less the arrows
    assert count(image, overlay.WALL_BOTH) == pytest.approx(a.occupied.sum() * zoom, rel=0.02)
    for color in (overlay.ONLY_A, overlay.ONLY_B, picture.CONFLICT):
        assert count(image, color) == 0


def test_an_overlay_shows_what_each_map_knows_alone():
    a = drawing.building()

    image = draw_overlay(a, a, Similarity(tx=500.0))

    assert count(image, overlay.ONLY_A) > 0
    assert count(image, overlay.ONLY_A) == pytest.approx(count(image, overlay.ONLY_B), rel=0.05)
    assert count(image, overlay.BOTH) == pytest.approx(0, abs=1500)  # the rims of letters and arrows are as white


def test_a_wrong_placement_shows_conflict_and_a_wall_beside_a_wall_does_not():
    a = drawing.building()

    assert count(draw_overlay(a, a, Similarity(angle=0.5)), picture.CONFLICT) > 1000
    assert count(draw_overlay(a, a, Similarity(tx=1.0)), picture.CONFLICT) == 0


@pytest.mark.parametrize("scale", [1e-3, 0.2, 1.0, 30.0, 1e4])
@pytest.mark.parametrize("side_px", [200, 1200])
def test_an_overlay_never_grows_beyond_its_size(scale, side_px):
    a = drawing.building()

    image = draw_overlay(a, a, Similarity(scale), side_px=side_px, title="accepted, confidence 0.97")

    rows = 7  # of legend and title, where it is narrow
    assert image.shape[1] <= max(side_px + 4, 300)  # the longest name in the legend
    assert image.shape[0] <= side_px + 4 + (rows + 1) * picture.LEGEND_PX + 66


@pytest.mark.slow
def test_large_and_small_maps_fill_the_picture():
    for size in (60, 400, 5000):
        a = OccupancyGrid(np.zeros((size, size), np.int8))
        assert 0.6 * picture.SIDE_PX <= draw_overlay(a, a, Similarity()).shape[1] <= picture.SIDE_PX + 2


def test_unknown_space_around_the_maps_is_cut_off():
    a = room(origin=FAR)
    padded = OccupancyGrid(np.pad(a.occupancy, 3000, constant_values=-1), 0.1, FAR)

    image = draw_overlay(padded, padded, Similarity())

    assert image.shape == draw_overlay(a, a, Similarity()).shape


@pytest.mark.parametrize("blank_first", [True, False])
def test_a_map_that_knows_nothing_is_drawn_too(blank_first):
    blank, a = OccupancyGrid(np.full((20, 30), -1, np.int8)), room()

    assert draw_overlay(*((blank, a) if blank_first else (a, blank)), Similarity()).size


def test_a_title_changes_only_its_own_strip():
    a, b = room(), room(box=BOX)

    without, titled = draw_overlay(a, b, Similarity()), draw_overlay(a, b, Similarity(), title="accepted")

    assert (titled[TITLE_PX:] == without).all()
    assert titled.shape[0] == without.shape[0] + TITLE_PX
    assert (titled[:TITLE_PX] < 100).any()
    assert (draw_overlay(a, b, Similarity(), title="rejected")[:TITLE_PX] != titled[:TITLE_PX]).any()


def test_a_conflict_is_circled_where_it_is_and_nothing_else_is():
    a, b = room(origin=FAR), room(box=BOX, origin=FAR)

    image, plain = (draw_overlay(a, other, Similarity())[:-STRIPS_PX] for other in (b, a))

    v, u = np.nonzero((image != plain).any(axis=-1) & (image != picture.CONFLICT).any(axis=-1))
    centre = overlay.MARGIN_PX + 32 * ZOOM, overlay.MARGIN_PX + 22 * ZOOM
    distance = np.hypot(u - centre[0], v - centre[1])
    assert distance.max() - distance.min() < 8  # a ring
    assert distance.min() > math.sqrt(2) * 2 * ZOOM  # around the whole box
    assert distance.max() < 5 * ZOOM


def test_the_origins_are_drawn_where_they_are():
    a, b = room(origin=(-2.0, -1.5, 0.0)), room(origin=(-5.0, -4.0, 0.5))

    image = draw_overlay(a, b, Similarity())

    for grid, color in ((a, picture.WALL_A), (b, picture.WALL_B)):
        for along in ([0.0, 0.0], [0.2, 0.0], [0.0, 0.2]):  # on the axes, whose length in pixels is that of 0.28 m
            u, v = np.rint(overlay.MARGIN_PX + ZOOM * (grid.map_to_pixel(along) + 0.5)).astype(int)
            assert (image[v - 2 : v + 3, u - 2 : u + 3] == color).all(axis=-1).any()


def test_an_origin_outside_is_an_arrow_at_the_border_that_points_to_it():
    a, b = room(origin=(-100.0, -3.0, 0.0)), room(origin=FAR)

    image = draw_overlay(a, b, Similarity())[:-STRIPS_PX]

    blue = (image == picture.WALL_A).all(axis=-1)
    assert blue[:, -8:].any()  # A's origin is far to the right
    assert not blue[:, :8].any()
    assert (image == picture.WALL_B).all(axis=-1)[-60:, :60].any()  # and B's to the lower left


def test_the_label_of_an_origin_outside_holds_its_distance_from_the_border(monkeypatch):
    labels = []
    monkeypatch.setattr(annotation, "_label", lambda image, text, *_: labels.append(text))
    b = room(origin=(-100.0, -3.0, 0.0))  # B's origin is 100 m to the right of its left side

    draw_overlay(room(), b, Similarity())

    margin_m = overlay.MARGIN_PX / ZOOM * 0.1
    assert f"origin B, {100 - 8 - margin_m:.3g} m off" in labels


@pytest.mark.parametrize("turn", [0.0, 0.3, 0.785, 2.5])
def test_walls_of_turned_maps_that_agree_are_drawn_in_the_one_colour_of_agreement(turn):
    a = drawing.building(origin=(500.0, 0.0, 0.0))
    middle = np.array(a.shape[::-1]) / 2
    turned = cv2.getRotationMatrix2D(middle.tolist(), math.degrees(turn), 1.0)
    cells = cv2.warpAffine(a.occupancy, turned, a.shape[::-1], flags=cv2.INTER_NEAREST, borderValue=-1)
    back = Similarity.from_matrix(cv2.invertAffineTransform(turned))

    image = draw_overlay(a, OccupancyGrid(cells, a.resolution, a.origin), back)

    alone = count(image, picture.WALL_A) + count(image, picture.WALL_B)
    assert alone < 0.12 * count(image, overlay.WALL_BOTH)  # the arrows, and what the turn cut off


@pytest.mark.parametrize(("resolution", "unit_px"), [(0.1, 10 * ZOOM), (None, ZOOM)])
def test_the_scale_bar_has_a_round_length_of_the_right_pixels(resolution, unit_px):
    a = room(resolution=resolution)

    strip = draw_overlay(a, a, Similarity())[-picture.LEGEND_PX :]

    row = (strip == 0).all(axis=-1)[picture.LEGEND_PX // 2 - 2]
    length = int(np.argmin(row[8:]))
    assert length / unit_px == pytest.approx(2 if resolution else 20, abs=2 / unit_px)


def test_the_colours_are_told_apart_whatever_the_colour_vision():
    areas = overlay.ONLY_A, overlay.ONLY_B, overlay.BOTH, picture.UNKNOWN_GREY
    lines = picture.WALL_A, picture.WALL_B, overlay.WALL_BOTH, picture.CONFLICT

    for vision in VISION.values():
        for one, other in itertools.combinations(areas, 2):
            assert difference(one, other, vision) > 9
        for line in lines:
            for other in (*areas, *(color for color in lines if color != line)):
                assert difference(line, other, vision) > 20


def difference(one, other, vision) -> float:
    """Return the distance of two colours in CIE L*a*b* as somebody sees them."""
    linear = (np.array([[one, other]]) / 255.0) ** 2.2
    seen = (linear @ np.transpose(vision)).clip(0, 1) ** (1 / 2.2)
    lab = cv2.cvtColor(seen.astype(np.float32), cv2.COLOR_RGB2LAB)[0]
    return float(np.linalg.norm(lab[0] - lab[1]))


def test_single_cells_as_noise_leaves_them_get_no_circle():
    cells = np.zeros((200, 200), np.int8)
    noisy = cells.copy()
    noisy[20:180:16, 20:180:16] = 100

    clean, specked = (draw_overlay(OccupancyGrid(cells), OccupancyGrid(each), Similarity()) for each in (cells, noisy))

    assert not (clean == 0).all(axis=2)[:-80].any()
    assert not (specked == 0).all(axis=2)[:-80].any()  # black is for circles here: no wall is of both maps
