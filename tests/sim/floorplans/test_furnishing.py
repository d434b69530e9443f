import itertools

import numpy as np
import pytest
from shapely.geometry import Point, Polygon

from sim.floorplans import pieces
from sim.floorplans.drafting import Pen
from sim.floorplans.furnishing import DOOR_WAY_M, Furnisher
from sim.floorplans.pieces import Model, Piece
from sim.floorplans.shapes import rectangle

MAKERS = [*pieces.AT_WALL, *pieces.STANDING, lambda _: pieces.bed(), lambda _: pieces.block(1.0, 0.5, 1.2)]


def room_with_a_door(way=0.5, turned=0.0):
    pen = Pen(np.random.default_rng(3), size_m=(9.0, 7.0), wall_m=(0.2, 0.2), door_m=(0.9, 0.9), glass=0.0)
    pen.room("room", rectangle(1.0, 1.0, 8.0, 6.0))
    pen.wall([(1.0, 1.0), (8.0, 1.0)], pen.door(0.0, 7.0, "room", "outside"))
    pen.block(rectangle(4.0, 3.0, 4.5, 3.5))
    pen.way_m, pen.turned = way, turned
    return pen


@pytest.mark.parametrize("maker", MAKERS)
@pytest.mark.parametrize("seed", range(3))
def test_the_parts_of_a_piece_lie_within_its_outline(maker, seed):
    model = maker(np.random.default_rng(seed))
    outline = Polygon(model.outline).buffer(0.3)  # chairs may stand askew

    assert all(outline.contains(Polygon(part.outline)) for part in model.parts)
    assert model.outline[:, 1].min() == pytest.approx(0.0, abs=0.05)
    assert any(part.bottom <= 0.25 < part.top for part in model.parts)


def test_a_placed_model_keeps_its_shape():
    model = pieces.bed()
    put = model.placed(np.array([3.0, 4.0]), np.array([0.6, 0.8]))

    assert Polygon(put.outline).area == pytest.approx(Polygon(model.outline).area)
    assert np.allclose(put.outline[0], [3.0, 4.0])
    assert np.allclose(put.outline[1] - put.outline[0], 0.95 * np.array([0.6, 0.8]))


@pytest.mark.parametrize("turned", [0.0, 1.0])
def test_furniture_stands_in_its_room_clear_of_doors_pillars_and_each_other(turned):
    pen = room_with_a_door(turned=turned)
    placed = list(Furnisher(pen).furnish(pen.rooms[0], 5.0))
    shapes = [Polygon(piece.put.outline) for piece in placed]
    inside = Polygon(rectangle(1.1, 1.1, 7.9, 5.9)).buffer(0.021)

    assert len(shapes) >= 4
    assert all(map(inside.contains, shapes))
    assert all(shape.distance(Point(pen.doors[0].centre)) > DOOR_WAY_M - 0.01 for shape in shapes)
    assert all(shape.distance(Polygon(pen.blocks[0])) > 0.5 for shape in shapes)
    assert all(one.distance(other) > 0.5 for one, other in itertools.combinations(shapes, 2))


def test_another_place_is_clear_of_what_stands_there():
    pen = room_with_a_door()
    furnisher = Furnisher(pen)
    first = furnisher.place("room", pieces.block(1.0, 0.5, 1.2), is_at_wall=True)
    moved = furnisher.find_another_place(first)

    assert Polygon(first.put.outline).distance(Polygon(moved.put.outline)) > 0.5
    assert moved.model is first.model


def test_spare_places_are_used_first_and_once():
    pen = room_with_a_door()
    model = Model((), rectangle(0.0, 0.0, 1.0, 1.0))
    pen.spares = [Piece("racks", model, model)]
    furnisher, pallet = Furnisher(pen), Piece("racks", model, model)

    assert furnisher.find_another_place(pallet) is pen.spares[0]
    assert furnisher.find_another_place(pallet) is None


def test_a_piece_too_large_for_its_room_finds_no_place():
    pen = room_with_a_door()

    assert Furnisher(pen).place("room", pieces.block(9.0, 1.0, 1.0), is_at_wall=True) is None
