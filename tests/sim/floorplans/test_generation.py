import cv2
import numpy as np
import pytest

from rectmerge.errors import InputError, SimulationError
from sim.floorplans import FAMILIES, Loop, Office, Round, families, generation, make_world
from sim.motion.driving import make_drive_field, nearest_drivable
from sim.world import Room, World
from tests.marking import some_slow
from tests.sim.floorplans.buildings import plain, usual

MANY = [(family, seed) for family in FAMILIES for seed in range(1, 6)]


def require_reachable(world: World) -> None:
    for visit in (0, 1):
        field = make_drive_field(world.at_visit(visit))
        for room in world.rooms:
            row, col = nearest_drivable(field, room.spot)
            assert np.hypot(*(np.array([col, row]) * 0.1 + 0.05 - room.spot)) < 1e-6, (visit, room.name)


def require_sealed(world: World) -> None:
    """Assert that only free cells can be reached from a room, and nothing outside."""
    grid = world.raster(0.05)
    ways = np.pad(~grid.occupied, 1, constant_values=True).astype(np.uint8)
    labels = cv2.connectedComponents(ways, connectivity=4)[1]
    inside = labels[1:-1, 1:-1][grid.free]

    assert not np.isin(labels[0, 0], inside)
    assert not np.isin(labels[1:-1, 1:-1][grid.unknown], inside).any()


@pytest.mark.parametrize("family", some_slow(FAMILIES, "office"))
def test_a_robot_reaches_every_room_during_both_visits(family):
    require_reachable(usual(family, 0))


@pytest.mark.parametrize("family", FAMILIES)
def test_all_floor_is_free_and_nothing_leads_out(family):
    require_sealed(usual(family, 0))


@pytest.mark.slow
@pytest.mark.parametrize(("family", "seed"), MANY)
def test_many_more_buildings_are_reachable_and_sealed(family, seed):
    world = make_world(FAMILIES[family](), seed)

    require_reachable(world)
    require_sealed(world)


@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize(
    "knobs",
    [
        {"door_m": (0.8, 0.8), "wall_m": (0.4, 0.4)},
        {"door_m": (2.4, 2.4), "size_m": (34.0, 26.0), "furniture": 0.5},
        {"shut": 1.0, "glass": 1.0, "changed": 1.0},
        {"furniture": 5.0, "yaw_deg": 45.0},
    ],
)
def test_extreme_knobs_still_give_reachable_buildings(family, knobs):
    world = make_world(FAMILIES[family](**knobs), 3)

    require_reachable(world)
    require_sealed(world)


@pytest.mark.parametrize("family", some_slow(FAMILIES, "office"))
def test_everything_lies_within_the_size_asked_for(family):
    world, asked = plain(family, 0), FAMILIES[family]().size_m
    corners = np.concatenate([prism.outline for prism in (*world.obstacles, *world.visits[0], *world.visits[1])])

    assert corners.min() >= 0.0
    assert (corners.max(axis=0) <= np.array(world.size) + 1e-9).all()
    assert (np.array(world.size) <= np.array(asked) + 1e-9).all()
    assert world.size[0] > 0.97 * asked[0]


@pytest.mark.parametrize("family", FAMILIES)
def test_rooms_do_not_overlap_and_have_names_of_their_own(family):
    world = plain(family, 0)
    points = np.random.default_rng(0).uniform(0.0, world.size, (3000, 2))
    count = sum(_within(room.outline, points).astype(int) for room in world.rooms)

    assert min(room.area_m2 for room in world.rooms) > 4.0
    assert np.max(count) == 1
    assert len({room.name for room in world.rooms}) == len(world.rooms) >= 5
    assert {name for door in world.doors for name in door.joins} <= {room.name for room in world.rooms}


def _within(outline, points):
    edges = np.roll(outline, -1, axis=0) - outline
    inside = np.ones(len(points), dtype=bool)
    for corner, edge in zip(outline, edges, strict=True):
        inside &= edge[0] * (points[:, 1] - corner[1]) - edge[1] * (points[:, 0] - corner[0]) > 1e-6
    return inside


@pytest.mark.parametrize("family", some_slow(FAMILIES, "office"))
def test_the_same_seed_gives_the_same_building_and_another_seed_another(family):
    first, again = usual(family, 0).to_json_dict(), make_world(FAMILIES[family](), 0).to_json_dict()
    other = make_world(FAMILIES[family](furniture=0.0), 1).to_json_dict()

    assert first == again
    assert first["walls"] != other["walls"]
    assert (first["family"], first["seed"], other["seed"]) == (family, 0, 1)


@pytest.mark.parametrize("family", FAMILIES)
def test_doors_are_as_wide_as_asked_for_and_differ(family):
    worlds = (usual(family, 0), make_world(FAMILIES[family](furniture=0.0), 1))
    widths = [door.width_m for world in worlds for door in world.doors]

    assert min(widths) > 0.8 - 1e-9
    assert max(widths) < 1.6 + 1e-9
    assert len(np.unique(np.round(widths, 6))) > 1


def test_walls_doors_and_yaw_are_drawn_anew_for_every_building():
    thickness, yaws = [], []
    for seed in range(12):
        world = make_world(Office(furniture=0.0, oblique=0.0), seed)
        bars = [prism.outline for prism in world.walls]
        sides = np.array([np.sort(np.hypot(*np.diff(bar[:3], axis=0).T)) for bar in bars if len(bar) == 4])
        thickness.append(np.median(sides[4:, 0]))  # behind the shell
        yaws.append(np.degrees(np.arctan2(*np.diff(world.rooms[0].outline[:2], axis=0)[0][::-1])) % 360)

    assert 0.06 < min(thickness) < max(thickness) <= 0.3 + 1e-9
    assert np.std(thickness) > 0.03
    assert len({yaw // 90 for yaw in yaws}) == 4


def test_a_building_is_turned_by_the_yaw_asked_for():
    upright, turned = (make_world(Office(yaw_deg=yaw, changed=0.0, shut=0.0, furniture=0.0), 1) for yaw in (0.0, 30.0))
    expected = upright.turned(np.pi / 6)

    assert np.allclose(expected.size, turned.size)
    for one, other in zip(expected.walls, turned.walls, strict=True):
        assert np.allclose(one.outline, other.outline)


@pytest.mark.parametrize("family", FAMILIES)
def test_no_share_of_glass_shut_doors_or_change_means_none(family):
    world = plain(family, 0)

    assert not world.glass
    assert world.visits == ((), ())
    assert all(door.is_open for door in world.doors)


@pytest.mark.parametrize("family", ["apartment", "round", "two-wing"])
def test_all_inner_partitions_may_be_glass(family):
    solid, clear = (make_world(FAMILIES[family](glass=share, shut=0.0, furniture=0.0), 0) for share in (0.0, 1.0))

    assert len(clear.glass) > 10
    assert len(clear.walls) + len(clear.glass) == len(solid.walls)


def test_doors_are_shut_only_where_nothing_is_cut_off():
    shut_doors = {"always": 0, "once": 0}
    for seed in range(6):
        world = make_world(FAMILIES["apartment"](shut=1.0, furniture=0.0, changed=0.5), seed)
        leaves = len(world.visits[0]) + len(world.visits[1])
        shut_doors["once"] += leaves
        shut_doors["always"] += sum(not door.is_open for door in world.doors) - leaves
        require_reachable(world)

    assert min(shut_doors.values()) >= 1


def test_a_shut_door_is_closed_in_the_raster():
    world = next(w for seed in range(9) if _shut(w := make_world(FAMILIES["apartment"](shut=1.0, changed=0.0), seed)))
    grid = world.raster(0.03)
    for door in world.doors:
        u, v = np.rint(grid.map_to_pixel(door.centre)).astype(int)
        assert grid.occupied[v, u] == (not door.is_open)


def _shut(world: World) -> bool:
    return any(not door.is_open for door in world.doors)


@pytest.mark.parametrize(("share", "least", "most"), [(0.2, 0.1, 0.3), (1.0, 1.0, 1.0)])
def test_the_share_asked_for_differs_between_the_visits(share, least, most):
    world = make_world(FAMILIES["warehouse"](changed=share, shut=0.0, furniture=0.0), 0)
    pallets = [prism for prism in world.furniture if prism.top < 2.0]
    once = (len(world.visits[0]) + len(world.visits[1])) / 1.5  # half of what changes is moved and counts twice

    assert least <= once / (len(pallets) + once) <= most


def test_what_cannot_be_built_says_what_may_help(monkeypatch):
    monkeypatch.setattr(generation, "DRAFTS", 2)
    with pytest.raises(SimulationError, match=r"2 drafts of this round failed.*door_m"):
        make_world(Round(door_m=(0.7, 0.7), wall_m=(0.4, 0.4), furniture=0.0), 0)


def test_families_are_listed_with_a_line_each():
    assert set(families()) == set(FAMILIES)
    assert all(20 < len(line) < 110 for line in families().values())
    assert {name: kind.family for name, kind in FAMILIES.items()} == {name: name for name in FAMILIES}


@pytest.mark.parametrize("spec", [Office(yaw_deg=0.0, oblique=0.0), Loop(yaw_deg=0.0)], ids=lambda spec: spec.family)
def test_storeys_have_the_same_outer_walls_and_corridors_and_other_rooms(spec):
    first, second, again = (make_world(spec, 3, storey=storey) for storey in (0, 1, 1))

    assert {outline.tobytes() for outline in corridors(first)} == {outline.tobytes() for outline in corridors(second)}
    assert [wall.outline.tolist() for wall in first.walls[:4]] == [wall.outline.tolist() for wall in second.walls[:4]]
    assert {tuple(room.spot) for room in first.rooms}.isdisjoint(tuple(room.spot) for room in rooms(second))
    assert second.to_json_dict() == again.to_json_dict()
    require_reachable(second)
    require_sealed(second)


def test_a_building_without_storeys_says_so():
    with pytest.raises(InputError, match="storey must be 0 for a building of family round, got 1"):
        make_world(Round(), 0, storey=1)


def corridors(world: World) -> list[np.ndarray]:
    return [room.outline for room in world.rooms if "corridor" in room.name]


def rooms(world: World) -> list[Room]:
    return [room for room in world.rooms if "corridor" not in room.name]
