"""Real maps of several places, mixed: found by RECTMERGE_REAL_MAPS. The whole sets are joined by `real_fleets`."""

import pytest

from rectmerge.fleet.many import align_many
from tests.rectmerge.fleet.real_fleets import ROOT, hand_held_maps_and_plans, mixed_places, robots_maps

pytestmark = [
    pytest.mark.real,
    pytest.mark.slow,  # 80 pairs of real maps
    pytest.mark.skipif(not ROOT, reason="RECTMERGE_REAL_MAPS names no folder with real maps"),
]


def test_hand_held_maps_and_plans_of_three_places_fall_into_three_components():
    maps, place = hand_held_maps_and_plans(most=3)

    graph = align_many(maps)

    assert len(maps) == 9
    assert len(graph.components) == 3
    assert mixed_places(graph, place) == 0
    assert len(graph.placements) >= 8  # a map that its own place contradicts is left out
    assert graph.asked <= 5 * len(maps)


def test_robots_maps_of_five_places_are_joined_with_none_of_another_place():
    maps, place = robots_maps(most=3, cells=200_000)

    graph = align_many(maps)

    assert len(set(place.values())) == 5
    assert len(maps) == 15
    assert mixed_places(graph, place) == 0
    assert len(graph.placements) >= 14
    assert graph.asked <= 5 * len(maps)
