import tomllib
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from rectmerge.errors import RectMergeError
from scenarios.gallery.world_view import (
    LEAST_HEIGHT,
    MOST_HEIGHT,
    WIDTH,
    describe_world,
    draw_world,
    find_world,
    list_families,
    write_picture,
)
from sim.floorplans import FAMILIES, Office
from sim.world import Door, Prism, World
from tests.drawing import DATA
from tests.marking import some_slow
from tests.sim.small_worlds import box_world

SQUARE = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]])


def test_a_family_is_made_from_the_seed_and_wins_over_a_file_of_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "office").mkdir()

    assert find_world("office", seed=3).seed == 3
    assert find_world("office").family == "office"


def test_families_are_listed_with_their_knobs_as_a_suite_reads_them():
    listed = list_families().splitlines()
    office = listed[listed.index(next(line for line in listed if line.startswith("office: "))) + 1]

    assert {line.partition(":")[0] for line in listed if line[0] != " "} >= set(FAMILIES)
    assert tomllib.loads(office.replace(", ", "\n").strip())["rooms"] == Office().rooms
    assert 'yaw_deg = "random"' in listed[-1]


@pytest.mark.parametrize("family", some_slow(FAMILIES, "office"))
def test_every_family_can_be_found_by_its_name(family):
    assert find_world(family).family == family


def test_a_file_becomes_the_world_it_holds():
    assert find_world(str(DATA / "house.json")).family == "imported/house"
    assert find_world(str(DATA / "building_a.pgm"), resolution=0.1).size == pytest.approx((14.1, 9.0))


def test_a_world_is_told_by_size_rooms_and_doors():
    ends = np.array([[1.0, 0.0], [2.0, 0.0]])
    doors = Door(ends, ("room", "outside")), Door(ends, ("room", "hall"), is_open=False)
    lines = describe_world(replace(box_world(), doors=doors)).splitlines()

    assert [line.split(maxsplit=1) for line in lines] == [
        ["world", "box, seed 0"],
        ["size", "6.0 x 4.0 m"],
        ["rooms", "1: room"],
        ["doors", "2, 1 of them shut"],
        ["drivable", "13 square metres"],
    ]
    assert "a robot fits nowhere" in describe_world(World(size=(2.0, 2.0), walls=()))


BAD = {
    "no such family": (["ofice", "x.png"], {}, "no family 'ofice'; there are: office"),
    "no such file": (["nowhere.yaml", "x.png"], {}, "no such file"),
    "a folder": (["..", "x.png"], {}, "is a directory"),
    "no picture named": (["office", None], {}, "-o PICTURE.png"),
    "no PNG": (["office", "x.jpg"], {}, "ends in .png"),
    "the map itself": (["map.png", "map.png"], {"resolution": 0.1}, "is the file itself"),
    "the map's image": (["map.yaml", "map.png"], {}, "is the file itself"),
    "pixels of a family": (["office", "x.png"], {"resolution": 0.1}, "leave out --resolution"),
    "seed of a file": (["map.yaml", "x.png"], {"seed": 1}, "leave out --seed"),
    "no resolution": (["map.png", "x.png"], {}, "--resolution"),
}


@pytest.mark.parametrize(("words", "options", "complaint"), BAD.values(), ids=BAD)
def test_what_cannot_be_drawn_is_refused_in_one_line(tmp_path, monkeypatch, words, options, complaint):
    monkeypatch.chdir(tmp_path)
    Image.open(DATA / "building_a.pgm").save("map.png")
    before = (DATA / "building_a.yaml").read_text().replace("building_a.pgm", "map.png")
    (tmp_path / "map.yaml").write_text(before)

    with pytest.raises(RectMergeError, match=complaint) as error:
        write_picture(words[0], words[1] and tmp_path / words[1], **options)
    assert "\n" not in str(error.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["map.png", "map.yaml"]


@pytest.mark.sim
def test_a_picture_is_as_tall_as_the_plan_asks_for_within_bounds():
    heights = [draw_world(box_world(*size)).shape[0] for size in ((40.0, 4.0), (12.0, 8.0), (4.0, 40.0))]

    assert heights[0] == LEAST_HEIGHT
    assert heights[2] == MOST_HEIGHT
    assert heights[1] == pytest.approx(WIDTH * 8 / 12, rel=0.1)


@pytest.mark.sim
def test_a_world_of_thousands_of_walls_is_drawn_whole():
    at = np.stack(np.meshgrid(np.arange(75), np.arange(75)), axis=-1).reshape(-1, 2) * 0.2
    world = World(size=(15.0, 15.0), walls=tuple(Prism(SQUARE + corner, 0.3) for corner in at))
    picture = draw_world(world)[..., 0].astype(float)

    bands = np.split(picture[300:-300, 300:-300][:600], 6)
    assert min(band.std() for band in bands) > 10  # posts everywhere


@pytest.mark.sim
def test_the_picture_is_written_and_shows_the_building(tmp_path):
    report = write_picture(str(DATA / "house.json"), tmp_path / "house.png")

    with Image.open(tmp_path / "house.png") as picture:
        assert picture.width == WIDTH
        assert np.asarray(picture).std() > 15
    assert report.splitlines()[-1].endswith("house.png")
