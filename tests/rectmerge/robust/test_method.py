import math

import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.robust.method import Robust
from rectmerge.similarity import Similarity
from tests.marking import some_slow
from tests.rectmerge.robust import plans


def assert_right(alignment, a, b):
    assert alignment, alignment.reason
    assert plans.is_right(alignment.candidates[0].pixels, a, b)


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_a_known_similarity_is_recovered(seed):
    a, b, _ = plans.office_pair(seed)

    alignment = align(a.grid, b.grid)

    assert_right(alignment, a, b)
    assert plans.error(alignment.candidates[0].pixels, a, b) < 0.5


@pytest.mark.slow
def test_known_similarities_are_recovered_nearly_always_and_wrong_ones_are_not_accepted():
    right = wrong = 0
    for seed in range(100, 140):
        a, b, _ = plans.office_pair(seed)
        alignment = align(a.grid, b.grid)
        is_right = bool(alignment.candidates) and plans.is_right(alignment.candidates[0].pixels, a, b)
        right += bool(alignment) and is_right
        wrong += bool(alignment) and not is_right

    assert right >= 39
    assert wrong == 0


def test_a_floor_plan_drawn_with_lines_fits_a_map():
    rooms = plans.office(4)
    a = plans.see(rooms, degrees=70, noise=1)
    lines = [plans.box(*(room.min(axis=0) - 2.4), *(np.ptp(room, axis=0) + 4.8)) for room in rooms]
    inside = [room for room in lines if min(np.ptp(room, axis=0)) > 25]
    doors = [room for room in lines if min(np.ptp(room, axis=0)) <= 25]
    b = plans.see([*inside, *doors], scale=1.3, degrees=0)

    alignment = align(a.grid, b.grid)

    # of rooms behind walls that are lines, which lie beside those of the map, it is likely, but not sure
    assert plans.is_right(alignment.candidates[0].pixels, a, b)
    assert alignment.confidence > 0.5


@pytest.mark.parametrize("seed", [0, pytest.param(slice(1, 6), marks=pytest.mark.slow)])
def test_what_a_free_search_accepts_a_narrower_one_accepts(seed):
    for number in range(*seed.indices(99)) if isinstance(seed, slice) else [seed]:
        a, b, scale = plans.office_pair(number, least_share=0.62)
        if not align(a.grid, b.grid, scale="free"):
            continue
        for narrower in ((0.9 * scale, 1.1 * scale), (0.98 * scale, 1.02 * scale), scale):
            assert_right(align(a.grid, b.grid, scale=narrower), a, b)


@pytest.mark.parametrize("seed", [0, pytest.param(slice(1, 6), marks=pytest.mark.slow)])
def test_the_answer_for_swapped_maps_is_the_inverse(seed):
    for number in range(*seed.indices(99)) if isinstance(seed, slice) else [seed]:
        a, b, _ = plans.office_pair(number)
        there, back = align(a.grid, b.grid), align(b.grid, a.grid)

        assert_right(there, a, b)
        assert (back.verdict, back.reason) == (there.verdict, there.reason)
        assert back.confidence == pytest.approx(there.confidence, abs=0.02)
        round_trip = back.candidates[0].pixels @ there.candidates[0].pixels
        middle = np.argwhere(b.grid.free).mean(axis=0)[::-1]
        assert np.abs(round_trip.apply(middle) - middle).max() < 0.1
        assert abs(math.log(round_trip.scale)) < 1e-3


def test_the_same_seed_gives_the_same_bytes():
    a, b, _ = plans.office_pair(3)

    first, second = align(a.grid, b.grid, seed=5), align(a.grid, b.grid, seed=5)

    assert repr(first.as_dict() | {"seconds": 0}) == repr(second.as_dict() | {"seconds": 0})


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_other_seeds_give_the_same_answer_to_a_fraction_of_a_cell(seed):
    a, b, _ = plans.office_pair(2)

    alignment = align(a.grid, b.grid, seed=seed)

    assert_right(alignment, a, b)
    assert plans.error(alignment.candidates[0].pixels, a, b) < 0.5


@pytest.mark.parametrize("noise", [1, pytest.param(0, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", some_slow(["round", "polygons 0", "polygons 1", "wings 0", "wings 1"], "round"))
def test_buildings_without_one_dominant_direction_are_aligned(name, noise):
    kind, _, seed = name.partition(" ")
    rooms = {"round": plans.round_rooms, "polygons": lambda: plans.polygons(int(seed))}.get(
        kind, lambda: plans.two_wings(int(seed))
    )()
    corners = np.concatenate(rooms)
    (x, y), (w, h) = corners.min(axis=0) - 8, np.ptp(corners, axis=0) + 16
    a = plans.see(rooms, degrees=24, window=(x, y, 0.85 * w, h), noise=noise, seed=1)
    b = plans.see(rooms, degrees=151, scale=0.8, window=(x + 0.15 * w, y, 0.85 * w, h), noise=noise, seed=2)

    assert_right(align(a.grid, b.grid), a, b)


@pytest.mark.slow
@pytest.mark.parametrize("share", [1.0, 0.7])
def test_a_long_corridor_is_aligned(share):
    rooms = plans.corridor()
    a = plans.see(rooms, degrees=3, window=(-8, -8, 4016 * share, 320), noise=1)
    b = plans.see(rooms, degrees=184, scale=1.1, window=(4016 * (1 - share), -8, 4016 * share, 320), noise=1, seed=1)

    assert_right(align(a.grid, b.grid), a, b)


@pytest.mark.parametrize("field", ["max_candidates"])
def test_parameters_below_one_are_refused(field):
    with pytest.raises(InputError, match=field):
        Robust(**{field: 0})


def test_what_is_reported_is_complete():
    a, b, _ = plans.office_pair(0)

    alignment = align(a.grid, b.grid)

    assert 1 <= len(alignment.candidates) <= Robust().max_candidates
    assert alignment.confidence == alignment.candidates[0].confidence
    assert set(alignment.quality) == {"a", "b"}
    for candidate in alignment.candidates:
        assert candidate.covariance is not None
        np.testing.assert_allclose(candidate.covariance, candidate.covariance.T)
        assert (np.linalg.eigvalsh(candidate.covariance) > 0).all()
        assert {"plausibility", "rest_log_odds", "overlap", "violations", "residual_cells"} <= set(candidate.evidence)


def test_a_turned_map_gives_the_turned_answer():
    a, b, _ = plans.office_pair(1)
    quarter = OccupancyGrid(np.ascontiguousarray(np.rot90(b.grid.occupancy)))

    alignment = align(a.grid, quarter)

    assert alignment, alignment.reason
    assert plans.is_right(alignment.candidates[0].pixels @ unturned(b.grid), a, b)


def unturned(grid: OccupancyGrid) -> Similarity:
    """The pixels of a map on the map that `np.rot90` makes of it: (u, v) goes to (v, W - 1 - u)."""
    return Similarity(1.0, -math.pi / 2, 0.0, grid.shape[1] - 1.0)
