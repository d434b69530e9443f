"""The cells and the shades of the map that `merge` writes."""

import numpy as np
import pytest
from PIL import Image

from rectmerge.composing.compose import compose
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.io.dialects import Legend
from rectmerge.io.map_file import read_map, write_map
from rectmerge.io.map_yaml import read_header
from tests import drawing
from tests.rectmerge.cli.answers import YES_FILES, A, B, names, rectmerge, write_plain

pytestmark = pytest.mark.usefixtures("small_pictures")


@pytest.mark.parametrize(("cells", "size"), [("a", 0.05), ("b", 0.06), ("finer", 0.05), ("0.1", 0.1)])
def test_the_merged_map_has_the_cells_that_were_asked_for(tmp_path, answer, cells, size):
    answer("accepted")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--output-resolution", cells, "--rule", "newest") == 0

    assert read_map(tmp_path / "out" / "merged.yaml").resolution == pytest.approx(size)


@pytest.mark.parametrize(("rule", "shade"), [("log-odds", 82), ("evidence", 50)])
def test_the_shades_of_a_rule_are_read_back_as_they_were_made(tmp_path, answer, capsys, rule, shade):
    answer("accepted")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--rule", rule) == 0

    a, b = read_map(A), read_map(B)
    made = compose([a, b], [None, pixels_to_map_frame(drawing.B_IN_A, a, b)], rule=rule).grid.occupancy
    for dialect in ("nav2", "nav2-2024", "ros1"):
        assert np.array_equal(read_map(tmp_path / "out" / "merged.yaml", dialect=dialect).occupancy, made)
    assert (made == shade).any()
    assert names(tmp_path / "out") == YES_FILES
    assert "mode raw" in capsys.readouterr().out


def test_a_map_without_shades_is_written_as_map_saver_does(tmp_path, answer, capsys):
    answer("accepted")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out") == 0

    assert read_header(tmp_path / "out" / "merged.yaml").legend == Legend()
    with Image.open(tmp_path / "out" / "merged.pgm") as image:
        assert {grey for _, grey in image.getcolors()} == {0, 205, 254}
    assert "mode raw" not in capsys.readouterr().out


def test_by_other_rules_shades_of_the_maps_end_as_walls_or_unknown_which_costmaps_take_right(tmp_path, answer):
    answer("accepted")
    shaded = read_map(A)
    cells = np.where(shaded.occupied, 90, shaded.occupancy).astype(np.int8)
    write_map(OccupancyGrid(cells, shaded.resolution, shaded.origin), tmp_path / "a.yaml", legend=Legend(mode="raw"))

    assert rectmerge("merge", tmp_path / "a.yaml", B, "-o", tmp_path / "out") == 0

    assert read_header(tmp_path / "out" / "merged.yaml").legend == Legend()
    assert read_map(tmp_path / "out" / "merged.yaml").occupied.sum() >= shaded.occupied.sum()


@pytest.mark.parametrize("cells", ["c", "0", "-1", "nan"])
def test_cells_that_cannot_be_are_refused(tmp_path, capsys, cells):
    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--output-resolution", cells) == 2
    assert "a, b, finer or a positive number" in capsys.readouterr().err


def test_a_false_resolution_is_not_written(tmp_path, answer, capsys):
    answer("accepted")
    write_plain(tmp_path / "a.png")

    assert rectmerge("merge", tmp_path / "a.png", B, "-o", tmp_path / "out", "--output-resolution", "finer") == 2

    assert "its resolution is not known" in capsys.readouterr().err
    assert names(tmp_path / "out") == set()
