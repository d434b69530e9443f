import json
import math
import os
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from PIL import Image

from rectmerge.errors import InputError, MapFileError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import read_map, write_map
from sim.importers import import_world
from sim.importers.grids import MOST_WALLS, world_from_grid
from sim.importers.plans import world_from_plan
from sim.motion.driving import Ways, drivable, nearest_drivable
from tests.drawing import DATA, building
from tests.sim import naive

HOUSE = DATA / "house.json"
CELLS = arrays(np.int8, array_shapes(min_dims=2, max_dims=2, max_side=9), elements=st.sampled_from([-1, 0, 0, 100]))


def plan_image(path, *, walls=True, floor=True):
    """A floor plan of 140 x 100 pixels: two rooms with a door between, and paper around."""
    image = np.full((100, 140), 255, np.uint8)
    if walls:
        image[10:90, 20:130] = 0
    if floor:
        image[14:86, 24:70] = image[14:86, 74:126] = image[40:60, 70:74] = 255
    Image.fromarray(image).save(path)
    return path


def house(**changed):
    return {**json.loads(HOUSE.read_text()), **changed}


@settings(deadline=None, max_examples=60)
@given(CELLS, st.sampled_from([0.34, 0.5, 1.0]), st.sampled_from([0.0, 1.0, 1.7]))
def test_the_raster_of_a_map_is_the_map_with_its_open_ends_walled_off(cells, resolution, narrowest_m):
    narrowest_cells = 1 + 2 * int(narrowest_m / resolution / 2)
    padded = np.pad(cells, 1, constant_values=-1)
    known = {cell for cell in np.ndindex(padded.shape) if padded[cell] >= 0}
    assume(any(naive._is_wide(cell, known, narrowest_cells) for cell in known if padded[cell] == 0))

    world = world_from_grid(OccupancyGrid(cells, resolution), "made", narrowest_m=narrowest_m)

    assert np.array_equal(world.raster(resolution).occupancy, naive.walled_off(cells, narrowest_cells))


def test_a_ros_map_is_imported_cell_by_cell_and_the_same_each_time():
    world, again = (import_world(DATA / "building_a.yaml") for _ in range(2))
    grid = read_map(DATA / "building_a.yaml")
    known = np.argwhere(grid.occupied)
    (top, left), (bottom, right) = known.min(axis=0), known.max(axis=0) + 1

    assert (world.family, world.seed) == ("imported/building_a", 0)
    assert np.array_equal(world.raster(0.05).occupancy, grid.occupancy[top:bottom, left:right])
    assert world.as_dict() == again.as_dict()


def test_a_resolution_given_wins_over_the_one_in_the_file():
    assert import_world(DATA / "building_a.yaml", resolution=0.1).size == pytest.approx((14.1, 9.0))


def test_rooms_are_where_a_robot_can_stand_and_it_can_drive_between_them(tmp_path):
    write_map(building(resolution=0.2), tmp_path / "large.yaml")
    world = import_world(tmp_path / "large.yaml")
    ways = Ways(drivable(world))

    assert len(world.rooms) >= 9
    assert world.rooms[0].area_m2 == pytest.approx(60 * 38 * 0.04)
    for room in world.rooms:
        assert ways.path(world.rooms[0].spot, room.spot) is not None
    assert not import_world(tmp_path / "large.yaml", resolution=0.012).rooms  # a robot fits nowhere in a doll's house


def test_specks_are_dropped_where_asked_for(tmp_path):
    cells = np.zeros((40, 40), np.int8)
    cells[20, 20] = cells[10, 30:33] = 100
    write_map(OccupancyGrid(cells, 0.1), tmp_path / "speck.yaml")

    kept, dropped = (import_world(tmp_path / "speck.yaml", max_speck_cells=n).raster(0.1).occupied for n in (0, 1))
    assert kept.sum() - dropped.sum() == 1


@pytest.mark.parametrize("suffix", [".png", ".pgm", ".bmp"])
def test_of_a_floor_plan_dark_is_wall_light_inside_floor_and_light_around_outside(tmp_path, suffix):
    world = import_world(plan_image(tmp_path / f"plan{suffix}"), resolution=0.05)
    grid = world.raster(0.05)

    assert world.size == pytest.approx((5.5, 4.0))
    assert grid.free.sum() == 72 * 46 + 72 * 52 + 20 * 4
    assert not grid.unknown.any()
    assert len(world.rooms) == 2


def test_a_slanted_wall_of_single_pixels_is_tight(tmp_path):
    y, x = np.mgrid[:61, :61]
    image = np.where(abs(y - 30) + abs(x - 30) == 25, 0, 255).astype(np.uint8)
    Image.fromarray(image).save(tmp_path / "diamond.png")

    grid = import_world(tmp_path / "diamond.png", resolution=0.1).raster(0.1)
    assert grid.free.sum() == (abs(y - 30) + abs(x - 30) < 25).sum()


def test_an_image_with_a_third_grey_is_a_map(tmp_path):
    image = np.full((60, 60), 205, np.uint8)
    image[10:50, 10:50] = 254
    image[10:50, 10] = image[10, 10:50] = 0
    Image.fromarray(image).save(tmp_path / "map.png")

    grid = import_world(tmp_path / "map.png", resolution=0.1).raster(0.1)
    assert grid.shape == (41, 41)  # the two open sides got a wall
    assert grid.occupied.sum() == 4 * 40


def test_a_json_plan_has_walls_around_its_outline_and_rooms_by_name():
    world = import_world(HOUSE, wall_m=0.2)
    floor = shapely.union_all([shapely.Polygon(outline) for outline in world.floor])
    walls = shapely.union_all([shapely.Polygon(wall.outline) for wall in world.walls])
    outline = shapely.Polygon(house()["verts"])
    field = drivable(world)

    assert floor.area == pytest.approx(outline.area)
    assert walls.intersection(floor).area == pytest.approx(0.0, abs=1e-9)
    assert world.size == pytest.approx((9.2 + 0.4, 7.2 + 0.4))
    assert [room.name for room in world.rooms] == ["living room", "kitchen", "bedroom 1", "bedroom 2"]
    assert world.rooms[0].area_m2 == pytest.approx(4.65 * 4.65 - 1.1 * 1.1 / 2)  # a corner of its box is cut off
    for room in world.rooms:
        row, col = nearest_drivable(field, room.spot)
        assert np.hypot(*(np.array([col, row]) * 0.1 + 0.05 - room.spot)) < 1e-6


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


BAD_FILES = {
    "missing": ("nowhere.yaml", "no such file"),
    "a folder": (".", "is a directory"),
    "another kind": ("notes.txt", r"a map or an image .* or from a plan \(.json\)"),
    "not JSON": ("broken.json", "not JSON"),
    "no text": ("bytes.json", "not JSON"),
    "deep": ("deep.json", "nested too deeply"),
    "no image": ("broken.png", "not an image"),
    "white paper": ("white.png", "one grey level"),
    "no rooms": ("black.png", "no light area is enclosed"),
    "open": ("open.png", "close the outer walls"),
    "one map's image": ("building.pgm", "give building.yaml beside it"),
    "no resolution": ("unknown.yaml", "--resolution"),
    "no floor": ("strip.yaml", "no free space wider than 0.25 m"),
}


@pytest.mark.parametrize(("name", "complaint"), BAD_FILES.values(), ids=BAD_FILES)
def test_a_file_that_makes_no_world_is_refused_with_the_remedy(tmp_path, name, complaint):
    for text in ("notes.txt", "broken.json", "broken.png"):
        (tmp_path / text).write_text("no such thing")
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe\x00{")
    (tmp_path / "deep.json").write_text("[" * 100_000)
    plan_image(tmp_path / "white.png", walls=False)
    plan_image(tmp_path / "black.png", floor=False)
    opened = np.asarray(Image.open(plan_image(tmp_path / "open.png"))).copy()
    opened[40:60, 15:30] = opened[20:30, 65:80] = 255
    Image.fromarray(opened).save(tmp_path / "open.png")
    write_map(building(), tmp_path / "unknown.yaml")
    write_map(building(resolution=0.05), tmp_path / "building.yaml")
    write_map(
        OccupancyGrid(np.where(np.arange(30) == 4, 0, -1)[None].repeat(30, 0).astype(np.int8), 0.1),
        tmp_path / "strip.yaml",
    )

    with pytest.raises(MapFileError, match=complaint) as error:
        import_world(tmp_path / name)
    assert str(tmp_path) in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"resolution": 0.0}, "resolution"),
        ({"resolution": math.inf}, "resolution"),
        ({"resolution": 10.0}, "is the resolution 10 right"),
        ({"resolution": 1e-3}, "no free space wider"),
        ({"narrowest_m": -0.1}, "narrowest_m"),
        ({"max_speck_cells": -1}, "max_speck_cells"),
    ],
)
def test_options_out_of_range_are_refused(options, complaint):
    with pytest.raises(InputError, match=complaint):
        import_world(DATA / "building_a.yaml", **options)


@pytest.mark.parametrize(("options", "complaint"), [({"wall_m": 0.0}, "wall_m"), ({"resolution": 0.1}, "in metres")])
def test_options_that_do_not_fit_a_plan_are_refused(options, complaint):
    with pytest.raises(InputError, match=complaint):
        import_world(HOUSE, **options)


def test_a_map_of_too_many_walls_is_refused_rather_than_left_to_the_engine():
    cells = np.indices((400, 200)).sum(axis=0) % 2 * 100

    with pytest.raises(InputError, match=f"more than {MOST_WALLS}"):
        world_from_grid(OccupancyGrid(cells.astype(np.int8), 0.1), "chess")


@pytest.mark.real
@pytest.mark.parametrize(("folder", "resolution"), [("real_maps", 0.02), ("real_lasers", 0.05)])
def test_in_every_real_map_a_robot_can_drive(folder, resolution):
    if not (home := os.environ.get("RECTMERGE_REAL_MAPS")):
        pytest.skip("RECTMERGE_REAL_MAPS does not name the folder that holds real_maps and real_lasers")
    maps = sorted(p for p in Path(home, folder).glob("test/maps/*.png") if not p.stem.endswith("-hard"))

    assert maps
    for path in maps:
        assert import_world(path, resolution=resolution).rooms, path.name
