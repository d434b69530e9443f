"""Properties of each family of buildings."""

import math

import numpy as np
import pytest

from sim.floorplans import FAMILIES, Clutter, Hall, Hospital, Loop, Office, Polygonal, TwoWing, Warehouse, make_world
from tests.marking import some_slow
from tests.sim.floorplans.buildings import PLAIN, plain, usual

UPRIGHT = ["office", "apartment", "warehouse", "loop", "hospital", "hall", "clutter"]


def directions(world):
    """Return the directions (degrees, 0 to 90) of all sides of walls, and their lengths."""
    edges = np.concatenate([np.roll(p.outline, -1, axis=0) - p.outline for p in world.walls])
    return np.degrees(np.arctan2(edges[:, 1], edges[:, 0])) % 90.0, np.hypot(*edges.T)


def share_along(world, degrees, within=1.0):
    """Return the share of the sides of walls, by length, that run along or across a direction."""
    angles, lengths = directions(world)
    off = np.abs((angles - degrees + 45.0) % 90.0 - 45.0)
    return float(lengths[off < within].sum() / lengths.sum())


def cells(world, half_turn=True):
    """Return the outlines in each room of a ward, in the frame of its corner, rounded to a millimetre."""
    seen = []
    outlines = [prism.outline for prism in (*world.walls, *world.furniture)]
    for room in world.rooms[1:]:
        low, high = room.outline.min(axis=0), room.outline.max(axis=0)
        inside = [o for o in outlines if (o > low - 0.01).all() and (o < high + 0.01).all()]
        is_south = room.name.startswith("south")
        local = [high - o if is_south else o - low for o in inside]
        seen.append(sorted(tuple(sorted(map(tuple, np.round(outline, 3) + 0.0))) for outline in local))
    return seen


@pytest.mark.parametrize("seed", [0, 1])
def test_the_rooms_of_a_ward_without_jitter_are_identical(seed):
    world = make_world(Hospital(**PLAIN), seed)
    first, *others = cells(world)

    assert len(first) >= 2
    assert all(other == first for other in others)
    assert np.ptp([room.area_m2 for room in world.rooms[1:]]) < 1e-6
    assert np.ptp([door.width_m for door in world.doors]) < 1e-9


def test_jitter_makes_the_rooms_of_a_ward_differ():
    world = make_world(Hospital(**PLAIN, jitter_m=0.2), 0)
    first, *others = cells(world)

    assert all(other != first for other in others)
    assert 0.1 < np.ptp([room.area_m2 for room in world.rooms[1:]]) < 8.0
    assert np.ptp([door.width_m for door in world.doors]) > 0.05


@pytest.mark.parametrize("seed", range(4))
def test_two_wings_have_two_dominant_orientations(seed):
    world = make_world(TwoWing(**PLAIN, furniture=0.0), seed)
    east = next(room for room in world.rooms if room.name == "east corridor")
    edge = east.outline[1] - east.outline[0]
    turned = math.degrees(math.atan2(edge[1], edge[0])) % 90.0

    assert 25.0 <= turned <= 65.0
    assert 0.3 < share_along(world, 0.0) < 0.7
    assert 0.3 < share_along(world, turned) < 0.7


@pytest.mark.parametrize("family", some_slow(UPRIGHT, "office", "hall"))
def test_upright_families_have_one_orientation(family):
    assert share_along(plain(family, 0), 0.0) > 0.85


@pytest.mark.parametrize("seed", range(4))
def test_the_simple_environment_meets_the_papers_two_conditions(seed):
    world = make_world(Polygonal(**PLAIN, furniture=0.0), seed)
    shapes = [len(room.outline) for room in world.rooms]
    low, high = (
        np.abs(np.concatenate([p.outline for p in world.walls])[:, 1] - y) < 1e-6 for y in (0.0, world.size[1])
    )

    assert low.sum() >= 2  # two outer walls are parallel
    assert high.sum() >= 2
    assert 3 in shapes or 5 in shapes
    assert share_along(world, 0.0) < 0.95


def test_round_buildings_have_walls_in_all_directions():
    angles, lengths = directions(plain("round", 0))
    share, _ = np.histogram(angles, bins=9, range=(0.0, 90.0), weights=lengths / lengths.sum())

    assert share.min() > 0.05


def test_round_buildings_fill_an_ellipse():
    world = plain("round", 0)
    area = sum(room.area_m2 for room in world.rooms)

    assert area == pytest.approx(math.pi / 4 * world.size[0] * world.size[1], rel=0.12)


def test_a_loop_can_be_driven_around_its_core():
    world = make_world(Loop(core=0, rooms=4, shut=0.0), 0)
    corridors = [room for room in world.rooms if room.name.startswith("corridor")]
    grid = world.raster(0.05)
    middle = np.mean([room.outline.mean(axis=0) for room in corridors], axis=0)
    u, v = np.rint(grid.map_to_pixel(middle)).astype(int)

    assert len(corridors) == 4
    assert grid.unknown[v, u]  # nobody can look into the core


def test_racks_stay_and_pallets_change_between_the_visits():
    world = make_world(Warehouse(furniture=0.0, changed=0.4, shut=0.0), 0)
    posts = [prism for prism in world.furniture if prism.top > 2.0]

    assert len(posts) > 60
    assert all(prism.top < 2.0 for visit in world.visits for prism in visit)
    assert sum(map(len, world.visits)) > 10


def test_a_full_rack_has_more_pallets_than_an_empty_one():
    full, empty = (make_world(Warehouse(**PLAIN, fill=fill, furniture=0.0), 0) for fill in (1.0, 0.0))

    assert len(full.furniture) > len(empty.furniture) + 50
    assert all(prism.top > 2.0 for prism in empty.furniture)


def test_pillars_stand_on_a_grid_until_they_are_jittered_or_missing():
    def pillars(**knobs):
        world = make_world(Hall(**PLAIN, furniture=0.0, side_rooms=0, **knobs), 0)
        return np.array([prism.outline.mean(axis=0) for prism in world.walls[4:]])

    grid = pillars(jitter_m=0.0, missing=0.0)
    assert len(np.unique(grid[:, 0].round(6))) * len(np.unique(grid[:, 1].round(6))) == len(grid) >= 6
    assert len(np.unique(pillars(jitter_m=0.3, missing=0.0)[:, 0].round(6))) == len(grid)
    assert len(pillars(jitter_m=0.0, missing=0.9)) < len(grid)


@pytest.mark.slow
def test_clutter_is_dense_and_turned():
    world = make_world(Clutter(**PLAIN), 1)
    edges = np.concatenate([np.diff(p.outline[:3], axis=0) for p in world.furniture if len(p.outline) == 4])
    off = np.abs((np.degrees(np.arctan2(edges[:, 1], edges[:, 0])) + 45.0) % 90.0 - 45.0)
    office = make_world(Office(**PLAIN), 1)

    assert (off > 3.0).mean() > 0.4
    assert len(world.furniture) > 1.3 * len(office.furniture)


@pytest.mark.parametrize(("family", "rooms"), [("apartment", 3), ("apartment", 8), ("clutter", 2), ("polygonal", 9)])
def test_a_family_has_as_many_rooms_as_asked_for(family, rooms):
    assert len(make_world(FAMILIES[family](rooms=rooms, size_m=(22.0, 15.0), furniture=0.5), 0).rooms) == rooms


@pytest.mark.parametrize("family", some_slow(FAMILIES, "office", "hall"))
def test_furniture_has_heights_that_robots_meet_or_see(family):
    for prism in usual(family, 0).furniture:
        assert prism.top > 0.3  # nothing that a robot hits below the laser
        assert prism.bottom <= 0.25 or prism.bottom >= 0.4
