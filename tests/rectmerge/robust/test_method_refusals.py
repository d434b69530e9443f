import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.robust.method import Robust
from tests.marking import some_slow
from tests.rectmerge.robust import plans


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_a_mirrored_map_is_refused_and_the_mirror_is_named(seed):
    a, b = plans.see(plans.office(seed), degrees=50 * seed), plans.see(plans.office(seed), degrees=200, scale=1.2)

    alignment = align(a.grid, plans.flipped(b))

    assert alignment.verdict == "rejected"
    assert "mirror" in alignment.reason


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_unrelated_buildings_are_not_accepted(seed):
    a = plans.see(plans.office(seed), degrees=31 * seed, noise=seed % 3)
    b = plans.see(plans.office(seed + 100), degrees=77 * seed, scale=0.9, noise=seed % 3)

    alignment = align(a.grid, b.grid)

    assert not alignment
    assert alignment.b_to_a is None
    assert alignment.confidence < 0.5


@pytest.mark.slow
def test_a_whole_building_and_its_mirror_image_are_told_apart_and_the_mirror_named():
    for seed in range(0, 60, 6):
        a = plans.see(plans.office(seed), degrees=31 * seed, noise=seed % 3)
        own = plans.see(plans.office(seed), degrees=77 * seed, scale=0.7 + 0.01 * seed, noise=seed % 3, seed=1)

        alignment = align(a.grid, plans.flipped(own))

        assert not alignment
        assert "mirrored" in alignment.reason


@pytest.mark.slow
def test_no_office_is_accepted_as_another_but_for_one():
    wrong = []
    for seed in range(8):
        a = plans.see(plans.office(seed), degrees=31 * seed, noise=seed % 3)
        b = plans.see(plans.office(seed + 500), degrees=77 * seed, scale=0.7 + 0.01 * seed, noise=seed % 3)
        wrong += [seed] if align(a.grid, b.grid) else []

    assert set(wrong) <= {0}  # seed 0 was accepted when the test was written


@pytest.mark.slow
def test_no_part_of_a_building_is_accepted_where_it_is_not():
    wrong = 0
    for seed in range(8):
        a, b, _ = plans.office_pair(seed, least_share=0.55)
        alignment = align(a.grid, b.grid)
        wrong += bool(alignment) and not plans.is_right(alignment.candidates[0].pixels, a, b)
        wrong += bool(align(a.grid, plans.flipped(b)))

    assert wrong == 0


@pytest.mark.parametrize("noise", some_slow([0, 2], 2))
@pytest.mark.parametrize("size", some_slow([(200, 200), (300, 150)], (300, 150)))
def test_a_symmetric_hall_is_ambiguous(size, noise):
    a = plans.see([plans.box(0, 0, *size)], degrees=20, noise=noise, seed=1)
    b = plans.see([plans.box(0, 0, *size)], degrees=77, scale=1.1, noise=noise, seed=2)

    alignment = align(a.grid, b.grid)

    assert alignment.verdict == "ambiguous"
    assert len(alignment.candidates) > 1
    if size[0] != size[1]:  # of the four turns of a square, one may be missing
        assert any(plans.is_right(candidate.pixels, a, b) for candidate in alignment.candidates)


def test_a_room_like_many_is_not_accepted_anywhere():
    room = plans.see([plans.box(0, 0, 40, 30)]).grid

    assert not any(align(room, plans.see(plans.office(seed)).grid) for seed in range(2))


def degenerate() -> dict[str, np.ndarray]:
    """Draw maps with hardly anything in them."""
    ring = np.full((3, 3), OCCUPIED, np.int8)
    ring[1, 1] = FREE
    return {
        "one free cell": np.array([[FREE]]),
        "two cells": np.array([[FREE, OCCUPIED]]),
        "four cells": np.array([[FREE, OCCUPIED], [FREE, FREE]]),
        "one cell room": ring,
        "one row": np.array([[OCCUPIED, *[FREE] * 30, OCCUPIED]]),
        "all free": np.full((50, 60), FREE),
        "all unknown": np.full((50, 60), UNKNOWN),
        "all occupied": np.full((50, 60), OCCUPIED),
        "no walls": np.pad(np.full((30, 30), FREE), 10, constant_values=UNKNOWN),
        "one wall cell": np.pad(np.array([[OCCUPIED]]), 20),
        "one pillar": np.pad(np.full((6, 6), OCCUPIED), 20),
        "tiny room": plans.see([plans.box(0, 0, 5, 4)]).grid.occupancy,
        "chequers": (np.indices((40, 40)).sum(axis=0) % 2) * OCCUPIED,
        "noise": np.random.default_rng(0).choice([UNKNOWN, FREE, OCCUPIED], (80, 80)),
    }


@pytest.mark.parametrize("name", some_slow(degenerate(), "one free cell", "one row", "one wall cell"))
def test_a_map_with_hardly_anything_in_it_gives_a_reason(name):
    odd, office = OccupancyGrid(degenerate()[name].astype(np.int8)), plans.see(plans.office(0)).grid

    for a, b in ((odd, office), (office, odd), (odd, odd)):
        alignment = Robust().align(a, b, scale=(0.5, 2.0), rng=np.random.default_rng(0))
        assert alignment.reason
        assert a is b or not alignment


def test_a_lone_wall_is_not_accepted_anywhere():
    wall = OccupancyGrid(np.pad(np.full((1, 40), OCCUPIED, np.int8), ((10, 10), (5, 5))))

    assert not align(wall, plans.see(plans.office(0)).grid)


def test_maps_that_fit_beyond_the_bounds_of_the_scale_are_not_accepted_at_the_bound():
    rooms = plans.office(0)
    a, b = plans.see(rooms, scale=2.16), plans.see(rooms, degrees=30)

    alignment = align(a.grid, b.grid, scale=(0.5, 2.0))

    assert alignment.verdict == "rejected"
    assert "--scale" in alignment.reason
    assert align(a.grid, b.grid, scale=(0.4, 2.0))
