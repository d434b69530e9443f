import math
import os
import zlib
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from PIL import Image

from rectmerge.errors import MapFileError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import map_files, read_image, read_map, write_map
from tests import drawing

DATA = Path(__file__).parents[2] / "data"
KEYS = {
    "image": "map.pgm",
    "resolution": 0.05,
    "origin": [-1.0, 2.0, 0.5],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}
GOOD_PGM = b"P5\n4 3\n255\n" + bytes([0, 254, 254, 205, 0, 254, 254, 205, 0, 0, 0, 205])
GOOD_CELLS = [[100, 0, 0, -1], [100, 0, 0, -1], [100, 100, 100, -1]]


def write(folder: Path, *, image: bytes | None = GOOD_PGM, name: str = "map.pgm", **changes: object) -> Path:
    """Write a map as map_saver would, with some keys changed (None: left out)."""
    if image is not None:
        (folder / name).write_bytes(image)
    keys = {key: value for key, value in (KEYS | {"image": name} | changes).items() if value is not None}
    path = folder / "map.yaml"
    path.write_text(yaml.safe_dump(keys))
    return path


def save(folder: Path, array: np.ndarray, name: str = "map.png") -> Path:
    Image.fromarray(array).save(folder / name)
    return folder / name


# Reading what map_server reads.


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


@pytest.mark.parametrize("name", ["/home/robot/maps/map.pgm", "maps/map.pgm", r"C:\maps\map.pgm"])
def test_an_image_that_was_moved_beside_its_yaml_is_named_and_not_read(tmp_path, name):
    path = write(tmp_path, name=name, image=None)
    (tmp_path / "map.pgm").write_bytes(GOOD_PGM)

    with pytest.raises(MapFileError, match=r"no such file.*; map\.pgm is in the YAML's folder.* write image: map\.pgm"):
        read_map(path)


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


# Writing.

trinary = arrays(
    np.int8, array_shapes(min_dims=2, max_dims=2, min_side=2, max_side=9), elements=st.sampled_from([-1, 0, 100])
)
finite = st.floats(allow_nan=False, allow_infinity=False)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
@given(
    trinary.filter(lambda cells: (cells == 0).any()),
    st.none() | st.floats(min_value=0, exclude_min=True, allow_infinity=False),
    st.tuples(finite, finite, finite),
    st.sampled_from([".pgm", ".png"]),
)
def test_a_trinary_map_comes_back_bit_for_bit(tmp_path, cells, resolution, origin, suffix):
    write_map(OccupancyGrid(cells, resolution, origin), tmp_path / "m.yaml", image_suffix=suffix)

    back = read_map(tmp_path / "m.yaml")

    assert (back.occupancy == cells).all()
    assert (back.resolution, back.origin) == (resolution, origin)


@pytest.mark.parametrize("number", [np.float64(0.05), np.float32(0.05), np.int64(2)])
def test_a_resolution_may_be_a_number_of_numpys(tmp_path, number):
    write_map(OccupancyGrid(np.zeros((2, 2), np.int8), number, (number, number, number)), tmp_path / "m.yaml")

    assert read_map(tmp_path / "m.yaml").resolution == pytest.approx(float(number))


def test_writing_leaves_only_the_two_files(tmp_path):
    write_map(drawing.building(resolution=0.05), tmp_path / "m.yaml")

    assert sorted(p.name for p in tmp_path.iterdir()) == ["m.pgm", "m.yaml"]


def test_an_interrupted_write_leaves_the_old_map(tmp_path, monkeypatch):
    write_map(drawing.building(resolution=0.05), tmp_path / "m.yaml")
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    replace = Path.replace

    def fail(self: Path, target: Path) -> Path:
        if self.suffix == ".part":
            raise OSError(28, "No space left on device")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", fail)
    with pytest.raises(MapFileError, match=r"m\.pgm: cannot be written: No space left on device"):
        write_map(drawing.building(resolution=0.10), tmp_path / "m.yaml")

    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


@pytest.mark.parametrize("name", ["m.pgm", "m", "missing/m.yaml"])
def test_a_name_that_cannot_be_written_is_refused(tmp_path, name):
    with pytest.raises(MapFileError, match=name.split("/")[-1].split(".")[0]):
        write_map(drawing.building(), tmp_path / name)


# Bad input: one line that names the file and the remedy.


def bad_yaml(folder: Path, text: bytes) -> Path:
    path = folder / "map.yaml"
    path.write_bytes(text)
    return path


def bad_image(folder: Path, data: bytes, name: str = "map.pgm") -> Path:
    path = folder / name
    path.write_bytes(data)
    return path


def huge_png(folder: Path) -> Path:
    """Make a PNG whose header tells 2147483647 x 2147483647 pixels, with a right checksum."""
    save(folder, np.zeros((2, 2), np.uint8), "map.png")
    data = bytearray((folder / "map.png").read_bytes())
    data[16:24] = (2**31 - 1).to_bytes(4) * 2
    data[29:33] = zlib.crc32(bytes(data[12:29])).to_bytes(4)
    return bad_image(folder, bytes(data), "map.png")


BAD = {
    "missing": (lambda d: d / "map.yaml", "no such file"),
    "missing image": (lambda d: d / "map.png", "no such file"),
    "a name with a null": (lambda d: d / "m\0.png", "no such file"),
    "directory": (lambda d: d, "directory"),
    "image missing beside yaml": (lambda d: write(d, image=None), "no such file"),
    "image is a directory": (lambda d: write(d, image=None, name="."), "directory"),
    "empty yaml": (lambda d: bad_yaml(d, b""), "the file is empty"),
    "yaml of a list": (lambda d: bad_yaml(d, b"[1, 2]"), "not a map_server YAML"),
    "yaml with tabs": (lambda d: bad_yaml(d, b"image: a\n\tresolution: 1"), "not valid YAML: .*; use spaces, no tabs"),
    "yaml of garbage": (lambda d: bad_yaml(d, bytes(range(256))), "not valid YAML"),
    "yaml that runs code": (lambda d: bad_yaml(d, b"!!python/object/apply:os.system ['true']"), "not valid YAML"),
    "yaml nested deep": (lambda d: bad_yaml(d, b"[" * 3_000), "not valid YAML"),
    "yaml too long": (lambda d: bad_yaml(d, b"a" * 100_000), "more than 64 KB"),
    "no image key": (lambda d: write(d, image=None, name=None), "image must name"),
    "image is a number": (lambda d: write(d, image=None, name=7), "image must name"),
    "no resolution": (lambda d: write(d, resolution=None), "resolution is missing"),
    "resolution zero": (lambda d: write(d, resolution=0), "resolution must be > 0"),
    "resolution negative": (lambda d: write(d, resolution=-0.05), "resolution must be > 0"),
    "resolution nan": (lambda d: write(d, resolution=math.nan), "resolution must be a finite number"),
    "resolution text": (lambda d: write(d, resolution="fine"), "resolution must be a finite number"),
    "resolution true": (lambda d: write(d, resolution=True), "resolution must be a finite number"),
    "no origin": (lambda d: write(d, origin=None), r"origin must be \[x, y, yaw\], three numbers, got nothing"),
    "origin of two": (lambda d: write(d, origin=[1, 2]), r"origin must be \[x, y, yaw\].* got a list of 2"),
    "origin of six": (lambda d: write(d, origin=[0] * 6), r"origin must be \[x, y, yaw\].* got a list of 6"),
    "origin nan": (lambda d: write(d, origin=[0.0, math.nan, 0.0]), r"origin\[1\] must be a finite number"),
    "origin inf": (lambda d: write(d, origin=[0.0, 0.0, math.inf]), r"origin\[2\] must be a finite number"),
    "origin of lists": (lambda d: write(d, origin=[[0], 0, 0]), r"origin\[0\] must be a finite number"),
    "no threshold": (lambda d: write(d, free_thresh=None), "free_thresh is missing"),
    "thresholds swapped": (lambda d: write(d, free_thresh=0.8), "thresholds must satisfy"),
    "thresholds equal": (lambda d: write(d, free_thresh=0.65), "thresholds must satisfy"),
    "threshold above one": (lambda d: write(d, occupied_thresh=65), "thresholds must satisfy"),
    "threshold below zero": (lambda d: write(d, free_thresh=-0.1), "thresholds must satisfy"),
    "negate odd": (lambda d: write(d, negate=2), "negate must be 0 or 1"),
    "negate a list": (lambda d: write(d, negate=[0]), "negate must be 0 or 1"),
    "mode odd": (lambda d: write(d, mode="best"), "mode must be"),
    "empty file": (lambda d: bad_image(d, b""), "the file is empty"),
    "not an image": (lambda d: bad_image(d, b"hello, world"), "not an image"),
    "truncated PGM": (lambda d: bad_image(d, GOOD_PGM[:-4]), "truncated"),
    "truncated plain PGM": (lambda d: bad_image(d, b"P2 3 2 255 1 2 3"), "truncated"),
    "truncated header": (lambda d: bad_image(d, b"P5 3"), "truncated|not an image"),
    "absurd PGM": (lambda d: bad_image(d, b"P5 999999 999999 255\n0"), "million"),
    "absurdly long": (lambda d: bad_image(d, b"P5 3 40000 255\n" + bytes(120_000)), "a side may have 32766"),
    "absurd PNG": (huge_png, "million"),
    "one pixel": (lambda d: save(d, np.full((1, 1), 254, np.uint8)), "1 x 1 pixels"),
    "one pixel with yaml": (lambda d: write(d, image=b"P5 1 1 255\n\xfe"), "1 x 1 pixels"),
    "all unknown": (lambda d: write(d, image=b"P5 2 2 255\n" + bytes([205] * 4)), "all cells are unknown"),
    "no free cell": (lambda d: write(d, image=b"P5 2 2 255\n" + bytes([205, 0, 0, 0])), "no cell is free"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_that_names_the_file_and_what_is_wrong(tmp_path, case):
    make, wrong = BAD[case]
    path = make(tmp_path)

    with pytest.raises(MapFileError, match=wrong) as caught:
        read_map(path)

    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_truncated_png_is_refused(tmp_path):
    path = save(tmp_path, np.random.default_rng(0).integers(0, 255, (50, 50)).astype(np.uint8))
    path.write_bytes(path.read_bytes()[:-900])

    with pytest.raises(MapFileError, match="truncated"):
        read_map(path)


def test_a_file_without_permission_is_named(tmp_path, monkeypatch):
    path = write(tmp_path)

    def refuse(self: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", refuse)  # a chmod would not stop root
    with pytest.raises(MapFileError, match=r"map\.yaml: Permission denied; make the file readable"):
        read_map(path)


# Plain images.


def test_a_plain_image_has_no_resolution_even_if_a_yaml_beside_it_tells_one(tmp_path):
    write(tmp_path)

    grid, levels = read_image(tmp_path / "map.pgm", free=254, occupied=0, unknown=205)

    assert grid.resolution is None
    assert grid.occupancy.tolist() == GOOD_CELLS
    assert str(levels) == "free 254, occupied 0, unknown 205"


def test_levels_cannot_be_named_for_a_yaml(tmp_path):
    with pytest.raises(MapFileError, match="plain images"):
        read_map(write(tmp_path), free=254)


def test_transparent_pixels_are_unknown(tmp_path):
    grey = np.full((20, 20), 255, np.uint8)
    grey[5:15, [5, 14]] = grey[[5, 14], 5:15] = 0
    alpha = np.zeros((20, 20), np.uint8)
    alpha[5:15, 5:15] = 255
    Image.merge("LA", (Image.fromarray(grey), Image.fromarray(alpha))).save(tmp_path / "map.png")

    grid = read_map(tmp_path / "map.png")

    assert (grid.occupancy[alpha == 0] == -1).all()
    assert grid.free[6:14, 6:14].all()
    assert grid.occupied[5, 5:15].all()


def test_the_committed_map_reads_alike_from_yaml_and_from_its_image():
    assert (read_map(DATA / "building_a.yaml").occupancy == read_map(DATA / "building_a.pgm").occupancy).all()


@pytest.mark.real
def test_every_real_map_reads_alike_from_yaml_and_from_its_image():
    root = os.environ.get("RECTMERGE_REAL_MAPS")
    if not root:
        pytest.skip("RECTMERGE_REAL_MAPS does not name the folder of the real maps")
    files = sorted(Path(root, "real_lasers/test/maps").glob("*.yaml"))

    assert files
    for file in files:
        assert (read_map(file).occupancy == read_map(file.with_suffix(".png")).occupancy).all(), file
