import doctest

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.grid import FREE, OccupancyGrid
from scenarios.corruption import CORRUPTIONS, catalogue, corrupt
from tests.scenarios.corruption.small_map import changed, small_map

MILD = {"resample": 1.0, "turn": 0.0}  # the strength that does nothing, where it is not 0
SOME = {"spurious_rays": 4.0, "blobs": 2.0, "erosion": 1.0, "dilation": 1.0, "bend": 2.0, "kink": 3.0, "turn": 20.0}
SOME |= {"resample": 1.4, "stretch": 8.0}


def test_the_example_of_the_documentation_is_true():
    assert doctest.testmod(catalogue).failed == 0


@pytest.mark.parametrize("name", CORRUPTIONS)
def test_a_corruption_of_no_strength_changes_nothing(name):
    corrupted = corrupt(small_map(), [(name, MILD.get(name, 0.0))])

    assert np.array_equal(corrupted.grid.occupancy, small_map().occupancy)
    assert np.allclose(corrupted.map_points([[7.0, 9.0]]), [[7.0, 9.0]])


@pytest.mark.parametrize("name", CORRUPTIONS)
def test_a_corruption_of_some_strength_changes_the_map_the_same_way_for_the_same_seed(name):
    first, again, other = (corrupt(small_map(), [(name, SOME.get(name, 0.2))], seed=seed).grid for seed in (3, 3, 4))

    assert np.array_equal(first.occupancy, again.occupancy)
    assert not np.array_equal(first.occupancy, small_map().occupancy)
    if name not in ("erosion", "dilation", "resample", "turn"):
        assert not np.array_equal(first.occupancy, other.occupancy)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.sampled_from(sorted(CORRUPTIONS)), max_size=4), st.integers(0, 1000))
def test_any_corruptions_in_any_order_suit_any_map(names, seed):
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid(rng.choice([-1, 0, 100], rng.integers(1, 30, 2)).astype(np.int8))
    corrupted = corrupt(grid, [(name, SOME.get(name, 0.2)) for name in names], seed=seed)

    assert np.isfinite(corrupted.map_points([[0.0, 0.0], [3.0, 4.0]])).all()


def test_every_place_in_the_list_has_draws_of_its_own():
    some, more = (
        changed(small_map(), corrupt(small_map(), [("wall_dropout", share), ("salt", 0.1)]).grid) & small_map().free
        for share in (0.1, 0.5)
    )

    assert np.array_equal(some, more)


def test_counts_are_per_ten_thousand_known_cells():
    known = int((~small_map().unknown).sum())
    grid = OccupancyGrid(np.full((300, 400), FREE, np.int8))
    rays = [corrupt(small_map(), [("spurious_rays", 10_000 / known * count)]).grid for count in (0.4, 0.6)]

    assert [changed(small_map(), corrupted).any() for corrupted in rays] == [False, True]
    assert changed(grid, corrupt(grid, [("blobs", 1.0)]).grid).sum() == pytest.approx(12 * np.pi * 13, rel=0.5)


@pytest.mark.parametrize(
    ("name", "strength", "complaint"),
    [
        ("pepper", 0.1, "no corruption 'pepper'; there are: salt, wall_dropout, "),
        ("salt", 1.5, r"salt must be 0 to 1 \(share of the free cells\), got 1.5"),
        ("bend", -1.0, r"bend must be 0 to 10 \(degrees"),
        ("resample", 0.0, "resample must be 0.1 to 10"),
        ("blobs", float("nan"), "blobs must be 0 to 100"),
    ],
)
def test_what_cannot_be_done_is_refused_before_anything_is(name, strength, complaint):
    with pytest.raises(InputError, match=complaint):
        corrupt(small_map(), [("salt", 0.5), (name, strength)])
