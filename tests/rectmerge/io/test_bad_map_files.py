"""Bad input: one line that names the file and the remedy."""

import math
import zlib
from pathlib import Path

import numpy as np
import pytest

from rectmerge.errors import MapFileError
from rectmerge.io.map_file import read_map
from tests.rectmerge.io.map_files import GOOD_PGM, save, write


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
    "a key given twice": (
        lambda d: bad_yaml(d, b"image: a.pgm\nresolution: 1\nimage: b.pgm\n"),
        "the key 'image' is given twice; keep one",
    ),
    "threshold above one": (lambda d: write(d, occupied_thresh=65), "must lie in 0..1"),
    "threshold below zero": (lambda d: write(d, free_thresh=-0.1), "must lie in 0..1"),
    "more pixels than stated": (lambda d: bad_image(d, GOOD_PGM + b"\x07"), "more pixels than its header states"),
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
