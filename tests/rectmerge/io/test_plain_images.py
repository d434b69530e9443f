import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rectmerge.errors import MapFileError
from rectmerge.io.map_file import read_image, read_map
from tests import drawing
from tests.rectmerge.io.map_files import GOOD_CELLS, write


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
    assert (
        read_map(drawing.DATA / "building_a.yaml").occupancy == read_map(drawing.DATA / "building_a.pgm").occupancy
    ).all()


@pytest.mark.real
@pytest.mark.parametrize("folder", ["real_lasers", "real_places"])
def test_every_real_map_reads_alike_from_yaml_and_from_its_image(folder):
    root = os.environ.get("RECTMERGE_REAL_MAPS")
    if not root:
        pytest.skip("RECTMERGE_REAL_MAPS does not name the folder of the real maps")
    files = sorted(Path(root, folder, "test/maps").glob("*.yaml"))

    assert files
    for file in files:
        assert (read_map(file).occupancy == read_map(file.with_suffix(".png")).occupancy).all(), file
