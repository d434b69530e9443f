import numpy as np

from sim.driving import Steering, drivable
from sim.exploration import BACK_OFF_S, MOST_BACK_OFFS, STUCK_AFTER_S, Tour, make_tour, share_rooms
from sim.floorplans import Office, make_world
from tests.sim.made import box_world

WORLD = make_world(Office(size_m=(16.0, 11.0), rooms=6), 1)


def test_shares_begin_at_opposite_ends_and_together_leave_no_room_out():
    left, right = (share_rooms(WORLD, 0.6, from_left=side) for side in (True, False))
    names = {room.name for room in left} | {room.name for room in right}

    assert names == {room.name for room in WORLD.rooms}
    assert {room.name for room in left} & {room.name for room in right}
    assert np.mean([room.spot[0] for room in left]) < np.mean([room.spot[0] for room in right])


def test_a_tour_stops_in_every_room():
    start, tour = make_tour(WORLD, drivable(WORLD), WORLD.rooms, Steering(), np.random.default_rng(0))

    assert {name for name, _ in tour.stops} == {room.name for room in WORLD.rooms}
    assert np.allclose(start[:2], tour.stops[0][1])


def test_a_robot_that_does_not_move_backs_off_and_in_the_end_gives_up_and_says_so():
    world = box_world()
    tour = Tour(drivable(world), (("room", np.array([5.0, 3.0])),), Steering())
    pose = np.array([1.0, 1.0, 0.0])
    long_enough = round((MOST_BACK_OFFS + 2) * (STUCK_AFTER_S + BACK_OFF_S + 1) * 10)
    speeds = [tour.command(pose, k / 10)[0] for k in range(long_enough)]

    assert min(speeds) < 0
    assert tour.is_done
    assert tour.note.startswith("stuck on the way to room")
    assert tour.visited == []
