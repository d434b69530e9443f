import io
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from PIL import Image

from rectmerge.io import image_file
from rectmerge.io.image_file import Pixels, encode_image, grey_counts, read_pixels, recode

IMAGES = arrays(np.uint8, array_shapes(min_dims=2, max_dims=2, max_side=9))


@given(IMAGES, st.integers(1, 40))
def test_greys_are_counted_band_by_band_as_by_numpy(image, cells_at_once):
    mask = image % 3 > 0
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(image_file, "CELLS_AT_ONCE", cells_at_once)

        assert np.array_equal(grey_counts(image), np.bincount(image.ravel(), minlength=256))
        assert np.array_equal(grey_counts(image[:, ::-1], mask[:, ::-1]), np.bincount(image[mask], minlength=256))


@given(IMAGES, st.integers(0, 2**32 - 1))
def test_codes_are_looked_up_as_by_numpy(image, seed):
    table = np.random.default_rng(seed).integers(-128, 128, 256).astype(np.int8)

    assert np.array_equal(recode(image[::-1], table), table[image[::-1]])


@pytest.mark.parametrize("suffix", [".pgm", ".png", ".bmp", ".jpg", ".tif", ".gif"])
def test_an_image_is_read_without_the_plug_ins_of_formats_that_are_no_maps(tmp_path, suffix):
    path = tmp_path / f"map{suffix}"
    Image.fromarray(np.full((4, 5), 254, np.uint8)).save(path)
    code = (
        "import sys, pathlib; from rectmerge.io.image_file import read_pixels; "
        "read_pixels(pathlib.Path(sys.argv[1])); assert 'PIL.WebPImagePlugin' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True)

    assert done.returncode == 0, done.stderr


@given(IMAGES)
def test_a_pgm_has_the_bytes_that_pillow_writes(image):
    encoded = io.BytesIO()
    Image.fromarray(image).save(encoded, format="PPM")

    assert encode_image(image, ".pgm") == encoded.getvalue()


def test_the_grey_of_a_grey_image_is_as_read_and_of_others_the_mean_of_the_channels(tmp_path):
    image = np.arange(256, dtype=np.uint8).reshape(16, 16)
    Image.fromarray(image).save(tmp_path / "grey.png")

    assert np.array_equal(read_pixels(tmp_path / "grey.png").grey, image)
    assert Pixels(np.array([[0, 382, 765]], np.uint16), 765, image).grey.tolist() == [[0, 127, 255]]
