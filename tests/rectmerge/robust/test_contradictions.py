import numpy as np
import pytest

from rectmerge._kernels import contradictions as kernels
from rectmerge.analysis.distance_codes import distance_to
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.robust.contradictions import measure
from rectmerge.robust.params import Params
from tests.rectmerge.robust import naive, plans

PARAMS = Params()
SIDE = 120


def hall(*, pillar: tuple[int, int] | None = None, hidden: tuple[int, int] | None = None) -> OccupancyGrid:
    """Draw a walled hall, with a pillar of 12 x 12 cells, and a corner region that nobody has seen."""
    cells = np.full((SIDE + 20, SIDE + 20), UNKNOWN, np.int8)
    cells[10:-10, 10:-10] = OCCUPIED
    cells[12:-12, 12:-12] = FREE
    if pillar:
        cells[pillar[0] : pillar[0] + 12, pillar[1] : pillar[1] + 12] = OCCUPIED
    if hidden:
        cells[hidden[0] :, hidden[1] :] = UNKNOWN
    return OccupancyGrid(cells)


def contradictions_of(a: OccupancyGrid, b: OccupancyGrid, shift: tuple[float, float] = (0.0, 0.0)):
    one, two = plans.prepared(a), plans.prepared(b)
    scale = two.walled.factor / one.walled.factor
    middle = one.walled.offset - scale * two.walled.offset
    placement = np.array([[scale, 0.0, *(middle + np.array(shift) / one.walled.factor)]])
    working, detailed = (one.walled, two.walled), (one.detailed, two.detailed)
    return measure(placement, working, detailed, PARAMS.contradict)


def test_equal_maps_contradict_each_other_nowhere():
    for share in contradictions_of(hall(pillar=(60, 60)), hall(pillar=(60, 60))):
        assert share[0] == 0.0


def test_a_pillar_on_solid_floor_contradicts():
    found = contradictions_of(hall(), hall(pillar=(60, 60)))

    faces_of_pillar, faces = 4 * 12, 2 * 4 * (SIDE - 4) + 4 * 12
    assert found.on_floor[0] == pytest.approx(faces_of_pillar / faces, rel=0.3)
    assert found.corners_missed[0] > 0.2
    assert found.corners_denied[0] > 0.2


def test_what_was_not_seen_contradicts_nothing():
    found = contradictions_of(hall(hidden=(50, 50)), hall(pillar=(80, 80)))

    assert found.on_floor[0] == found.beside[0] == found.corners_denied[0] == 0.0


def test_a_wall_beside_its_partner_is_counted_beside():
    found = contradictions_of(hall(), hall(), shift=(6.0, 0.0))

    assert found.beside[0] > 0.2
    assert contradictions_of(hall(), hall(), shift=(1.0, 0.0)).beside[0] == 0.0


def test_swapped_maps_contradict_each_other_as_much():
    a, b = plans.see(plans.office(3), noise=1).grid, plans.see(plans.office(5), scale=1.4).grid

    for one, other in zip(contradictions_of(a, b), contradictions_of(b, a), strict=True):
        assert one[0] == pytest.approx(other[0], abs=0.02)


@pytest.mark.parametrize("seed", range(3))
def test_the_fast_counts_are_the_slow_ones(seed):
    rng = np.random.default_rng(seed)
    state = rng.choice([0, 1, 1, 1, 2], (30, 40)).astype(np.uint8)
    state[:, 10:30] = kernels.FREE
    to_corner = np.stack([distance_to(rng.random(state.shape) < 0.01) for _ in range(2)])
    to_wall, to_unknown = distance_to(state == kernels.WALL), distance_to(state == kernels.UNKNOWN)
    points = rng.uniform(-5, 45, (1000, 2))
    is_long, kinds = rng.random(1000) < 0.5, rng.integers(0, 2, 1000)
    turns, scales = rng.uniform(0, 7, 5), rng.uniform(0.6, 1.6, 5)
    placements = np.stack([scales * np.cos(turns), scales * np.sin(turns), *rng.uniform(0, 30, (2, 5))], axis=1)
    faces, corners = np.zeros((5, 4), np.int64), np.zeros((5, 3), np.int64)

    kernels.count_faces(placements, points, is_long, state, to_wall, to_unknown, (2.0, 3.0, 2.5), faces)
    kernels.count_corners(placements, points, kinds, to_corner, to_unknown, (1.0, 3.0, 4.0), corners)

    slow_faces = naive.count_faces(placements, points, is_long, state, to_wall, to_unknown, (2.0, 3.0, 2.5))
    slow_corners = naive.count_corners(placements, points, kinds, to_corner, to_unknown, (1.0, 3.0, 4.0))
    np.testing.assert_array_equal(faces, slow_faces)
    np.testing.assert_array_equal(corners, slow_corners)
    assert (faces.sum(axis=0) > 0).all()
    assert (corners.sum(axis=0) > 0).all()
