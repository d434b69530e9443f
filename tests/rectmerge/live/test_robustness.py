"""The live merger over long runs and unruly robots."""

import gc
from collections import Counter

import numpy as np
import pytest

from rectmerge.alignment import Alignment
from rectmerge.fleet.graph import AlignmentGraph
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.live.merger import LiveMerger
from rectmerge.live.params import LiveParams
from rectmerge.live.replay import replay
from tests.rectmerge.live.growing import A, B, growing, known_part

HALL = OccupancyGrid(np.pad(np.full((60, 90), FREE, np.int8), 1, constant_values=OCCUPIED), 0.05)
CELL = OccupancyGrid(np.pad(np.full((12, 20), FREE, np.int8), 1, constant_values=OCCUPIED), 0.05)
KEPT = (OccupancyGrid, Alignment, AlignmentGraph)


def kept_objects():
    gc.collect()
    return Counter(type(each).__name__ for each in gc.get_objects() if issubclass(type(each), KEPT))


def play(merger, *rounds):
    """Put rounds of maps by robot to a merger; return the last publication and the changes of each round."""
    published, changes = None, []
    for maps in rounds:
        for robot, grid in maps.items():
            merger.update(robot, grid)
        published = merger.step()
        changes.append([(event.robot, event.change) for event in published.events])
    return published, changes


def test_memory_stays_however_many_maps_come():
    merger, counts = LiveMerger(), []
    for _ in range(3):
        for share in (0.6, 0.9, 0.6, 0.9):  # every map is another one, and is asked about
            play(merger, {"robot1": known_part(CELL, share), "robot2": known_part(CELL, 1.0)})
        counts.append(kept_objects())

    assert counts[0] == counts[1] == counts[2]


def test_a_robot_that_is_silent_keeps_its_place_and_comes_back_to_it():
    merger = LiveMerger()
    play(merger, *({"robot1": a, "robot2": b} for a, b in zip(growing(A), growing(B), strict=True)))
    silent, changes = play(merger, *({"robot1": A} for _ in range(3)))

    assert changes == [[], [], []]
    assert silent.statuses["robot2"].verdict == "accepted"
    back, changes = play(merger, {"robot1": A, "robot2": B})
    assert changes == [[]]
    assert "robot2" in back.placements


def test_a_map_that_shrinks_a_little_keeps_its_place():
    merger = LiveMerger()
    play(merger, *({"robot1": a, "robot2": b} for a, b in zip(growing(A), growing(B), strict=True)))
    less, changes = play(merger, {"robot2": known_part(B, 0.7)})

    assert changes == [[]]
    assert "robot2" in less.placements


def test_another_resolution_is_another_map_of_the_same_place():
    merger = LiveMerger(params=LiveParams(accepts=1))
    play(merger, {"robot1": A, "robot2": B})
    fine = OccupancyGrid(np.kron(B.occupancy, np.ones((2, 2), np.int8)), 0.025, B.origin)
    published, changes = play(merger, {"robot2": fine})

    assert ("robot2", "taken out") not in changes[0]
    assert "robot2" in published.placements


def test_two_robots_under_one_name_are_never_merged():
    merger = LiveMerger()
    other = known_part(HALL, 1.0)
    _, changes = play(merger, *({"robot1": A, "robot2": (B, other)[turn % 2]} for turn in range(4)))

    assert changes == [[]] * 4


def test_a_map_without_a_wall_and_one_of_a_few_cells_are_no_reason_to_stop():
    bare = np.full((40, 40), UNKNOWN, np.int8)
    bare[10:20, 10:20] = FREE
    published, changes = play(
        LiveMerger(params=LiveParams(accepts=1)),
        {"robot1": OccupancyGrid(bare, 0.05), "robot2": OccupancyGrid(np.zeros((2, 2), np.int8), 0.05)},
        {"robot1": A, "robot2": B},
    )

    assert changes == [[], [("robot2", "joined")]]
    assert sorted(published.statuses) == ["robot1", "robot2"]


@pytest.mark.parametrize("jump_s", [3600.0, 1e9])
def test_a_clock_that_jumps_ahead_makes_no_steps_without_maps(monkeypatch, jump_s):
    times = [0.0, 1.0, jump_s, jump_s + 1.0]
    maps = [(time, "/robot1/map", A) for time in times]
    monkeypatch.setattr("rectmerge.live.replay.bag_maps", lambda bag: iter(maps))
    steps = list(replay(["run.mcap"], LiveMerger(), period_s=1.0))

    assert len(steps) == 4
    assert steps[-1].time_s == pytest.approx(jump_s + 2.0)
