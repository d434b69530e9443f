import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rectmerge as rm
from rectmerge.analysis.double_walls import double_wall_share
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from tests.drawing import building
from tests.rectmerge.elastic.bent_maps import bent_view, large_building, random_displacement

EMPTY = OccupancyGrid(np.zeros((30, 30), np.int8))


@pytest.mark.parametrize(("shift", "least", "most"), [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (4.0, 0.2, 0.5)])
def test_a_map_laid_beside_itself_shows_its_walls_twice(shift, least, most):
    share = double_wall_share(building(), building(), Similarity(tx=shift))

    assert least <= share <= most


@settings(max_examples=10)
@given(st.floats(0.6, 1.6), st.floats(-3, 3))
def test_cells_of_another_size_and_a_turn_double_no_wall(scale, angle):
    a = large_building()
    pixels = Similarity(scale, angle, 5.0, -7.0)
    back = pixels.inverse().apply(np.array([[0, 0], [652, 0], [652, 452], [0, 452]]))
    low, high = back.min(axis=0), back.max(axis=0)
    shown = pixels @ Similarity(tx=float(low[0]), ty=float(low[1]))
    none = random_displacement(0, a.shape, spacing=200, size=0.0)
    b = bent_view(a, shown, none, tuple(int(side) for side in (high - low)[::-1]))

    assert double_wall_share(a, b, shown) < 0.02


@pytest.mark.parametrize("maps", [(EMPTY, building()), (building(), EMPTY)])
def test_a_map_without_walls_has_no_share(maps):
    assert double_wall_share(*maps, Similarity()) is None


def test_maps_that_lie_apart_have_no_share():
    assert double_wall_share(building(), building(), Similarity(tx=1000.0)) is None


def test_unbending_leaves_fewer_double_walls():
    a = large_building()
    truth = random_displacement(1, a.shape, spacing=200, size=14)
    b = bent_view(a, Similarity(0.8, 0.3, 60.0, -40.0), truth, (560, 720))
    cells = np.argwhere(b.free)[::197, ::-1].astype(float)
    bend = rm.unbend(a, b, rm.Similarity.fit(cells, truth.apply(Similarity(0.8, 0.3, 60.0, -40.0).apply(cells))))

    before, after = bend.double_walls(a, b)

    assert before > 0.05
    assert after < 0.5 * before


def test_a_refused_bend_changes_no_wall():
    a = large_building()

    before, after = rm.unbend(a, a, Similarity()).double_walls(a, a)

    assert before == after == 0.0
