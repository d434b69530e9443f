import math

import numpy as np
import pytest

from rectmerge.fleet.complex_similarity import ComplexSimilarity
from rectmerge.fleet.wall_witness import WallWitness
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from tests.rectmerge.fleet.fleets import fleet


@pytest.mark.parametrize("seed", range(3))
def test_walls_speak_for_the_true_placement_and_against_others(seed):
    made = fleet(seed, home=2, other=1, side=190)
    witness = WallWitness(list(made.maps.values()))
    truth = made.b_to_a("home0", "home1")
    wrong = Similarity(truth.scale, truth.angle + 0.7, truth.tx, truth.ty)

    at_truth, at_wrong, of_another = (
        witness.log_odds(pair, ComplexSimilarity.from_similarity(place))
        for pair, place in (((0, 1), truth), ((0, 1), wrong), ((0, 2), truth))
    )

    assert at_truth > 2.0
    assert max(at_wrong, of_another) < -4.0


def test_swapped_maps_say_the_same():
    made = fleet(1, home=2, other=0, side=190)
    witness = WallWitness(list(made.maps.values()))
    placement = ComplexSimilarity.from_similarity(made.b_to_a("home0", "home1"))

    assert witness.log_odds((0, 1), placement) == pytest.approx(witness.log_odds((1, 0), placement.inverse()), abs=1.0)


def test_maps_without_walls_say_no():
    free = OccupancyGrid(np.zeros((40, 40), np.int8))

    assert WallWitness([free, free]).log_odds((0, 1), ComplexSimilarity()) == -math.inf
