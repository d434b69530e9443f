import numpy as np
import pytest

from sim.motion.driving import PathPlanner, make_drive_field
from sim.motion.piloting import BACK_OFF_S, MOST_BACK_OFFS, STUCK_AFTER_S, Pilot, mind_nearest
from sim.motion.steering import Steering
from sim.motion.tours import Tour
from tests.sim.small_worlds import box_world, corridor_world, drive_exactly, wall_distance

TOUCHING_M = 0.34  # between the centres of two robots


def pilot_to(planner: PathPlanner, *goals: tuple[float, float], gives_way: bool = False) -> Pilot:
    stops = [(f"stop {k}", np.array(goal)) for k, goal in enumerate(goals)]
    return Pilot(Tour(planner, stops), planner, Steering(speed_m_s=0.9), gives_way=gives_way)


def meet(a: Pilot, b: Pilot) -> list[Pilot]:
    a.other, b.other = b, a
    return [a, b]


def test_a_robot_drives_through_its_stops_off_the_walls():
    world = box_world()
    pilot = pilot_to(PathPlanner(make_drive_field(world)), (5.2, 1.35), (1.0, 3.0))
    track, seconds = drive_exactly([pilot], [(1.0, 1.35, 3.0)], 60.0)

    assert pilot.guide.visited == ["stop 0", "stop 1"]
    assert seconds < 30
    assert wall_distance(world, track[0, :, :2]).min() > 0.2


def test_a_robot_that_does_not_move_backs_off_and_in_the_end_gives_up_and_says_so():
    pilot = pilot_to(PathPlanner(make_drive_field(box_world())), (5.0, 3.0))
    pose = np.array([1.0, 1.0, 0.0])
    long_enough = round((MOST_BACK_OFFS + 2) * (STUCK_AFTER_S + BACK_OFF_S + 1) * 10)
    speeds = [pilot.command(pose, k / 10)[0] for k in range(long_enough)]

    assert min(speeds) < 0
    assert pilot.is_done
    assert pilot.note.startswith("stuck on the way to stop 0")
    assert pilot.guide.visited == []


@pytest.mark.parametrize("width", [0.9, 1.2, 1.6, 2.2])
@pytest.mark.parametrize("starts", [((1.7, 1.7, 0.0), (10.7, 1.7, 3.1)), ((4.2, 1.7, 0.0), (7.5, 1.7, 3.1))])
def test_two_robots_get_past_each_other_in_a_corridor(width, starts):
    world = corridor_world(width)
    planner = PathPlanner(make_drive_field(world))
    pilots = meet(pilot_to(planner, (10.7, 1.7)), pilot_to(planner, (1.7, 1.7), gives_way=True))
    track, _ = drive_exactly(pilots, list(starts), 120.0)

    assert [pilot.note for pilot in pilots] == ["", ""]
    assert [pilot.guide.visited for pilot in pilots] == [["stop 0"], ["stop 0"]]
    assert np.hypot(*(track[0] - track[1])[:, :2].T).min() > TOUCHING_M
    assert wall_distance(world, track[:, :, :2].reshape(-1, 2)).min() > 0.17


def test_three_robots_mind_the_nearest_and_get_past_each_other():
    planner = PathPlanner(make_drive_field(corridor_world(1.6)))
    pilots = [pilot_to(planner, goal) for goal in ((10.7, 1.7), (1.7, 1.7), (11.2, 1.0))]
    for pilot, x in zip(pilots, (1.7, 10.7, 2.6), strict=True):
        pilot.position = np.array([x, 1.7])

    mind_nearest(pilots)

    assert [pilots.index(pilot.other) for pilot in pilots] == [2, 2, 0]
    assert [pilot.gives_way for pilot in pilots] == [False, False, True]


def test_a_robot_that_has_ended_makes_room_for_one_that_has_not():
    planner = PathPlanner(make_drive_field(corridor_world(1.0)))
    done = pilot_to(planner, (6.0, 1.7))
    done.end()
    pilots = meet(done, pilot_to(planner, (10.7, 1.7), gives_way=True))
    track, _ = drive_exactly(pilots, [(6.0, 1.7, 3.1), (1.7, 1.7, 0.0)], 60.0)

    assert pilots[1].guide.visited == ["stop 0"]
    assert np.hypot(*(track[0] - track[1])[:, :2].T).min() > TOUCHING_M


def test_a_robot_behind_one_that_never_moves_gives_up_in_the_end_and_says_so():
    planner = PathPlanner(make_drive_field(corridor_world(1.0)))
    wreck = Pilot(Tour(planner, [("nowhere", np.array([6.0, 1.7]))]), planner, Steering())
    wreck.position = np.array([6.0, 1.7])
    pilot = pilot_to(planner, (10.7, 1.7), (11.0, 2.0))
    pilot.other = wreck
    _, seconds = drive_exactly([pilot], [(1.7, 1.7, 0.0)], 300.0)

    assert pilot.is_done
    assert pilot.note
    assert seconds < 200


def test_a_robot_that_does_not_look_all_round_turns_to_what_it_came_to_see():
    class Behind(Tour):
        @property
        def faces(self):
            return np.array([1.0, 3.0])

    planner = PathPlanner(make_drive_field(box_world()))
    pilot = Pilot(Behind(planner, [("here", np.array([3.0, 3.0]))]), planner, Steering(), turns_to_look=True)
    track, _ = drive_exactly([pilot], [(3.0, 3.0, 0.0)], 10.0)

    assert pilot.is_done
    assert abs(track[0, -1, 2]) > 2.4
