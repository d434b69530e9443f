import numpy as np
import pytest

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from tests import drawing


def room(width: int, height: int, margin: int = 10) -> OccupancyGrid:
    free = np.zeros((height + 2 * margin, width + 2 * margin), np.bool_)
    free[margin : margin + height, margin : margin + width] = True
    return drawing.grid_of(free)


def test_a_map_on_itself_overlaps_wholly_without_conflict():
    grid = drawing.building()

    agreement = measure_agreement(grid, grid, Similarity())

    assert (agreement.overlap, agreement.iou, agreement.conflict) == (1.0, 1.0, 0.0)


@pytest.mark.parametrize("shift", [0, 10, 25, 50])
def test_overlap_is_the_share_of_free_space_in_common(shift):
    grid = room(50, 30)

    agreement = measure_agreement(grid, grid, Similarity(tx=shift))

    common = (50 - shift) * 30
    assert agreement.overlap == pytest.approx(common / (50 * 30))
    assert agreement.iou == pytest.approx(common / (2 * 50 * 30 - common))


def test_overlap_is_relative_to_the_smaller_free_space():
    small, large = room(20, 20), room(80, 60)

    assert measure_agreement(large, small, Similarity(tx=15, ty=12)).overlap == 1.0
    assert measure_agreement(small, large, Similarity(tx=-15, ty=-12)).overlap == 1.0


def test_overlap_is_measured_in_cells_of_a_whatever_the_scale():
    a = drawing.building()
    fine = Similarity(0.5, 0.0, -0.25, -0.25)  # two cells of B per cell of A
    b = drawing.view(a, fine, (226, 326))

    agreement = measure_agreement(a, b, fine)

    assert agreement.overlap > 0.98
    assert agreement.conflict < 0.02


def test_maps_apart_neither_overlap_nor_conflict():
    grid = room(30, 30)

    agreement = measure_agreement(grid, grid, Similarity(tx=500))

    assert (agreement.overlap, agreement.iou, agreement.conflict) == (0.0, 0.0, 0.0)


def test_a_wall_in_the_other_maps_free_space_conflicts_and_a_wall_next_to_a_wall_does_not():
    grid = room(50, 30)

    assert measure_agreement(grid, grid, Similarity(tx=2)).conflict == 0.0
    assert measure_agreement(grid, grid, Similarity(tx=20)).conflict > 0.2


def test_unknown_cells_say_nothing_against_a_placement():
    a = room(50, 30)
    nearly_blind = np.full(a.shape, -1, np.int8)
    nearly_blind[11, 11] = 0

    assert measure_agreement(OccupancyGrid(nearly_blind), a, Similarity(tx=20)).conflict == 0.0


def test_swapping_the_maps_measures_the_same():
    a, b = drawing.building(), room(60, 60)
    pixels = Similarity(1.2, 0.4, 20, 5)

    there, back = measure_agreement(a, b, pixels), measure_agreement(b, a, pixels.inverse())

    assert there.overlap == pytest.approx(back.overlap, abs=0.02)
    assert there.conflict == pytest.approx(back.conflict, abs=0.02)
