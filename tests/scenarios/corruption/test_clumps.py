import math

import numpy as np
import pytest

from rectmerge.analysis.descriptors import describe_map
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from scenarios.corruption import clumps
from scenarios.corruption.cells import salt
from tests.scenarios.corruption.small_map import changed, small_map

RNG_SEED = 3


def rng() -> np.random.Generator:
    return np.random.default_rng(RNG_SEED)


def beside_walls(grid: OccupancyGrid) -> np.ndarray:
    ring = np.zeros(grid.shape, bool)
    ring[7:193, 7:193] = True
    ring[11:189, 11:189] = False
    return ring & ~grid.occupied


@pytest.mark.parametrize("share", [0.05, 0.3, 0.6, 1.0])
@pytest.mark.parametrize(
    ("corruption", "mask", "value"),
    [
        (clumps.thick_walls, beside_walls, OCCUPIED),
        (clumps.broken_walls, lambda grid: grid.occupied, UNKNOWN),
        (clumps.pinholes, lambda grid: grid.free, UNKNOWN),
    ],
)
def test_about_the_share_of_its_cells_and_nothing_else_changes(corruption, mask, value, share):
    before = small_map()
    after = corruption(before, share, rng())

    changes = changed(before, after)
    assert not (changes & ~mask(before)).any()
    assert (after.occupancy[changes] == value).all()
    wanted = share * mask(before).sum()
    assert changes.sum() == pytest.approx(wanted, abs=0.05 * wanted + 3 * math.sqrt(wanted))


def test_broken_walls_come_in_patches():
    lost = changed(small_map(), clumps.broken_walls(small_map(), 0.1, rng()))
    again = np.roll(lost, 1, axis=0) | np.roll(lost, 1, axis=1)

    assert (lost & again).sum() / lost.sum() > 0.4  # evenly spread, about a fifth would have a neighbour there


def test_specks_are_as_many_as_asked_in_clumps_and_near_walls():
    found = describe_map(clumps.speck_clumps(small_map(), 0.5, rng()))
    even = describe_map(salt(small_map(), 0.005, rng()))

    assert 0.12 < found.specks <= 0.55  # some fall on walls and on each other
    assert found.speck_clumping < 0.8 < even.speck_clumping
    assert found.specks_near_walls > 3 * even.specks_near_walls


def test_clutter_is_blobs_on_the_floor():
    before = small_map()
    after = clumps.clutter(before, 10.0, rng())

    changes = changed(before, after)
    assert (before.occupancy[changes] == FREE).all()
    assert describe_map(after).blobs > 1.0
    assert changes.sum() > 50


def test_dense_scans_fill_gaps_between_rays_and_no_larger_ones():
    cells = small_map().occupancy.copy()
    cells[60, 40:160] = cells[90:92, 40:160] = cells[120:126, 40:160] = UNKNOWN
    before = OccupancyGrid(cells, 0.05)
    after = clumps.dense_scans(before, 1.0, rng())

    assert (after.occupancy[60, 40:160] == FREE).all()
    assert (after.occupancy[90:92, 40:160] == FREE).all()
    assert (after.occupancy[121:125, 42:158] == UNKNOWN).all()
    assert (changed(before, after) <= before.unknown).all()
    half = changed(before, clumps.dense_scans(before, 0.5, rng())).sum() / changed(before, after).sum()
    assert half == pytest.approx(0.5, abs=0.2)


def test_legs_are_erased_and_larger_things_stay():
    cells = small_map().occupancy.copy()
    for row in range(30, 170, 10):
        cells[row : row + 2, 40:42] = OCCUPIED
        cells[row : row + 3, 80:83] = OCCUPIED
    before = OccupancyGrid(cells, 0.05)
    after = clumps.erased_legs(before, 1.0, rng())

    assert not after.occupied[20:180, 40:42].any()
    assert np.array_equal(after.occupied[:, 80:83], before.occupied[:, 80:83])
    some = clumps.erased_legs(before, 0.5, rng()).occupied[20:180, 40:42].sum()
    assert 4 <= some <= 52


@pytest.mark.parametrize(
    "name", ["dense_scans", "erased_legs", "thick_walls", "broken_walls", "pinholes", "speck_clumps", "clutter"]
)
def test_strength_zero_changes_nothing_and_a_seed_always_the_same(name):
    corruption = getattr(clumps, name)

    assert not changed(small_map(), corruption(small_map(), 0.0, rng())).any()
    assert not changed(corruption(small_map(), 0.7, rng()), corruption(small_map(), 0.7, rng())).any()
