import math
import os
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rectmerge.errors import InputError, MapFileError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import read_map, write_map
from sim.importers import import_world
from sim.motion.driving import PathPlanner, make_drive_field
from tests.drawing import DATA, building

HOUSE = DATA / "house.json"


def plan_image(path, *, walls=True, floor=True):
    """Draw a floor plan of 140 x 100 pixels: two rooms with a door between, and paper around."""
    image = np.full((100, 140), 255, np.uint8)
    if walls:
        image[10:90, 20:130] = 0
    if floor:
        image[14:86, 24:70] = image[14:86, 74:126] = image[40:60, 70:74] = 255
    Image.fromarray(image).save(path)
    return path


def test_a_ros_map_is_imported_cell_by_cell_and_the_same_each_time():
    world, again = (import_world(DATA / "building_a.yaml") for _ in range(2))
    grid = read_map(DATA / "building_a.yaml")
    known = np.argwhere(grid.occupied)
    (top, left), (bottom, right) = known.min(axis=0), known.max(axis=0) + 1

    assert (world.family, world.seed) == ("imported/building_a", 0)
    assert np.array_equal(world.raster(0.05).occupancy, grid.occupancy[top:bottom, left:right])
    assert world.to_json_dict() == again.to_json_dict()


def test_a_resolution_given_wins_over_the_one_in_the_file():
    assert import_world(DATA / "building_a.yaml", resolution=0.1).size == pytest.approx((14.1, 9.0))


def test_rooms_are_where_a_robot_can_stand_and_it_can_drive_between_them(tmp_path):
    write_map(building(resolution=0.2), tmp_path / "large.yaml")
    world = import_world(tmp_path / "large.yaml")
    planner = PathPlanner(make_drive_field(world))

    assert len(world.rooms) >= 9
    assert world.rooms[0].area_m2 == pytest.approx(60 * 38 * 0.04)
    for room in world.rooms:
        assert planner.path(world.rooms[0].spot, room.spot) is not None
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


@pytest.mark.real
@pytest.mark.parametrize(("folder", "resolution"), [("real_maps", 0.02), ("real_lasers", 0.05)])
def test_in_the_maps_of_every_real_place_a_robot_can_drive(folder, resolution):
    if not (home := os.environ.get("RECTMERGE_REAL_MAPS")):
        pytest.skip("RECTMERGE_REAL_MAPS does not name the folder that holds real_maps and real_lasers")
    stems = re.compile(r"(?!.*-hard$)(?!.*-0\.[678]_[ab]$)")  # one of four cuts of a log
    maps = sorted(p for p in Path(home, folder).glob("test/maps/*.png") if stems.match(p.stem))

    assert maps
    for path in maps:
        assert import_world(path, resolution=resolution).rooms, path.name
