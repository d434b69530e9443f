import numpy as np
import pytest

from rectmerge.fleet.params import PartnerParams
from rectmerge.fleet.signature import partners, signature, similarities
from rectmerge.grid import FREE, OccupancyGrid
from rectmerge.similarity import Similarity
from tests import drawing
from tests.rectmerge.fleet.fleets import fleet, plan

PARAMS = PartnerParams()


@pytest.mark.parametrize("change", ["turned", "rescaled", "mirrored"])
def test_a_changed_copy_is_the_most_similar_map(change):
    building = plan(0)
    middle = np.array(building.shape[::-1]) / 2
    if change == "mirrored":
        copy = OccupancyGrid(building.occupancy[:, ::-1])
    else:
        turn = Similarity(1.0, 0.7) if change == "turned" else Similarity(0.7)
        tx, ty = middle - turn.apply([170, 170])
        copy = drawing.view(building, Similarity(turn.scale, turn.angle, float(tx), float(ty)), (340, 340))
    others = [plan(seed) for seed in range(1, 8)]

    cosine = similarities([signature(grid, PARAMS) for grid in [copy, building, *others]], PARAMS)

    assert np.argmax(cosine[0]) == 1


def test_maps_of_one_building_rank_above_those_of_another():
    ranks = []
    for seed in range(4):
        made = fleet(seed, home=5, other=5, side=170)
        names = list(made.maps)
        cosine = similarities([signature(grid, PARAMS) for grid in made.maps.values()], PARAMS)
        assert cosine == pytest.approx(cosine.T)
        for index, name in enumerate(names):
            best = names[int(np.argmax(cosine[index]))]
            ranks.append(made.place[best] == made.place[name])

    assert np.mean(ranks) > 0.8


def test_a_map_without_walls_is_like_none():
    empty = signature(OccupancyGrid(np.full((30, 30), FREE, np.int8)), PARAMS)

    assert len(empty.words) == 0
    cosine = similarities([empty, empty, signature(plan(0), PARAMS)], PARAMS)
    assert (cosine[~np.eye(3, dtype=bool)] == 0).all()


def test_partners_are_the_most_similar_maps_of_each():
    cosine = np.array(
        [[-np.inf, 0.9, 0.1, 0.2], [0.9, -np.inf, 0.3, 0.1], [0.1, 0.3, -np.inf, 0.2], [0.2, 0.1, 0.2, -np.inf]]
    )

    assert partners(cosine, 1) == [(0, 1), (0, 3), (1, 2)]
    assert len(partners(cosine, 9)) == 6
