"""Maps that bend against each other, each bent onto the merged map of the others."""

from functools import cache

import rectmerge as rm
from rectmerge.fleet.asking import PairAsker
from rectmerge.fleet.many import build_graph
from rectmerge.grid import UNKNOWN, OccupancyGrid
from tests.rectmerge.elastic.test_unbend import bent_case, rmse
from tests.rectmerge.fleet.fleets import Fleet, Oracle

BENT = {"b0": 0, "b2": 2, "b3": 3}


@cache
def bent_fleet():
    """A straight map, three that bend against it, and the graph that their best similarities give."""
    made = Fleet()
    made.add("a", "home", bent_case(0)[0], rm.Similarity())
    for name, seed in BENT.items():
        _, b, _, _, fit = bent_case(seed)
        made.add(name, "home", b, fit)
    ask = PairAsker(Oracle(made, noise=0.0), "free", 0, is_checked=False)
    return made.maps, build_graph(made.maps, ask)


@cache
def bends():
    return rm.unbend_many(*bent_fleet())


def test_every_map_but_the_reference_is_bent_to_where_it_belongs():
    assert list(bends()) == list(BENT)
    for name, seed in BENT.items():
        a, b, cells, true, fit = bent_case(seed)
        found = a.map_to_pixel(bends()[name].apply(b.pixel_to_map(cells)))
        assert bends()[name], bends()[name].reason
        assert rmse(found, true) <= 0.5 * rmse(fit.apply(cells), true)


def test_the_merged_map_has_thinner_walls_than_that_of_similarities():
    maps, graph = bent_fleet()
    places = [None, *(graph.placements[name].to_reference for name in BENT)]
    rigid = rm.compose(list(maps.values()), places, rule="occupied").grid
    straight = [maps["a"], *(bends()[name].straighten(maps[name]) for name in BENT)]
    assert rm.compose(straight, places, rule="occupied").grid.occupied.sum() < 0.6 * rigid.occupied.sum()


def test_maps_that_do_not_bend_stay_as_they_are():
    a = bent_case(0)[0]
    half = a.occupancy.copy()
    half[:, : a.shape[1] // 3] = UNKNOWN
    made = Fleet()
    for name, grid in (("a", a), ("half", OccupancyGrid(half)), ("again", OccupancyGrid(a.occupancy.copy()))):
        made.add(name, "home", grid, rm.Similarity())
    ask = PairAsker(Oracle(made, noise=0.0), "free", 0, is_checked=False)
    found = rm.unbend_many(made.maps, build_graph(made.maps, ask))
    assert {name: bend.accepted for name, bend in found.items()} == {"half": False, "again": False}
    assert all(bend.straighten(made.maps[name]) is made.maps[name] for name, bend in found.items())
