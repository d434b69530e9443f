from dataclasses import replace

import numpy as np

from scenarios.studies.mission_faults import crosses_walls, mission_faults
from sim.missions.mission_log import MissionLog
from tests.sim.small_worlds import office_log


def standing(log: MissionLog, seconds: float, note: str = "") -> MissionLog:
    """Return the log with a robot A that stands where it was first."""
    poses = np.repeat(log.a.poses[:1], len(log.a.times), axis=0)
    return replace(log, a=replace(log.a, poses=poses, times=np.linspace(0, seconds, len(poses)), note=note))


def test_a_robot_that_crosses_a_wall_is_found_out():
    log = office_log()
    door_to_door = replace(log.a, poses=log.a.poses[[0, 0]], times=log.a.times[:2])
    out = np.add(door_to_door.poses, [[0, 0, 0], [log.world.size[0], 0, 0]])

    assert not crosses_walls(log.world, door_to_door, 0)
    inside = np.clip(out, 0.0, [*log.world.size, np.inf]) - [0.01, 0.0, 0.0]
    assert crosses_walls(log.world, replace(door_to_door, poses=inside), 0)


def test_a_robot_that_stands_still_has_to_say_so():
    log = office_log()
    faults = mission_faults(standing(log, 40.0))

    assert any("did not say so" in fault for fault in faults)
    assert not any(
        "did not say so" in fault and "A" in fault for fault in mission_faults(standing(log, 40.0, "no progress"))
    )
