"""What pixels mean to the programs that read map_server images, grey by grey, and the way back."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rectmerge.errors import InputError, MapFileError
from rectmerge.grid import OccupancyGrid
from rectmerge.io.dialects import Legend, grey_levels, occupancy_table, read_cells
from rectmerge.io.image_file import Pixels
from rectmerge.io.map_file import read_map, write_map
from rectmerge.io.map_yaml import read_header

GOLDEN = json.loads((Path(__file__).parents[2] / "data" / "dialects.json").read_text(encoding="utf-8"))["tables"]
NAV2_TESTS = {  # nav2_map_server/test/unit/test_map_io.cpp: grey -> cell
    ("scale", False): {0: 100, 89: 100, 90: 99, 147: 50, 204: 1, 205: 0, 255: 0},
    ("scale", True): {0: 0, 108: 50, 165: 99, 166: 100, 255: 100},
    ("trinary", False): {89: 100, 90: -1, 147: -1, 205: -1, 206: 0},
}


def legend_of(golden):
    return Legend(**{key: golden[key] for key in ("mode", "negate", "free_thresh", "occupied_thresh")})


def opaque(grey, alpha=None):
    luma = np.array(grey, np.uint8)
    return Pixels(luma.astype(np.uint16), 255, luma, None if alpha is None else np.array(alpha, np.uint8))


@pytest.mark.parametrize("golden", GOLDEN, ids=lambda t: f"{t['dialect']}-{t['mode']}-{t['negate']}-{t['free_thresh']}")
def test_every_grey_means_what_the_program_makes_of_it(golden):
    wanted = np.empty(256, int)
    for first, value in golden["runs"]:
        wanted[first:] = value

    assert occupancy_table(legend_of(golden), golden["dialect"]).tolist() == wanted.tolist()


@pytest.mark.parametrize(("mode", "negate"), NAV2_TESTS)
def test_nav2s_own_tests_hold(mode, negate):
    table = occupancy_table(Legend(mode=mode, negate=negate))

    assert {grey: table[grey] for grey in NAV2_TESTS[mode, negate]} == NAV2_TESTS[mode, negate]


def test_nav2_counts_a_grey_at_the_threshold_in_single_precision():
    table = occupancy_table(Legend(occupied_thresh=129 / 255))  # as nav2's loadClassifiesThresholdBoundaryExactly

    assert (table[126], table[127]) == (100, -1)


def test_cartographers_grey_is_a_probability():
    table = occupancy_table(Legend(), "cartographer")

    assert (table[128], table[127], table[115], table[153], table[140]) == (-1, -1, 100, 0, 0)
    assert np.array_equal(occupancy_table(Legend(negate=True), "cartographer"), table[::-1])


@pytest.mark.parametrize(
    ("dialect", "mode", "wanted"),
    [
        ("nav2", "trinary", [[100, -1], [-1, -1]]),
        ("nav2", "scale", [[100, 0], [-1, -1]]),
        ("nav2-2024", "trinary", [[100, 0], [-1, 100]]),  # (3 * 205 + 255) / 4 = 217.5 is free
        ("nav2-2024", "scale", [[100, 0], [-1, -1]]),
        ("ros1", "trinary", [[100, 0], [-1, 100]]),
        ("ros1", "scale", [[100, 1], [50, 100]]),
        ("cartographer", "trinary", [[100, 0], [-1, -1]]),
    ],
)
def test_alpha_is_read_as_each_program_reads_it(dialect, mode, wanted):
    pixels = opaque([[0, 205], [147, 0]], [[255, 255], [128, 0]])

    assert read_cells(pixels, Legend(mode=mode), dialect).tolist() == wanted


def test_clear_pixels_are_unknown_to_map_server_in_mode_scale():
    assert read_cells(opaque([[147, 147]], [[0, 255]]), Legend(mode="scale"), "ros1").tolist() == [[-1, 50]]


def test_colours_are_read_by_their_luma_or_their_mean():
    red = Pixels(np.array([[255]], np.uint16), 765, np.array([[76]], np.uint8))
    blue = Pixels(np.array([[255]], np.uint16), 765, np.array([[29]], np.uint8))
    legend = Legend(occupied_thresh=0.8)

    assert [read_cells(pixels, legend)[0, 0] for pixels in (red, blue)] == [-1, 100]
    assert [read_cells(pixels, legend, "nav2-2024")[0, 0] for pixels in (red, blue)] == [-1, -1]


LEGENDS = st.builds(
    lambda low, gap, negate, mode: Legend(
        free_thresh=low, occupied_thresh=min(1.0, low + gap), negate=negate, mode=mode
    ),
    st.floats(0.02, 0.5),
    st.floats(0.05, 0.45),
    st.booleans(),
    st.sampled_from(["trinary", "raw"]),
)
CELLS = arrays(np.int8, (5, 7), elements=st.sampled_from([-1, 0, 100]))


@given(LEGENDS, CELLS)
def test_thresholds_mode_and_negate_survive_a_round_trip(tmp_path_factory, legend, cells):
    cells[0, 0] = 0
    path = tmp_path_factory.mktemp("round") / "map.yaml"

    write_map(OccupancyGrid(cells, 0.05), path, legend=legend)

    assert read_header(path).legend == legend
    assert np.array_equal(read_map(path, strict_thresholds=True).occupancy, cells)


@pytest.mark.parametrize("negate", [False, True])
@pytest.mark.parametrize("mode", ["scale", "raw"])
def test_every_occupancy_survives_in_modes_that_tell_it(tmp_path, mode, negate):
    cells = np.arange(-1, 101, dtype=np.int8).reshape(2, 51)

    write_map(OccupancyGrid(cells), tmp_path / "m.yaml", legend=Legend(mode=mode, negate=negate), image_suffix=".png")

    assert np.array_equal(read_map(tmp_path / "m.yaml").occupancy, cells)


def test_map_savers_greys_are_written_where_they_mean_that():
    levels = grey_levels(Legend())

    assert (levels[0], levels[25], levels[50], levels[100], levels[-1]) == (254, 254, 205, 0, 205)
    assert grey_levels(Legend(free_thresh=0.25))[-1] != 205


def test_unknown_is_255_in_mode_raw_which_ros1_copies_into_signed_bytes():
    assert grey_levels(Legend(mode="raw"))[[0, 50, 100, -1]].tolist() == [0, 50, 100, 255]


def test_thresholds_without_a_grey_between_them_are_refused():
    with pytest.raises(InputError, match="no grey level means unknown"):
        grey_levels(Legend(free_thresh=0.5, occupied_thresh=0.5001))


def test_unknown_cells_of_mode_scale_ask_for_a_png(tmp_path):
    grid = OccupancyGrid(np.array([[0, -1], [100, 0]], np.int8))

    with pytest.raises(MapFileError, match=r"m.yaml: mode scale .* a \.png"):
        write_map(grid, tmp_path / "m.yaml", legend=Legend(mode="scale"))
    assert list(tmp_path.iterdir()) == []
