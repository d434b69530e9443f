import contextlib
import logging
import math
import sqlite3
import struct
import sys
from pathlib import Path

import numpy as np
import pytest

import rectmerge as rm
from rectmerge.errors import MapFileError
from rectmerge.io.bag_file import bag_files, is_bag, split_bag
from rectmerge.io.map_file import map_files, read_map
from tests.rectmerge import bags
from tests.rectmerge.bags import COMPRESSED, GRID, KINDS, LAID, MAP, TEXT, level


@pytest.mark.parametrize("kind", KINDS)
def test_a_map_is_read_upright_with_its_frame(tmp_path, kind):
    grid = rm.read_map(f"{bags.write(tmp_path, kind)}:/map")

    assert grid.occupancy.tolist() == [list(row) for row in LAID]
    assert grid.resolution == 0.05
    assert grid.origin == pytest.approx((1.0, -2.0, 0.5), abs=1e-12)
    assert grid.frame == "map"


@pytest.mark.parametrize(
    ("frame_id", "frame"), [("robot1/map", "robot1/map"), ("/robot1/map", "robot1/map"), ("", None)]
)
def test_a_frame_is_named_as_tf2_names_it(tmp_path, frame_id, frame):
    assert read_map(bags.write(tmp_path, "bag", [("/map", GRID, {"frame": frame_id})])).frame == frame


@pytest.mark.parametrize("kind", ["db3", "mcap"])
def test_a_storage_file_is_read_without_its_folder(tmp_path, kind):
    alone = bags.storage(bags.write(tmp_path, kind)).rename(tmp_path / f"run.{kind}")

    assert rm.read_map(f"{alone}:/map").occupancy.tolist() == [list(row) for row in LAID]
    assert rm.read_map(Path(alone)).origin[0] == 1.0


@pytest.mark.parametrize(("kind", "compression"), COMPRESSED.values(), ids=COMPRESSED)
def test_compressed_bags_are_read(tmp_path, kind, compression):
    bag = bags.write(tmp_path, kind, compression=compression)

    assert read_map(f"{bag}:/map").occupancy.tolist() == [list(row) for row in LAID]


def test_the_tables_of_the_first_distributions_are_read(tmp_path):
    """They tell no definitions of their types; written here without rosbags."""
    head = struct.pack("<BBBB iI I4s", 0, 1, 0, 0, 5, 0, 4, b"map\0")  # CDR, little-endian: header
    info = struct.pack("<iI f II 4x 7d", 5, 0, 0.1, 3, 2, 4.0, 5.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    cells = struct.pack("<I6b", 6, 0, 0, 100, -1, 0, 100)  # the bottom row first
    with contextlib.closing(sqlite3.connect(tmp_path / "old.db3")) as base:
        base.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)")
        base.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
        base.execute("INSERT INTO topics VALUES (1, '/map', ?, 'cdr')", [GRID])
        base.execute("INSERT INTO messages VALUES (1, 1, 7, ?)", [head + info + cells])
        base.commit()
    grid = read_map(tmp_path / "old.db3")

    assert grid.occupancy.tolist() == [[-1, 0, 100], [0, 0, 100]]
    assert (grid.resolution, grid.origin) == (0.1, (4.0, 5.0, 0.0))


@pytest.mark.parametrize("kind", KINDS)
def test_the_newest_map_wins(tmp_path, kind):
    old, new = ("/robot1/map", GRID, {"at": (0.0, 0.0, 0.0)}), ("/robot1/map", GRID, {"at": (7.0, 0.0, 0.0)})
    bag = bags.write(tmp_path, kind, [old, ("/robot2/map", GRID, {}), new, ("/chat", TEXT, {})])

    assert read_map(f"{bag}:/robot1/map").origin[0] == 7.0
    assert read_map(f"{bags.storage(bag)}:robot1/map/").origin[0] == 7.0


@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_alone_is_enough_where_one_topic_holds_maps(tmp_path, kind):
    bag = bags.write(tmp_path, kind, [("/chat", TEXT, {}), MAP], silent=["/costmap"])

    assert read_map(bag).origin[0] == 1.0


TURNS = {
    "none": (level(0.0), 0.0),
    "clockwise": (level(-2.0), -2.0),
    "the other sign": (tuple(-part for part in level(0.7)), 0.7),
    "half a turn": (level(math.pi), math.pi),
    "not of length one": (tuple(3.0 * part for part in level(0.3)), 0.3),
    "never set": ((0.0, 0.0, 0.0, 0.0), 0.0),
    "nearly level": ((1e-4, -1e-4, 0.0, 1.0), 0.0),
}


@pytest.mark.parametrize(("turn", "yaw"), TURNS.values(), ids=TURNS)
def test_yaw_comes_from_the_quaternion(tmp_path, turn, yaw):
    yaw_read = read_map(bags.write(tmp_path, "mcap", [("/map", GRID, {"turn": turn})])).origin[2]

    assert math.remainder(yaw_read - yaw, math.tau) == pytest.approx(0.0, abs=1e-9)


def test_cells_that_mean_nothing_are_unknown(tmp_path):
    cells = [[-128, -2, -1, 0], [1, 100, 101, 127]]

    assert read_map(bags.write(tmp_path, "db3", [("/map", GRID, {"cells": cells})])).occupancy.tolist() == [
        [-1, -1, -1, 0],
        [1, 100, -1, -1],
    ]


ROOM = np.zeros((4, 5), np.int8)
WRONG = {
    "a tilted map": ({"turn": (0.1, 0.0, 0.0, 1.0)}, "must lie level"),
    "an upturned map": ({"turn": (1.0, 0.0, 0.0, 0.0)}, "must lie level"),
    "no quaternion": ({"turn": (0.0, 0.0, math.nan, 1.0)}, "must be finite"),
    "no position": ({"at": (math.inf, 0.0, 0.0)}, "three finite numbers"),
    "no resolution": ({"resolution": 0.0}, "resolution must be a positive number"),
    "an absurd resolution": ({"resolution": math.nan}, "resolution must be a positive number"),
    "too few cells": ({"size": (5, 9)}, "12 cells are not the stated 5 x 9"),
    "no cells": ({"cells": np.zeros((0, 0))}, "0 x 0 cells are no map"),
    "a line": ({"cells": np.zeros((1, 40))}, "40 x 1 cells are no map"),
    "too many cells": ({"size": (20_000, 20_000)}, "there may be 150 million, 32766 on a side: crop it"),
    "too long a side": ({"size": (2, 40_000)}, "32766 on a side"),
    "nothing known": ({"cells": ROOM - 1}, "all cells are unknown; is it the right topic"),
    "nothing free": ({"cells": ROOM + 100}, "no cell is free"),
}


@pytest.mark.parametrize(("changes", "reason"), WRONG.values(), ids=WRONG)
@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_a_map_that_cannot_be_used_is_refused_by_bag_and_topic(tmp_path, kind, changes, reason):
    bag = bags.write(tmp_path, kind, [("/map", GRID, changes)])
    with pytest.raises(MapFileError, match=reason) as refused:
        read_map(f"{bag}:/map")

    assert str(refused.value).startswith(f"{bag}:/map: ")
    assert "\n" not in str(refused.value)


TOPICS = {
    "no such topic": (":/mapp", "there is no topic /mapp; its maps are on /a/map, /b/map"),
    "another type": (":/chat", f"/chat holds {TEXT}; its maps are on /a/map, /b/map"),
    "several": ("", "its maps are on /a/map, /b/map; name one, as in "),
    "no message": (":/silent", "there is no message on /silent; record it"),
}


@pytest.mark.parametrize(("topic", "reason"), TOPICS.values(), ids=TOPICS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_topic_without_a_map_is_refused_with_those_there_are(tmp_path, kind, topic, reason):
    maps = [("/a/map", GRID, {}), ("/b/map", GRID, {}), ("/chat", TEXT, {})]
    with pytest.raises(MapFileError, match=reason):
        read_map(f"{bags.write(tmp_path, kind, maps, silent=['/silent'])}{topic}")


@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_without_maps_says_so(tmp_path, kind):
    bag = bags.write(tmp_path, kind, [("/chat", TEXT, {})])
    for name in (bag, f"{bag}:/map"):
        with pytest.raises(MapFileError, match="it holds no nav_msgs/OccupancyGrid at all"):
            read_map(name)


@pytest.mark.parametrize("kind", KINDS)
def test_an_empty_bag_is_refused(tmp_path, kind):
    with pytest.raises(MapFileError, match=r"it holds no nav_msgs/OccupancyGrid at all|broken, truncated"):
        read_map(f"{bags.write(tmp_path, kind, [])}:/map")


def test_without_rosbags_the_remedy_is_named(tmp_path, monkeypatch):
    bag = bags.write(tmp_path, "mcap")
    monkeypatch.setitem(sys.modules, "rosbags", None)

    with pytest.raises(MapFileError, match=r"made_mcap: .*pip install 'rectmerge\[ros\]'"):
        read_map(f"{bag}:/map")


def test_grey_levels_are_not_for_bags(tmp_path):
    with pytest.raises(MapFileError, match="grey levels are for plain images; a bag holds cells"):
        read_map(f"{bags.write(tmp_path, 'bag')}:/map", free=254)


def test_names_of_maps_in_bags_are_told_from_files(tmp_path):
    bag = bags.write(tmp_path, "mcap")
    names = {
        "run.mcap:/robot1/map": ("run.mcap", "/robot1/map"),
        "a:b/run.db3:/map": ("a:b/run.db3", "/map"),
        "run.bag:map": ("run.bag", "map"),
        "run.bag:": ("run.bag", None),
        "run.bag": ("run.bag", None),
        f"{bag}:/map/": (str(bag), "/map"),
        str(bag): (str(bag), None),
    }
    for name, (file, topic) in names.items():
        assert split_bag(name) == split_bag(Path(name)) == (Path(file), topic), name
    for name in ("map.yaml", "map:1.png", ":/map", "nowhere:/map", str(tmp_path), "x" * 5000, "a\0b", ""):
        assert not is_bag(name)


def test_the_files_of_a_map_are_those_of_its_bag(tmp_path):
    bag = bags.write(tmp_path, "mcap")

    assert {file.name for file in map_files(f"{bag}:/map")} == {"metadata.yaml", "made_mcap.mcap"}
    assert map_files("run.bag:/map") == (Path("run.bag"),)
    assert bag_files("run.bag") == (Path("run.bag"),)


def test_reading_a_bag_says_nothing(tmp_path, caplog):
    with caplog.at_level(logging.DEBUG):
        read_map(f"{bags.write(tmp_path, 'db3')}:/map")

    assert caplog.records == []
