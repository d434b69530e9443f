import doctest

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import InputError
from rectmerge.grid import FREE, OccupancyGrid
from scenarios.corruption import KINDS, corrupt, kinds
from tests.scenarios.corruption.made import changed, drawn

MILD = {"resample": 1.0, "turn": 0.0}  # the strength that does nothing, where it is not 0
SOME = {"spurious_rays": 4.0, "blobs": 2.0, "erosion": 1.0, "dilation": 1.0, "bend": 2.0, "kink": 3.0, "turn": 20.0}
SOME |= {"resample": 1.4, "stretch": 8.0}


def test_the_example_of_the_documentation_is_true():
    assert doctest.testmod(kinds).failed == 0


@pytest.mark.parametrize("name", KINDS)
def test_a_kind_at_no_strength_changes_nothing(name):
    done = corrupt(drawn(), [(name, MILD.get(name, 0.0))])

    assert np.array_equal(done.grid.occupancy, drawn().occupancy)
    assert np.allclose(done.moved([[7.0, 9.0]]), [[7.0, 9.0]])


@pytest.mark.parametrize("name", KINDS)
def test_a_kind_of_some_strength_changes_the_map_the_same_way_for_the_same_seed(name):
    first, again, other = (corrupt(drawn(), [(name, SOME.get(name, 0.2))], seed=seed).grid for seed in (3, 3, 4))

    assert np.array_equal(first.occupancy, again.occupancy)
    assert not np.array_equal(first.occupancy, drawn().occupancy)
    if name not in ("erosion", "dilation", "resample", "turn"):
        assert not np.array_equal(first.occupancy, other.occupancy)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.sampled_from(sorted(KINDS)), max_size=4), st.integers(0, 1000))
def test_any_damage_in_any_order_is_borne_by_any_map(names, seed):
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid(rng.choice([-1, 0, 100], rng.integers(1, 30, 2)).astype(np.int8))
    done = corrupt(grid, [(name, SOME.get(name, 0.2)) for name in names], seed=seed)

    assert np.isfinite(done.moved([[0.0, 0.0], [3.0, 4.0]])).all()


def test_every_place_in_the_list_has_draws_of_its_own():
    some, more = (
        changed(drawn(), corrupt(drawn(), [("wall_dropout", share), ("salt", 0.1)]).grid) & drawn().free
        for share in (0.1, 0.5)
    )

    assert np.array_equal(some, more)


def test_counts_are_per_ten_thousand_known_cells():
    known = int((~drawn().unknown).sum())
    grid = OccupancyGrid(np.full((300, 400), FREE, np.int8))
    rays = [corrupt(drawn(), [("spurious_rays", 10_000 / known * count)]).grid for count in (0.4, 0.6)]

    assert [changed(drawn(), one).any() for one in rays] == [False, True]
    assert changed(grid, corrupt(grid, [("blobs", 1.0)]).grid).sum() == pytest.approx(12 * np.pi * 13, rel=0.5)


@pytest.mark.parametrize(
    ("name", "strength", "complaint"),
    [
        ("pepper", 0.1, "no damage 'pepper'; there are: salt, wall_dropout, "),
        ("salt", 1.5, r"salt must be 0 to 1 \(share of the free cells\), got 1.5"),
        ("bend", -1.0, r"bend must be 0 to 10 \(degrees"),
        ("resample", 0.0, "resample must be 0.1 to 10"),
        ("blobs", float("nan"), "blobs must be 0 to 100"),
    ],
)
def test_what_cannot_be_done_is_refused_before_anything_is(name, strength, complaint):
    with pytest.raises(InputError, match=complaint):
        corrupt(drawn(), [("salt", 0.5), (name, strength)])
