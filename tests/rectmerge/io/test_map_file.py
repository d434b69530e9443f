import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rectmerge.errors import MapFileError
from rectmerge.io.map_file import map_files, read_map
from tests.rectmerge.io.map_files import GOOD_CELLS, GOOD_PGM, save, write


def test_a_ros_map_is_read_with_its_frame(tmp_path):
    grid = read_map(write(tmp_path))

    assert grid.occupancy.tolist() == GOOD_CELLS
    assert (grid.resolution, grid.origin) == (0.05, (-1.0, 2.0, 0.5))


@pytest.mark.parametrize(
    "image",
    [
        b"P5\n# made by hand\n4 3\n# more\n255\n" + GOOD_PGM[-12:],
        b"P2\n# plain\n4 3\n255\n0 254 254 205\n0 254 254 205\n0 0 0 205\n",
        b"P2 4 3 65535 0 65278 65278 52685 0 65278 65278 52685 0 0 0 52685\n",
        b"P5 4 3 65535\n" + b"".join(bytes([v, v]) for v in GOOD_PGM[-12:]),
        b"P2 4 3 100 0 100 100 80 0 100 100 80 0 0 0 80\n",
    ],
    ids=["P5 with comments", "P2", "P2 16 bit", "P5 16 bit", "P2 to 100"],
)
def test_every_kind_of_pgm_gives_the_same_cells(tmp_path, image):
    assert read_map(write(tmp_path, image=image)).occupancy.tolist() == GOOD_CELLS


@pytest.mark.parametrize("mode", ["L", "RGB", "RGBA", "P", "LA", "I;16"])
def test_every_kind_of_png_gives_the_same_cells(tmp_path, mode):
    grey = Image.fromarray(np.frombuffer(GOOD_PGM[-12:], np.uint8).reshape(3, 4))
    if mode == "I;16":
        grey = Image.fromarray(np.asarray(grey).astype(np.uint16) * 257)
    (grey if mode == "I;16" else grey.convert(mode)).save(tmp_path / "map.png")

    assert read_map(write(tmp_path, image=None, name="map.png")).occupancy.tolist() == GOOD_CELLS


def test_colour_channels_are_averaged(tmp_path):
    pixels = np.array([[[255, 255, 250], [255, 0, 0]], [[250, 255, 255], [0, 255, 255]]], np.uint8)
    save(tmp_path, pixels)

    grid = read_map(write(tmp_path, image=None, name="map.png"))

    assert grid.occupancy.tolist() == [[0, 100], [0, -1]]  # red is 170 of 255 dark: occupied; cyan 85: between


def test_the_savers_unknown_stays_unknown_where_the_threshold_would_turn_it_free(tmp_path, caplog):
    path = write(tmp_path, free_thresh=0.25)

    grid = read_map(path)

    assert grid.occupancy.tolist() == GOOD_CELLS
    assert f"{path}: free_thresh 0.25" in caplog.text


def save_with_clear_unknown(folder: Path) -> None:
    grey = np.frombuffer(GOOD_PGM[-12:], np.uint8).reshape(3, 4)
    save(folder, np.dstack([grey, np.where(grey == 205, 0, 255).astype(np.uint8)]))


def test_a_grey_that_is_only_where_nothing_is_seen_is_no_trap(tmp_path, caplog):
    save_with_clear_unknown(tmp_path)

    for keys in ({"mode": "scale"}, {"free_thresh": 0.25}):
        assert read_map(write(tmp_path, image=None, name="map.png", **keys)).occupancy.tolist() == GOOD_CELLS
    assert not caplog.text


@pytest.mark.parametrize(
    ("keys", "remedy"),
    [
        ({"free_thresh": 0.25}, "free_thresh: 0.196 mends it"),
        ({"mode": "scale"}, "mode: trinary with free_thresh: 0.196 mends it"),
    ],
)
def test_what_is_said_to_mend_the_trap_mends_it(tmp_path, caplog, keys, remedy):
    read_map(write(tmp_path, **keys))
    assert remedy in caplog.text
    caplog.clear()

    assert read_map(write(tmp_path)).occupancy.tolist() == GOOD_CELLS  # mode trinary and free_thresh 0.196
    assert not caplog.text


@pytest.mark.parametrize("name", ["/home/robot/maps/map.pgm", r"C:\maps\map.pgm"])
def test_an_image_named_by_a_path_of_another_machine_is_read_beside_its_yaml_with_a_note(tmp_path, caplog, name):
    caplog.set_level("INFO", logger="rectmerge")
    path = write(tmp_path, name=name, image=None)
    (tmp_path / "map.pgm").write_bytes(GOOD_PGM)

    assert read_map(path).occupancy.tolist() == GOOD_CELLS
    assert map_files(path) == (path, tmp_path / "map.pgm")
    assert caplog.messages == [f"{path}: {name} is not there; map.pgm beside it is read"]


@pytest.mark.parametrize(
    ("name", "beside", "hint"),
    [
        ("maps/map.pgm", "map.pgm", "map.pgm is in the YAML's folder: if it is the map's, write image: map.pgm"),
        ("old.pgm", "map.png", "map.png has the YAML's name: if it is the map's, write image: map.png"),
    ],
)
def test_a_file_that_may_be_the_missing_image_is_named_and_not_read(tmp_path, name, beside, hint):
    path = write(tmp_path, name=name, image=None)
    (tmp_path / beside).write_bytes(GOOD_PGM)

    with pytest.raises(MapFileError, match=f"no such file.*; {re.escape(hint)}"):
        read_map(path)


def test_tabs_between_words_are_read_as_map_servers_do(tmp_path):
    path = write(tmp_path)
    text = path.read_text().replace("resolution: 0.05", "resolution:\t0.05 \t# metres").replace("\n", "\t\n")
    path.write_text(text)

    assert "\t" in text
    assert read_map(path).occupancy.tolist() == GOOD_CELLS


@pytest.mark.parametrize(
    ("dialect", "keys", "row"),  # of the greys 254, 128 and 0, occupied to 0.004, 0.498 and 1
    [
        ("nav2", {"free_thresh": 0.5, "occupied_thresh": 0.5}, [0, 0, 100]),
        ("nav2", {"free_thresh": 0.65, "occupied_thresh": 0.2}, [0, 0, 100]),  # both: free
        ("nav2-2024", {"free_thresh": 0.65, "occupied_thresh": 0.2}, [0, 100, 100]),  # both: occupied
        ("ros1", {"free_thresh": 0.65, "occupied_thresh": 0.2}, [0, 100, 100]),
        ("ros1", {"free_thresh": 0.65, "occupied_thresh": 0.2, "mode": "scale"}, [0, 100, 100]),
        ("nav2", {"free_thresh": 0.65, "occupied_thresh": 0.2, "mode": "scale"}, [0, 0, 100]),
    ],
)
def test_equal_and_reversed_thresholds_are_read_as_map_servers_do_with_a_note(tmp_path, caplog, dialect, keys, row):
    path = write(tmp_path, image=b"P5 3 2 255\n" + bytes([254, 128, 0] * 2), **keys)

    assert read_map(path, dialect=dialect).occupancy.tolist() == [row, row]
    assert "is not below occupied_thresh" in caplog.text


def test_the_trap_is_found_where_an_editor_left_stray_pixels_beside_205(tmp_path, caplog):
    pixels = np.full((100, 100), 205, np.uint8)
    pixels[40:60, 40:60] = 254
    pixels[0, :50], pixels[1, :34], pixels[40, 40:60] = 204, 206, 0
    save(tmp_path, pixels)

    grid = read_map(write(tmp_path, image=None, name="map.png", free_thresh=0.25))

    assert grid.free.sum() == 380 + 84  # strokes keep their own greys
    assert "it is kept unknown" in caplog.text


def test_a_map_that_reads_nearly_all_free_is_named_with_the_grey_that_may_be_unknown(tmp_path, caplog):
    pixels = np.full((100, 100), 210, np.uint8)
    pixels[40:60, 40:60] = 254
    pixels[40, 40:60] = 0
    save(tmp_path, pixels)

    read_map(write(tmp_path, image=None, name="map.png"))

    assert "100 % of it reads free, most of it grey 210: if that is unknown space, lower free_thresh" in caplog.text


def test_the_file_is_obeyed_where_that_is_asked_for(tmp_path, caplog):
    grid = read_map(write(tmp_path, free_thresh=0.25), strict_thresholds=True)

    assert grid.occupancy[:, 3].tolist() == [0, 0, 0]
    assert not caplog.text


@pytest.mark.parametrize(
    ("pixels", "changes"),
    [
        ([0, 253, 253, 205], {}),  # not what savers write for free
        ([0, 254, 204, 205], {}),  # a shade among others
        ([0, 254, 254, 205], {"negate": 1, "occupied_thresh": 0.9}),
        ([0, 254, 254, 205], {"mode": "raw"}),
        ([0, 254, 254, 205], {"free_thresh": 0.15}),  # unknown all the same
    ],
)
def test_other_files_are_taken_at_their_word(tmp_path, caplog, pixels, changes):
    path = write(tmp_path, image=b"P5 2 2 255\n" + bytes(pixels), **({"free_thresh": 0.25} | changes))

    assert np.array_equal(read_map(path).occupancy, read_map(path, strict_thresholds=True).occupancy)
    assert not caplog.text


@pytest.mark.parametrize(("grey", "cell"), [(205, -1), (206, 0), (89, 100), (90, -1)])
def test_thresholds_cut_exactly_where_map_server_cuts(tmp_path, grey, cell):
    # occupied if (255 - grey) / 255 >= 0.65, that is grey <= 89.25; free if <= 0.196, that is grey >= 205.02
    grid = read_map(write(tmp_path, image=b"P5 2 2 255\n" + bytes([254, 254, 254, grey])))

    assert grid.occupancy[1, 1] == cell


def test_negate_swaps_dark_and_light(tmp_path):
    inverted = GOOD_PGM[:-12] + bytes(255 - v for v in GOOD_PGM[-12:])

    assert read_map(write(tmp_path, image=inverted, negate=1)).occupancy.tolist() == GOOD_CELLS


def test_scale_mode_grades_what_lies_between_the_thresholds(tmp_path):
    path = write(tmp_path, image=b"P5 2 2 255\n" + bytes([255, 0, 127, 255]), mode="scale", free_thresh=0.0)
    occupied = (255 - 127) / 255

    assert read_map(path).occupancy.tolist() == [[0, 100], [round(100 * occupied / 0.65), 0]]
    assert read_map(path, dialect="ros1").occupancy.tolist() == [[1, 100], [int(1 + 98 * occupied / 0.65), 1]]


def test_raw_mode_takes_greys_as_occupancy(tmp_path):
    path = write(tmp_path, image=b"P5 2 2 255\n" + bytes([0, 100, 40, 255]), mode="raw")

    assert read_map(path).occupancy.tolist() == [[0, 100], [40, -1]]


CARTOGRAPHERS = b"P5\n# Cartographer map; 0.05 m/pixel\n3 2\n255\n" + bytes([128, 90, 128, 160, 145, 128])


def test_cartographers_image_is_read_by_its_own_rules_unless_told_otherwise(tmp_path, caplog):
    path = write(tmp_path, image=CARTOGRAPHERS)
    caplog.set_level("INFO", logger="rectmerge")

    assert read_map(path).occupancy.tolist() == [[-1, 100, -1], [0, 0, -1]]
    assert "Cartographer" in caplog.text
    with pytest.raises(MapFileError, match="all cells are unknown"):  # by map_saver's thresholds nearly all is unknown
        read_map(path, dialect="nav2")


def test_the_image_is_looked_for_beside_the_yaml(tmp_path, monkeypatch):
    (tmp_path / "maps").mkdir()
    path = write(tmp_path, image=None, name="maps/map.pgm")
    (tmp_path / "maps" / "map.pgm").write_bytes(GOOD_PGM)
    monkeypatch.chdir("/")

    assert read_map(path).occupancy.tolist() == GOOD_CELLS
    assert map_files(path) == (path, tmp_path / "maps" / "map.pgm")


def test_numbers_that_yaml_takes_for_text_are_read(tmp_path):
    path = write(tmp_path)
    path.write_text(path.read_text().replace("0.05", "5e-2"))

    assert read_map(path).resolution == 0.05


def test_null_is_a_resolution_that_is_not_known(tmp_path):
    path = write(tmp_path)
    path.write_text(path.read_text().replace("0.05", "null"))

    assert read_map(path).resolution is None
