import numpy as np
import pytest

from rectmerge.errors import InputError
from sim.driving import drivable, nearest_drivable, shortest_path
from sim.floorplans import WorldSpec, families, make_world

SPECS = [WorldSpec(rooms=rooms, size_m=(14.0 + rooms, 12.0), oblique=rooms % 2) for rooms in (6, 9, 12)]


@pytest.mark.parametrize("spec", SPECS)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_robot_can_drive_between_all_rooms_of_every_office(spec, seed):
    world = make_world(spec, seed)
    field = drivable(world)

    assert len(world.rooms) == spec.rooms + 1  # and the corridor
    for room in world.rooms:
        row, col = nearest_drivable(field, room.spot)
        assert np.hypot(*(np.array([col, row]) * 0.1 + 0.05 - room.spot)) < 1e-6
        assert len(shortest_path(field, world.rooms[0].spot, room.spot)[0]) >= 1


def test_everything_lies_within_the_size_asked_for():
    world = make_world(SPECS[1], 5)
    corners = np.concatenate([prism.outline for prism in world.walls])

    assert corners.min() >= 0.0
    assert np.allclose(corners.max(axis=0), world.size)


def test_the_same_seed_gives_the_same_building_and_another_seed_another():
    first, again, other = (make_world(SPECS[0], seed).as_dict() for seed in (7, 7, 8))

    assert first == again
    assert first["walls"] != other["walls"]


def test_rooms_of_one_office_are_not_identical():
    areas = sorted(room.area_m2 for room in make_world(SPECS[2], 1).rooms)

    assert min(np.diff(areas)) > 0.005
    assert areas[-1] > 1.5 * areas[0]


def test_doors_stand_open_in_the_raster():
    world = make_world(SPECS[1], 3)
    grid = world.raster(0.05)

    for door in world.doors:
        u, v = np.rint(grid.map_to_pixel(door.centre)).astype(int)
        assert grid.free[v, u], door.joins


def test_oblique_walls_appear_only_where_they_are_asked_for():
    def leans(oblique):
        for prism in make_world(WorldSpec(oblique=oblique), 2).walls:
            edges = np.abs(np.roll(prism.outline, -1, axis=0) - prism.outline)
            if (edges.min(axis=1) > 1e-6).any():
                return True
        return False

    assert not leans(0.0)
    assert leans(1.0)


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({"rooms": 5}, "rooms must be 6 to 12"),
        ({"rooms": 12, "size_m": (12.0, 12.0)}, "12 rooms do not fit"),
        ({"size_m": (20.0, 5.0)}, "size_m"),
        ({"oblique": 1.5}, "oblique"),
        ({"furniture": -1.0}, "furniture"),
    ],
)
def test_a_spec_says_what_is_wrong_with_it(values, complaint):
    with pytest.raises(InputError, match=complaint):
        WorldSpec(**values)


def test_families_are_listed_with_a_line_each():
    assert set(families()) == {"office"}
