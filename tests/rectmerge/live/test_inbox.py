import gc
from types import SimpleNamespace

import numpy as np
import pytest

from rectmerge.errors import MapFileError
from rectmerge.grid import OccupancyGrid
from rectmerge.live.inbox import MapInbox
from tests.rectmerge.bags import map_message

WHOLE = np.zeros((3, 4), np.int8)


def update(value, **changes):
    fields = {"x": 1, "y": 0, "width": 1, "height": 1, "data": [value], **changes}
    return SimpleNamespace(**fields)


def taken(inbox):
    return {robot: newest.occupancy.tolist() for robot, newest in inbox.take()}


def test_the_newest_map_of_each_robot_is_taken_once():
    inbox = MapInbox()
    for number in range(10):
        inbox.put("robot1", map_message(cells=WHOLE + number))
        inbox.put("robot2", map_message(cells=WHOLE - 1 + number))

    assert taken(inbox) == {"robot1": (WHOLE + 9).tolist(), "robot2": (WHOLE + 8).tolist()}
    assert inbox.take() == []


def test_maps_that_nobody_takes_are_dropped():
    inbox = MapInbox()
    kinds = []
    for count in (10, 1000):
        for _ in range(count):
            inbox.put("robot1", map_message(cells=WHOLE))
            inbox.update("robot1", update(100))
        message = type(map_message())
        gc.collect()
        kinds.append(sum(issubclass(type(each), OccupancyGrid | message) for each in gc.get_objects()))

    assert kinds[0] == kinds[1]


def test_the_same_message_on_two_subscriptions_counts_once():
    inbox = MapInbox()
    inbox.put("robot1", map_message(cells=WHOLE), sent_ns=7)
    inbox.update("robot1", update(100))
    inbox.put("robot1", map_message(cells=WHOLE), sent_ns=7)

    assert taken(inbox)["robot1"][2] == [0, 100, 0, 0]  # the update is not lost
    inbox.put("robot1", map_message(cells=WHOLE), sent_ns=7)
    assert inbox.take() == []
    inbox.put("robot1", map_message(cells=WHOLE), sent_ns=5)  # a clock that jumps back
    assert taken(inbox) == {"robot1": WHOLE.tolist()}


@pytest.mark.parametrize(
    ("sent", "kept"),
    [
        ([("latched", 5), ("volatile", 6), ("latched", 6)], 6),
        ([("volatile", 6), ("latched", 5)], 6),  # an older one comes late
        ([("volatile", 6), ("latched", 6), ("volatile", 3)], 3),  # a publisher with a clock that runs anew
        ([("volatile", 6), ("volatile", 3), ("latched", 6), ("volatile", 4), ("latched", 3)], 4),
        ([("volatile", 6), ("volatile", 3), ("latched", 3), ("latched", 4)], 4),
    ],
)
def test_of_two_subscriptions_none_brings_back_an_older_map(sent, kept):
    inbox = MapInbox()
    for subscription, sent_ns in sent:
        inbox.put("robot1", map_message(cells=WHOLE + sent_ns), sent_ns, subscription)

    assert taken(inbox) == {"robot1": (WHOLE + kept).tolist()}


def test_updates_are_written_into_the_map_whether_it_was_taken_or_not():
    inbox = MapInbox()
    inbox.update("robot1", update(100))  # before there is a map
    assert inbox.take() == []
    inbox.put("robot1", map_message(cells=WHOLE))
    inbox.update("robot1", update(100))
    assert taken(inbox)["robot1"][2] == [0, 100, 0, 0]
    inbox.update("robot1", update(50, x=2))
    assert taken(inbox)["robot1"][2] == [0, 100, 50, 0]
    inbox.put("robot1", map_message(cells=WHOLE))
    assert taken(inbox)["robot1"] == WHOLE.tolist()


def test_an_update_that_does_not_fit_is_reported_and_leaves_the_map():
    inbox = MapInbox()
    inbox.put("robot1", map_message(cells=WHOLE))
    inbox.update("robot1", update(100, x=4))
    (_, newest), (robot, fault) = inbox.take()

    assert newest.occupancy.tolist() == WHOLE.tolist()  # a map that came before it is not lost
    assert robot == "robot1"
    assert isinstance(fault, MapFileError)
    assert "the map update of robot1: 1 x 1 cells at (4, 0) reach outside the map of 4 x 3" in str(fault)
    assert inbox.take() == []
    inbox.update("robot1", update(100))
    assert taken(inbox)["robot1"][2] == [0, 100, 0, 0]


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"cells": WHOLE - 1}, "all cells are unknown"),
        ({"cells": WHOLE + 100}, "no cell is free"),
        ({"cells": np.zeros((0, 0), np.int8)}, "0 x 0 cells are no map"),
        ({"cells": WHOLE, "size": (5, 5)}, "12 cells are not the stated 5 x 5"),
        ({"cells": WHOLE, "resolution": 0.0}, "resolution"),
        ({"cells": WHOLE, "at": (float("nan"), 0.0, 0.0)}, "origin"),
    ],
)
def test_a_message_that_is_no_map_is_told(changes, fault):
    inbox = MapInbox()
    inbox.put("robot1", map_message(**changes))
    inbox.update("robot1", update(0))

    assert fault in str(dict(inbox.take())["robot1"])
    assert inbox.take() == []
