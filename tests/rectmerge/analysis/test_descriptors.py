import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.analysis.descriptors import describe_map
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

ROOM = (10, 110)  # first cells of the walls that enclose 99 x 99 free cells


def room() -> np.ndarray:
    """Draw a square room with walls of one cell, unknown outside."""
    cells = np.full((121, 121), UNKNOWN, np.int8)
    low, high = ROOM
    cells[low : high + 1, low : high + 1] = OCCUPIED
    cells[low + 1 : high, low + 1 : high] = FREE
    return cells


def described(cells: np.ndarray):
    return describe_map(OccupancyGrid(cells))


def with_cells(places, value=OCCUPIED) -> np.ndarray:
    cells = room()
    cells[tuple(np.transpose(places))] = value
    return cells


def test_a_clean_room_has_nothing_but_its_walls():
    found = described(room())

    assert (found.specks, found.pinholes, found.holes, found.slivers, found.strays, found.blobs) == (0,) * 6
    assert (found.frontier_share, found.wall_thickness_cells, found.wall_roughness_cells) == (0.0, 1.0, 0.0)
    assert (found.short_gaps, found.gaps) == (0.0, 0.0)
    assert found.speck_clumping is None
    assert found.specks_near_walls is None


@pytest.mark.parametrize(
    ("name", "side", "value", "expected"),
    [
        ("specks", 2, OCCUPIED, 100 / (99 * 99 - 4)),
        ("blobs", 3, OCCUPIED, 10_000 / (99 * 99 - 9)),
        ("pinholes", 2, UNKNOWN, 400 / (99 * 99 - 4)),
        ("holes", 3, UNKNOWN, 900 / (99 * 99 - 9)),
    ],
)
def test_a_square_patch_counts_as_its_size_says(name, side, value, expected):
    cells = room()
    cells[50 : 50 + side, 50 : 50 + side] = value
    found = described(cells).as_dict()

    assert found[name] == pytest.approx(expected)
    assert sum(found[other] for other in ("specks", "blobs", "pinholes", "holes")) == pytest.approx(expected)


def test_specks_of_an_even_lattice_and_of_clumps_are_told_apart():
    lattice = [(row, col) for row in range(20, 110, 10) for col in range(20, 110, 10)]
    clump = [(row, col) for row in range(50, 68, 2) for col in range(50, 68, 2)]

    assert described(with_cells(lattice)).speck_clumping > 1.5  # 2 on an endless lattice
    assert described(with_cells(clump)).speck_clumping < 0.5


def test_scattered_specks_have_a_clumping_of_about_one():
    rng = np.random.default_rng(0)
    scattered = room()
    scattered[(rng.random(scattered.shape) < 0.005) & (scattered == FREE)] = OCCUPIED

    assert described(scattered).speck_clumping == pytest.approx(1.0, abs=0.15)


def test_the_share_of_specks_near_walls_is_counted():
    assert described(with_cells([(14, 50), (50, 14), (60, 60), (60, 80)])).specks_near_walls == 0.5


def test_single_rays_are_slivers_and_their_ends_strays():
    cells = room()
    cells[60, 112:118] = FREE  # beyond the wall
    cells[80, 113:116] = FREE
    found = described(cells)

    assert found.slivers == pytest.approx(100 * 9 / (99 * 99 + 9))
    assert found.strays == pytest.approx(100 / (99 * 99 + 9))


def test_a_missing_wall_is_frontier():
    cells = room()
    cells[ROOM[0]] = UNKNOWN

    assert described(cells).frontier_share == pytest.approx(0.25)


@pytest.mark.parametrize(("width", "short", "long"), [(1, 100, 0), (2, 200, 0), (5, 0, 500), (9, 0, 0)])
def test_gaps_count_by_their_length(width, short, long):
    cells = np.zeros((41, 121), np.int8)
    cells[20] = OCCUPIED
    cells[20, 60 : 60 + width] = FREE
    found = described(cells)

    assert (found.short_gaps, found.gaps) == pytest.approx((short / (121 - width), long / (121 - width)))


def test_a_rough_wall_is_rougher_than_a_straight_one_in_any_direction():
    rng = np.random.default_rng(0)
    rough = np.zeros((200, 200), np.int8)
    rough[100 + rng.integers(-2, 3, 160), np.arange(20, 180)] = OCCUPIED
    oblique = np.zeros((200, 200), np.int8)
    oblique[np.rint(60 + np.arange(160) * 0.4).astype(int), np.arange(20, 180)] = OCCUPIED

    assert described(rough).wall_roughness_cells > 1.0
    assert described(oblique).wall_roughness_cells == pytest.approx(0.29, abs=0.05)


@pytest.mark.parametrize("value", [FREE, OCCUPIED, UNKNOWN])
def test_maps_of_one_value_are_described_by_what_they_have(value):
    found = described(np.full((20, 30), value, np.int8)).as_dict()

    assert all(np.isfinite(figure) for figure in found.values())
    assert ("specks" in found) == (value == FREE)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 3))
def test_quarter_turns_change_no_count(seed, turns):
    rng = np.random.default_rng(seed)
    cells = rng.choice(np.array([FREE, FREE, FREE, OCCUPIED, UNKNOWN], np.int8), (24, 37))
    names = ("specks", "pinholes", "holes", "slivers", "strays", "frontier_share", "blobs", "short_gaps", "gaps")
    here, turned = described(cells).as_dict(), described(np.rot90(cells, turns).copy()).as_dict()

    assert {name: turned[name] for name in names} == pytest.approx({name: here[name] for name in names})


def test_twice_the_map_has_the_same_figures_per_cell():
    rng = np.random.default_rng(1)
    cells = room()
    cells[(rng.random(cells.shape) < 0.003) & (cells == FREE)] = OCCUPIED
    once, twice = described(cells).as_dict(), described(np.hstack([cells, cells])).as_dict()

    assert twice["specks"] == pytest.approx(once["specks"])
    assert twice["slivers"] == pytest.approx(once["slivers"])
    assert twice["wall_roughness_cells"] == pytest.approx(once["wall_roughness_cells"], abs=0.05)
