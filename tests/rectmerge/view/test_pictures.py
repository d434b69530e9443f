import base64
import io

import numpy as np
import pytest
from PIL import Image

from rectmerge.grid import OccupancyGrid
from rectmerge.view.pictures import PALETTES, draw_pair
from tests import drawing


def opened(address):
    return Image.open(io.BytesIO(base64.b64decode(address.partition(",")[2]))).convert("RGBA")


def test_a_picture_has_a_colour_for_each_kind_of_cell_and_unknown_is_clear():
    grid = drawing.building()

    drawn = draw_pair(grid, grid, 1024)

    for name, (free, occupied) in PALETTES.items():
        seen = np.asarray(opened(drawn[name]))
        m = np.reshape(drawn[f"to_{name}"], (2, 3))
        assert m[:, :2] == pytest.approx(np.eye(2))
        left, top = m[:, 2].astype(int)
        cut = (slice(top, top + seen.shape[0]), slice(left, left + seen.shape[1]))
        for mask, colour in ((grid.free, free), (grid.occupied, occupied)):
            assert {f"#{bytes(pixel[:3]).hex().upper()}" for pixel in seen[mask[cut]]} == {colour}
        assert not seen[grid.unknown[cut]][:, 3].any()


def test_a_large_map_is_shrunk_and_the_way_back_is_told():
    large = OccupancyGrid(np.kron(drawing.building().occupancy, np.ones((10, 10), np.int8)))

    drawn = draw_pair(large, drawing.building(), 256)

    assert max(drawn["size"][:2]) <= 256
    corners = np.reshape(drawn["to_a"], (2, 3)) @ [[0, drawn["size"][0] - 1], [0, drawn["size"][1] - 1], [1, 1]]
    rows, cols = np.nonzero(~large.unknown)
    assert corners[:, 0] == pytest.approx([cols.min(), rows.min()], abs=5)
    assert corners[:, 1] == pytest.approx([cols.max(), rows.max()], abs=5)


def test_the_hull_is_around_all_that_is_known():
    triangle = np.tri(20, dtype=bool)
    grid = OccupancyGrid(np.where(triangle, 0, -1).astype(np.int8))

    drawn = draw_pair(drawing.building(), grid, 1024)

    assert sorted(drawn["hull_b"]) == [[0, 0], [0, 19], [19, 19]]


def test_specks_that_shrinking_leaves_unknown_still_have_a_place():
    cells = np.full((400, 400), -1, np.int8)
    cells[0, 0] = cells[-1, -1] = 0
    grid = OccupancyGrid(cells)

    drawn = draw_pair(grid, grid, 100)

    assert sorted(drawn["hull_b"]) == [[0, 0], [0, 99], [99, 0], [99, 99]]
