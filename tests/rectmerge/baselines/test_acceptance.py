import numpy as np
import pytest

from rectmerge.baselines.acceptance import CellComparison
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from tests.rectmerge.baselines import scenes


def test_the_acceptance_index_is_the_share_of_agreeing_cells_among_those_both_know():
    a = OccupancyGrid(np.array([[0, 0, 100, 100, -1, 0]], np.int8))
    b = OccupancyGrid(np.array([[0, 100, 100, 0, 0, -1]], np.int8))

    assert CellComparison(a, b).acceptance_index(Similarity()) == pytest.approx(2 / 4)


def test_maps_that_share_no_known_cell_do_not_agree():
    a = scenes.upright()

    assert CellComparison(a, a).acceptance_index(Similarity(1.0, 0.0, 500.0, 0.0)) == 0


def test_all_walls_are_shared_by_a_map_and_itself_and_few_with_a_smaller_self():
    a = scenes.upright()
    comparison = CellComparison(a, a)

    assert comparison.shared_walls(Similarity()) == 1.0
    assert comparison.shared_walls(Similarity(1.0, 0.0, 1.0, 0.0)) > 0.9  # beside one another
    assert comparison.shared_walls(Similarity(0.5, 0.0, 40.0, 40.0)) < 0.4
    assert comparison.shared_walls(Similarity(1.0, 0.0, 500.0, 0.0)) == 0.0


def test_what_both_know_is_a_share_of_the_smaller_map():
    a = OccupancyGrid(np.array([[0, 100, 0, -1], [0, 0, 100, -1]], np.int8))
    b = OccupancyGrid(np.array([[0, 0, 0, -1], [0, 0, 100, 100]], np.int8))

    assert CellComparison(a, b).known_share(Similarity()) == 1.0
    assert CellComparison(a, b).known_share(Similarity(1.0, 0.0, 1.0, 0.0)) == pytest.approx(4 / 6)
