"""Readers of files that nobody should have written: a map, or one line that names the file."""

import io
import os
import struct
import zlib

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from PIL import Image

from rectmerge.cli import console
from rectmerge.errors import MapFileError
from rectmerge.io.map_file import map_files, read_map
from tests.fuzz.commands import run
from tests.marking import some_slow

KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode")
PGM = b"P5\n4 3\n255\n" + bytes([0, 254, 205, 254, 254, 254, 254, 0, 205, 0, 254, 254])
GOOD = {
    "image": "map.pgm",
    "resolution": 0.05,
    "origin": [0.0, 0.0, 0.0],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
    "mode": "trinary",
}
LAUGHS = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{new}: &{new} [*{old}, *{old}, *{old}, *{old}, *{old}, *{old}, *{old}, *{old}, *{old}]\n"
    for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)
DOCUMENTS = {
    "aliases that multiply": LAUGHS + "image: *i\n",
    "an alias to itself": "image: map.pgm\norigin: &o [*o, 0, 0]\nresolution: 1\noccupied_thresh: 1\nfree_thresh: 0\n",
    "a tag of Python": "image: !!python/object/apply:os.system ['true']\n",
    "a tag that does not fit": "image: map.pgm\nresolution: !!timestamp x\n",
    "a bool that is none": "negate: !!bool x\n",
    "a huge hexadecimal": "image: map.pgm\nresolution: 0x" + "f" * 20_000 + "\n",
    "a huge decimal": "image: map.pgm\nresolution: " + "9" * 20_000 + "\n",
    "a huge negate": "image: map.pgm\nresolution: 1\nnegate: 0b" + "1" * 20_000 + "\n",
    "base sixty": "image: map.pgm\nresolution: 190:20:30\norigin: [1:2, 3:4, 5:6]\nfree_thresh: 0\n",
    "depth": "[" * 5000,
    "a long name": "image: " + "x" * 50_000 + "\n",
    "no text": "\x00\x01\x02",
    "half an escape": 'image: "\\ud800"\nresolution: 1\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.1\n',
}


def said(path):
    """Read a map; return the line that refuses it, empty where it is read."""
    try:
        read_map(path)
    except MapFileError as error:
        return str(error)
    return ""


def is_clear(line, path):
    """Whether a file was read, or refused in one line that names it."""
    return not line or (str(path) in line and "\n" not in line)


@pytest.fixture
def beside(tmp_path):
    (tmp_path / "map.pgm").write_bytes(PGM)
    return tmp_path


@pytest.mark.parametrize("name", some_slow(DOCUMENTS, *(set(DOCUMENTS) - {"depth"})))
def test_hostile_yaml_is_refused_in_one_line(beside, name):
    (beside / "map.yaml").write_text(DOCUMENTS[name], encoding="utf-8", errors="surrogatepass")

    line = said(beside / "map.yaml")
    assert line
    assert is_clear(line, beside / "map.yaml")
    assert run("inspect", beside / "map.yaml", "-o", beside / "p.png") == console.BAD_INPUT


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.binary(max_size=4) | st.dates(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=5,
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.dictionaries(st.sampled_from(KEYS), VALUES, max_size=7))
def test_random_values_are_read_or_refused(beside, changes):
    (beside / "map.yaml").write_text(yaml.safe_dump(GOOD | changes))

    assert is_clear(said(beside / "map.yaml"), beside / "map.yaml")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_damaged_files_are_read_or_refused(beside, data):
    for name, whole in (("map.yaml", yaml.safe_dump(GOOD).encode()), ("map.pgm", PGM), ("map.png", png(4, 3))):
        damaged = bytearray(whole)
        for _ in range(data.draw(st.integers(1, 4))):
            damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
        cut = data.draw(st.integers(0, len(damaged)))
        (beside / f"damaged-{name}").write_bytes(damaged[:cut] if data.draw(st.booleans()) else damaged)

        assert is_clear(said(beside / f"damaged-{name}"), beside / f"damaged-{name}")


def flipped(data, bit):
    """Data with one bit flipped."""
    damaged = bytearray(data)
    damaged[bit // 8] ^= 1 << bit % 8
    return bytes(damaged)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("form", "options", "unseen"),
    [("PNG", {}, 0), ("TIFF", {"compression": "tiff_adobe_deflate"}, 2)],  # Adler-32 is weak on short data
)
def test_a_bit_flipped_under_a_checksum_changes_no_cell_unseen(tmp_path, form, options, unseen):
    grey = np.random.default_rng(0).choice(np.array([0, 205, 254], np.uint8), (12, 20))
    written, path = io.BytesIO(), tmp_path / "map.img"
    Image.fromarray(grey).save(written, form, **options)
    whole = written.getvalue()
    path.write_bytes(whole)
    cells = read_map(path).occupancy
    with Image.open(path) as image:
        first, length = (0, len(whole)) if form == "PNG" else (image.tag_v2[273][0], image.tag_v2[279][0])

    changed = 0
    for bit in range(8 * first, 8 * (first + length)):
        path.write_bytes(flipped(whole, bit))
        changed += not said(path) and not np.array_equal(read_map(path).occupancy, cells)
    assert changed <= unseen


@pytest.mark.parametrize("form", ["PPM", "BMP", "GIF", "JPEG"])
def test_a_file_without_checksums_that_is_cut_or_goes_on_is_refused(tmp_path, form):
    grey = np.random.default_rng(1).choice(np.array([0, 205, 254], np.uint8), (24, 32))
    written = io.BytesIO()
    Image.fromarray(grey).save(written, form)
    whole, path = written.getvalue(), tmp_path / "map.img"
    for damaged in (whole[:-40], whole[:-1]) + ((whole + b"more",) if form in ("PPM", "BMP") else ()):
        path.write_bytes(damaged)
        assert "broken or truncated" in said(path)


def png(width, height, pixels=None):
    """A grey PNG whose header tells this size; its pixels are zeros, packed, unless given."""
    rows = bytes(height * (width + 1)) if pixels is None else pixels
    parts = [(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)), (b"IDAT", zlib.compress(rows, 9))]
    chunks = [
        struct.pack(">I", len(d)) + t + d + struct.pack(">I", zlib.crc32(t + d)) for t, d in (*parts, (b"IEND", b""))
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


@pytest.mark.parametrize(
    ("width", "height"), [(60_000, 60_000), (2**31 - 1, 2**31 - 1), (200_000, 2), (20_000, 20_000)]
)
def test_bombs_are_refused_by_their_header(tmp_path, width, height):
    (tmp_path / "bomb.png").write_bytes(png(width, height, b"\0"))

    assert "crop" in said(tmp_path / "bomb.png") or "a side may have" in said(tmp_path / "bomb.png")


def test_a_bomb_within_the_limit_that_holds_less_than_it_tells_is_refused(tmp_path):
    (tmp_path / "bomb.png").write_bytes(png(12_000, 12_000, b"\0"))

    assert "broken or truncated" in said(tmp_path / "bomb.png")


def saved(mode, form, **options):
    image = Image.fromarray(np.array([[0, 254, 205, 254]] * 4, np.uint8)).convert(mode)
    written = io.BytesIO()
    image.save(written, form, **options)
    return written.getvalue()


IMAGES = {
    "P2": b"P2\n# plain\n4 2\n15\n0 15 12 15\n15 15 15 0\n",
    "maxval 1": b"P5 4 2 1\n" + bytes([0, 1, 1, 1, 1, 1, 1, 0]),
    "maxval 65535": b"P5 2 2 65535\n" + bytes([0, 0, 255, 255, 255, 255, 205, 205]),
    "a negative size": b"P5 -4 3 255\n" + bytes(12),
    "no size": b"P5\n",
    "an ascii number without end": b"P5 " + b"9" * 5000,
    "an animation": saved("P", "GIF", save_all=True, append_images=[Image.new("P", (4, 4))]),
    "cmyk": saved("CMYK", "JPEG"),
    "pages": saved("L", "TIFF", save_all=True, append_images=[Image.new("L", (4, 4))]),
    "floats": saved("F", "TIFF"),
    "one bit": saved("1", "PNG"),
    "palette": saved("P", "PNG", transparency=0),
    "grey and alpha": saved("LA", "PNG"),
    "nothing": b"",
}


@pytest.mark.parametrize("name", IMAGES)
def test_every_kind_of_image_is_read_or_refused(tmp_path, name):
    (tmp_path / "image").write_bytes(IMAGES[name])

    assert is_clear(said(tmp_path / "image"), tmp_path / "image")


@pytest.mark.parametrize(
    "image", ["../../../../etc/passwd", "/etc/passwd", ".", "/dev/zero", "fifo", "loop", "dangling"]
)
def test_images_that_are_none_are_refused_without_waiting(beside, image):
    os.mkfifo(beside / "fifo")
    (beside / "loop").symlink_to(beside / "loop")
    (beside / "dangling").symlink_to(beside / "nowhere")
    (beside / "map.yaml").write_text(yaml.safe_dump(GOOD | {"image": image}))

    line = said(beside / "map.yaml")
    assert line
    assert "root:" not in line  # of what is no image nothing is shown
    assert map_files(beside / "map.yaml")


def test_an_image_elsewhere_or_behind_a_link_is_read(beside):
    (beside / "inner").mkdir()
    (beside / "link.pgm").symlink_to(beside / "map.pgm")
    (beside / "inner" / "map.yaml").write_text(yaml.safe_dump(GOOD | {"image": "../link.pgm"}))

    assert not said(beside / "inner" / "map.yaml")
