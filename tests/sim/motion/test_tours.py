import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rectmerge.errors import SimulationError
from sim.motion.driving import PathPlanner, make_drive_field
from sim.motion.tours import (
    APART_M,
    choose_starts,
    find_stops,
    keep_apart,
    make_tour,
    middle_rooms,
    order_by_nearest,
    share_rooms,
    shorten_round,
)
from sim.world import Prism
from tests.sim.small_worlds import box_world, plain_office, rectangle

WORLD = plain_office(1, size_m=(16.0, 11.0))
DRIVE = make_drive_field(WORLD)
WAYS = PathPlanner(DRIVE)
BOX = make_drive_field(box_world(6.0, 6.0))


def test_shares_begin_at_opposite_ends_and_together_leave_no_room_out():
    left, right = (share_rooms(WORLD, 0.6, from_left=side) for side in (True, False))
    names = {room.name for room in left} | {room.name for room in right}

    assert names == {room.name for room in WORLD.rooms}
    assert {room.name for room in left} & {room.name for room in right}
    assert np.mean([room.spot[0] for room in left]) < np.mean([room.spot[0] for room in right])


def test_robots_between_the_ends_share_the_rooms_from_left_to_right():
    shares = [middle_rooms(WORLD, 0.4, at) for at in (0.0, 0.3, 0.6, 1.0)]

    assert {room.name for rooms in shares for room in rooms} == {room.name for room in WORLD.rooms}
    assert {room.name for room in shares[0]} == {room.name for room in share_rooms(WORLD, 0.4, from_left=True)}
    middles = [np.mean([room.outline.mean(axis=0)[0] for room in rooms]) for rooms in shares]
    assert middles == sorted(middles)


def test_a_tour_stops_in_every_room():
    stops = find_stops(DRIVE, WORLD.rooms, np.random.default_rng(0))
    tour = make_tour(WAYS, stops, stops[2][1])

    assert {name for name, _ in tour.stops} == {room.name for room in WORLD.rooms}
    assert np.allclose(tour.stops[0][1], stops[2][1])


def test_a_tour_that_closes_its_loop_ends_at_its_start():
    stops = find_stops(DRIVE, WORLD.rooms, np.random.default_rng(0))
    tour = make_tour(WAYS, stops, stops[0][1], closes_loop=True)
    for _ in stops:
        tour.arrive()

    assert not tour.is_done
    assert np.hypot(*(tour.path(stops[3][1])[-1] - stops[0][1])) < 0.11
    tour.arrive()
    assert tour.is_done


@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(st.floats(0.6, 5.4), st.floats(2.2, 5.4)), min_size=5, max_size=5))
def test_a_round_is_no_longer_for_being_shortened_and_nearly_the_shortest(points):
    planner = PathPlanner(BOX)
    stops = [(str(k), np.array(point)) for k, point in enumerate(points)]
    before = order_by_nearest(planner, stops, 0)
    after = shorten_round(planner, before)

    def length(order):
        return sum(planner.cost_m(p, q) for (_, p), (_, q) in zip(order, order[1:] + order[:1], strict=True))

    assert after[0][0] == before[0][0]
    assert {name for name, _ in after} == {name for name, _ in stops}
    best = min(length([stops[0], *rest]) for rest in itertools.permutations(stops[1:]))
    assert length(after) <= length(before) + 1e-6
    assert length(after) <= 1.25 * best + 0.2


def test_a_spot_that_something_stands_on_is_moved_and_a_room_that_is_full_left_out():
    doors = [name for door in WORLD.doors for name in door.joins]
    first, second, *_ = (room for room in WORLD.rooms if doors.count(room.name) == 1)  # no way leads through them
    others = [room for room in WORLD.rooms if room not in (first, second)]
    low, high = second.outline.min(axis=0), second.outline.max(axis=0)
    crate = Prism(rectangle(*(first.spot - 0.2), *(first.spot + 0.2)), 1.0)
    full = Prism(rectangle(*low, *high), 1.0)
    drive = make_drive_field(replace(WORLD, furniture=(*WORLD.furniture, crate, full)))
    stops = find_stops(drive, (first, second, *others), np.random.default_rng(0))

    assert {name for name, _ in stops} == {room.name for room in (first, *others)}
    assert all(np.abs(spot - first.spot).max() > 0.4 for name, spot in stops if name == first.name)


def test_rooms_that_are_not_there_or_cannot_be_entered_are_one_clear_line():
    with pytest.raises(SimulationError, match="no rooms to tour"):
        find_stops(DRIVE, (), np.random.default_rng(0))
    nowhere = replace(WORLD.rooms[0], outline=WORLD.rooms[0].outline + 100, spot=WORLD.rooms[0].spot + 100)
    with pytest.raises(SimulationError, match="none of the 1 rooms"):
        find_stops(DRIVE, (nowhere,), np.random.default_rng(0))


def test_a_stop_that_cannot_be_got_to_is_tried_last_and_then_left_out():
    stops = [(name, np.array([x, 3.0])) for name, x in (("one", 1.0), ("two", 3.0), ("three", 5.0))]
    tour = make_tour(PathPlanner(BOX), stops, stops[0][1])
    tour.put_off()
    assert [name for name, _ in tour.stops] == ["two", "three", "one"]
    tour.arrive()
    tour.arrive()
    tour.put_off()

    assert tour.is_done
    assert tour.visited == ["two", "three"]
    assert tour.note == "could not get to one"


def test_the_last_stop_is_tried_twice_too_and_every_stop_that_was_left_out_is_told():
    stops = [(name, np.array([x, 3.0])) for name, x in (("one", 1.0), ("two", 3.0))]
    tour = make_tour(PathPlanner(BOX), stops, stops[0][1])
    for left in (["two", "one"], ["one", "two"], ["two"]):
        tour.put_off()
        assert [name for name, _ in tour.stops] == left
    tour.put_off()
    assert tour.is_done
    assert tour.note == "could not get to one; could not get to two"

    alone = make_tour(PathPlanner(BOX), stops[:1], stops[0][1])
    alone.put_off()
    assert not alone.is_done
    alone.put_off()
    assert alone.is_done


@pytest.mark.parametrize("apart", [0.0, 0.3, 0.7, 1.0])
def test_starts_are_as_far_apart_as_wanted(apart):
    def gap(share, seed):
        return WAYS.cost_m(*choose_starts(DRIVE, WAYS, share, np.random.default_rng(seed)))

    assert np.mean([gap(apart, seed) for seed in range(5)]) >= np.mean([gap(apart - 0.3, seed) for seed in range(5)])
    assert gap(1.0, 1) > 10.0


def test_starts_of_many_robots_lie_between_those_of_two():
    two = choose_starts(DRIVE, WAYS, 0.8, np.random.default_rng(1))
    five = choose_starts(DRIVE, WAYS, 0.8, np.random.default_rng(1), 5)

    assert np.array_equal(five[0], two[0])
    assert np.array_equal(five[-1], two[1])
    ways = [WAYS.cost_m(five[0], spot) for spot in five[1:]]
    assert ways == sorted(ways)


@settings(max_examples=30, deadline=None)
@given(st.floats(0.5, 5.5), st.floats(0.5, 5.5))
def test_starts_are_kept_apart(x, y):
    other = np.array([3.0, 4.0])
    start = keep_apart(BOX, np.array([x, y]), other)

    assert np.hypot(*(start - other)) >= APART_M - 1e-9
    with pytest.raises(SimulationError, match="no place for another robot"):
        keep_apart(make_drive_field(box_world(1.5, 1.2)), np.array([0.7, 0.6]), np.array([0.7, 0.6]))
