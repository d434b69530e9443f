import json
import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import MapFileError
from sim.importers import import_world
from sim.importers.plans import world_from_plan
from sim.motion.driving import make_drive_field, nearest_drivable
from tests.drawing import DATA

HOUSE = DATA / "house.json"


def house(**changed):
    return {**json.loads(HOUSE.read_text()), **changed}


def test_a_json_plan_has_walls_around_its_outline_and_rooms_by_name():
    world = import_world(HOUSE, wall_m=0.2)
    floor = shapely.union_all([shapely.Polygon(outline) for outline in world.floor])
    walls = shapely.union_all([shapely.Polygon(wall.outline) for wall in world.walls])
    outline = shapely.Polygon(house()["verts"])
    field = make_drive_field(world)

    assert floor.area == pytest.approx(outline.area)
    assert walls.intersection(floor).area == pytest.approx(0.0, abs=1e-9)
    assert world.size == pytest.approx((9.2 + 0.4, 7.2 + 0.4))
    assert [room.name for room in world.rooms] == ["living room", "kitchen", "bedroom 1", "bedroom 2"]
    assert world.rooms[0].area_m2 == pytest.approx(4.65 * 4.65 - 1.1 * 1.1 / 2)  # a corner of its box is cut off
    for room in world.rooms:
        row, col = nearest_drivable(field, room.spot)
        assert np.hypot(*(np.array([col, row]) * 0.1 + 0.05 - room.spot)) < 1e-6


@pytest.mark.slow
@settings(deadline=None, max_examples=25)
@given(st.lists(st.floats(0.8, 6.0), min_size=5, max_size=12), st.floats(0.06, 0.4))
def test_any_outline_is_floor_within_and_wall_as_thick_as_asked_for_without(radii, wall_m):
    angles = np.arange(len(radii)) * 2 * np.pi / len(radii)
    corners = np.array(radii)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    world = world_from_plan({"verts": corners.tolist(), "room_category": {}}, "star", wall_m=wall_m)
    grid = world.raster(0.07)
    outline = shapely.Polygon(corners - corners.min(axis=0) + wall_m)
    v, u = np.indices(grid.shape)
    centres = grid.pixel_to_map(np.stack([u, v], axis=-1))
    spots = shapely.points(centres)
    inside, away = outline.contains(spots), outline.distance(spots)
    clear = outline.exterior.distance(spots) > 1e-6

    assert np.array_equal(grid.free[clear], inside[clear])
    assert grid.occupied[clear & ~inside & (away < wall_m - 1e-6)].all()
    # sharp corners are cut off at twice the thickness; the ends of the cut lie a thickness aside at the most
    assert not grid.occupied[away > math.hypot(2, 1) * wall_m + 1e-6].any()


def test_a_box_with_a_fold_in_it_becomes_the_largest_rectangle_beside_the_fold():
    verts = [[0, 0], [6, 0], [6, 4], [4, 4], [4, 1], [3.8, 1], [3.8, 4], [0, 4]]
    world = world_from_plan({"verts": verts, "room_category": {"Hall_Way": [[0, 0, 6, 4]]}}, "u", wall_m=0.1)

    assert [(room.name, room.area_m2) for room in world.rooms] == [("hall way", pytest.approx(3.8 * 4, rel=0.02))]


def test_a_plan_that_names_no_room_gets_the_large_rectangles_of_its_floor():
    world = world_from_plan(house(room_category={"Garage": [[50, 50, 60, 60]]}), "house", wall_m=0.15)

    assert len(world.rooms) >= 4


BAD_JSON = {
    "another schema": ({"type": "FeatureCollection"}, "the key verts is missing"),
    "no object": ([1, 2], "the key verts is missing"),
    "no rooms": ({"verts": [[0, 0], [5, 0], [5, 5]]}, "the key room_category is missing"),
    "no list": (house(verts=7), "three or more corners"),
    "two corners": (house(verts=[[0, 0], [5, 5]]), "three or more corners"),
    "three numbers": (house(verts=[[0, 0, 0]] * 4), "three or more corners"),
    "ragged": (house(verts=[[0, 0], [5], [5, 5]]), "list of corners"),
    "text": (house(verts=[["a", "b"]] * 3), "list of corners"),
    "empty": (house(verts=[]), "in metres"),
    "no number": (house(verts=[[0, 0], [5, 0], [5, math.nan]]), "in metres"),
    "too far": (house(verts=[[0, 0], [5, 0], [5, 1e300]]), "none beyond"),
    "a line": (house(verts=[[0, 0], [5, 5], [3, 3]]), "no area"),
    "in millimetres": (house(verts=[[0, 0], [5000, 0], [5000, 4000]]), "in metres"),
    "in kilometres": (house(verts=[[0, 0], [0.005, 0], [0.005, 0.004]]), "in metres"),
    "rooms are a list": (house(room_category=[[0, 0, 1, 1]]), "room_category"),
    "box of three": (house(room_category={"Kitchen": [[0, 0, 1]]}), "room_category.Kitchen"),
    "box of text": (house(room_category={"Kitchen": "here"}), "room_category.Kitchen"),
}


@pytest.mark.parametrize(("plan", "complaint"), BAD_JSON.values(), ids=BAD_JSON)
def test_a_plan_that_cannot_be_used_is_refused_with_what_is_wrong(tmp_path, plan, complaint):
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(plan))

    with pytest.raises(MapFileError, match=complaint) as error:
        import_world(path)
    assert str(error.value).startswith(str(path))
    assert "\n" not in str(error.value)
