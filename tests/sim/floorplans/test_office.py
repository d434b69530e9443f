import numpy as np
import pytest

from sim.floorplans import Office, make_world
from sim.motion.driving import PathPlanner, make_drive_field, nearest_drivable
from tests.marking import some_slow

SPECS = [
    Office(rooms=rooms, size_m=(16.0 + rooms, 12.0), oblique=rooms % 2, yaw_deg=0.0, shut=0.0, changed=0.0)
    for rooms in (6, 9, 12)
]


@pytest.mark.parametrize("spec", SPECS)
@pytest.mark.parametrize("seed", some_slow([0, 1], 0))
def test_a_robot_can_drive_between_all_rooms_of_every_office(spec, seed):
    world = make_world(spec, seed)
    field = make_drive_field(world)
    planner = PathPlanner(field)

    assert len(world.rooms) == spec.rooms + 1  # and the corridor
    for room in world.rooms:
        row, col = nearest_drivable(field, room.spot)
        assert np.hypot(*(np.array([col, row]) * 0.1 + 0.05 - room.spot)) < 1e-6
        assert planner.path(world.rooms[0].spot, room.spot) is not None


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
        for prism in make_world(Office(oblique=oblique, yaw_deg=0.0), 2).walls:
            edges = np.abs(np.roll(prism.outline, -1, axis=0) - prism.outline)
            if len(prism.outline) == 4 and np.sort(edges.min(axis=1))[1] > 1e-6:
                return True
        return False

    assert not leans(0.0)
    assert leans(1.0)
