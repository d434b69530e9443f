from dataclasses import replace

import numpy as np
import pytest

from sim.motion.coverage import SeenFloor
from sim.motion.driving import PathPlanner, make_drive_field
from sim.motion.frontiers import Frontiers
from sim.motion.piloting import Pilot
from sim.motion.steering import Steering
from sim.sensors.lidar import Lidar
from sim.sensors.ray_casting import Caster
from sim.world import World
from tests.sim.small_worlds import box_world, corridor_world, drive_exactly, plain_office, wall_distance


class Scanning(Pilot):
    """Pilot whose robot scans before every command, four times a second."""

    def scan_with(self, caster, lidar):
        self._eyes, self._count = (caster, lidar), 0
        return self

    def command(self, pose, time):
        if round(time * 20) % 5 == 0 and not self.is_done:
            caster, lidar = self._eyes
            reading = caster.cast(pose, lidar.angles, lidar.max_range_m, np.empty((0, 3)))
            self.guide.seen.add(pose[None], reading.ranges[None])
            if self.guide.is_path_outdated():
                self.replan()
        return super().command(pose, time)


def explore(world: World, lidar: Lidar, start: tuple[float, float], *, closes_loop: bool = False):
    planner = PathPlanner(make_drive_field(world))
    seen = SeenFloor(lidar, planner.prices.shape)
    guide = Frontiers(planner, seen, np.array(start) if closes_loop else None)
    pilot = Scanning(guide, planner, Steering(speed_m_s=0.9), turns_to_look=lidar.fov_deg < 360)
    pilot.scan_with(Caster(world, lidar.height_m), lidar)
    track, seconds = drive_exactly([pilot], [(*start, 1.0)], 400.0)
    return pilot, seen, track[0], seconds


@pytest.mark.parametrize("lidar", [Lidar(beams=360), Lidar(beams=240, fov_deg=240.0, max_range_m=4.0)])
def test_a_robot_sees_all_of_a_building_that_has_no_rooms_and_then_ends(lidar):
    office = plain_office(3)
    world = replace(office, rooms=(), floor=tuple(room.outline for room in office.rooms))
    drive = make_drive_field(world)
    start = office.rooms[0].spot
    pilot, seen, track, seconds = explore(world, lidar, tuple(start))

    assert pilot.is_done
    assert seconds < 300
    assert seen.share_of(drive.is_drivable) > 0.99
    assert wall_distance(world, track[:, :2]).min() > 0.17


def test_a_robot_that_closes_its_loop_comes_back():
    pilot, _, track, _ = explore(corridor_world(1.2), Lidar(max_range_m=3.0), (1.7, 1.7), closes_loop=True)

    assert pilot.is_done
    assert track[:, 0].max() > 8.0
    assert np.hypot(*(track[-1, :2] - 1.7)) < 0.4


def test_a_robot_that_is_told_to_finish_explores_no_more():
    planner = PathPlanner(make_drive_field(corridor_world(1.2)))
    guide = Frontiers(planner, SeenFloor(Lidar(), planner.prices.shape))
    assert guide.path(np.array([1.7, 1.7])) is None  # nothing has been seen, so no way is known
    guide.finish()

    assert guide.is_done


def test_a_narrow_way_out_is_taken_where_there_is_no_other():
    planner = PathPlanner(make_drive_field(box_world(6.0, 6.0)))
    seen = SeenFloor(Lidar(), planner.prices.shape)
    seen.is_hit[34:40, 9:30] = True
    seen.is_hit[35:39, 10:30] = False
    seen.since[35:39, 10:30] = 0  # a passage four cells wide, and all its frontier

    path = Frontiers(planner, seen).path(np.array([1.2, 3.7]))
    assert path is not None
    assert path[-1, 0] > 2.4
