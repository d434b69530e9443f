import itertools

import numpy as np
import pytest

from rectmerge.analysis.displacement import displacement_cells
from rectmerge.errors import MapFileError
from rectmerge.grid import FREE, OCCUPIED, OccupancyGrid, map_frame_to_pixels
from rectmerge.live.memory import Memory
from rectmerge.live.merger import LiveMerger
from rectmerge.live.params import LiveParams
from rectmerge.similarity import Similarity
from tests.rectmerge.live.growing import B_IN_A, SHARES, A, B, growing, known_part

OTHER = OccupancyGrid(np.pad(np.full((60, 90), FREE, np.int8), 1, constant_values=OCCUPIED), 0.05)  # an empty hall


def play(merger, *robots):
    """Put versions of each robot's map to the merger in turn; return the last publication and all events."""
    published, events = None, []
    for maps in zip(*robots, strict=True):
        for number, grid in enumerate(maps, start=1):
            merger.update(f"robot{number}", grid)
        published = merger.step()
        events += [(event.robot, event.change) for event in published.events]
    return published, events


def misplaced_cells(published):
    """Distance of robot2's map from where it belongs, cells of A."""
    return displacement_cells(B, map_frame_to_pixels(published.placements["robot2"], A, B), B_IN_A)


def test_growing_maps_become_one_once_two_answers_agree():
    merger = LiveMerger()
    parts = growing(A, (0.2, 0.55, 0.65, 0.75))
    published, events = play(merger, parts, growing(B))

    assert events == [("robot2", "joined")]
    assert misplaced_cells(published) < 0.5
    assert published.statuses["robot2"].level == "ok"
    assert np.count_nonzero(published.grid.free) > 1.1 * np.count_nonzero(parts[-1].free)
    assert published.grid.origin[2] == A.origin[2]  # the reference's frame


def test_before_anything_is_sure_the_map_is_that_of_the_reference_alone():
    merger = LiveMerger()
    published, events = play(merger, [A], [B])

    assert events == []
    assert published.grid is A
    assert published.placements == {}
    assert published.statuses["robot2"].verdict == "pending"
    assert "1 of 2 answers agree" in published.statuses["robot2"].message


def test_the_same_maps_again_are_no_second_answer():
    published, events = play(LiveMerger(), [A] * 4, [B] * 4)

    assert events == []
    assert published.grid is A


def test_one_answer_is_enough_where_that_is_asked_for():
    published, events = play(LiveMerger(params=LiveParams(accepts=1)), [A], [B])

    assert events == [("robot2", "joined")]
    assert misplaced_cells(published) < 0.5


def test_a_map_of_another_place_is_never_merged_and_its_reason_is_given():
    versions = growing(A)
    published, events = play(LiveMerger(), versions, growing(OTHER))

    assert events == []
    assert published.grid is versions[-1]
    assert published.statuses["robot2"].verdict == "left out"
    assert "robot1" in published.statuses["robot2"].message


def test_a_robot_that_begins_anew_is_taken_out_and_joins_again():
    merger = LiveMerger()
    play(merger, growing(A), growing(B))
    begun_anew, events = play(merger, [A], [known_part(B, SHARES[0])])

    assert events == [("robot2", "taken out")]
    assert begun_anew.grid is A
    assert play(merger, [A, A], growing(B)[2:])[1] == [("robot2", "joined")]


def test_a_reference_that_begins_anew_takes_all_others_out():
    merger = LiveMerger()
    play(merger, growing(A), growing(B))

    assert play(merger, [known_part(A, SHARES[0])], [B])[1] == [("robot2", "taken out")]


def test_a_map_that_becomes_another_is_taken_out_with_a_reason():
    merger = LiveMerger()
    play(merger, growing(A), growing(B))
    hall = OccupancyGrid(np.pad(np.full((90, 130), FREE, np.int8), 1, constant_values=OCCUPIED), 0.05)
    larger = OccupancyGrid(np.pad(np.full((100, 150), FREE, np.int8), 1, constant_values=OCCUPIED), 0.05)
    published, events = play(merger, [A, A], [hall, larger])

    assert events == [("robot2", "taken out")]
    assert published.grid is A


def test_a_message_that_is_no_map_leaves_the_last_map_and_is_told():
    merger = LiveMerger()
    play(merger, growing(A), growing(B))
    merger.update("robot2", MapFileError("the map of robot2: no cell is free"))
    merger.update("robot3", MapFileError("the map of robot3: all cells are unknown"))
    published = merger.step()

    assert "robot2" in published.placements
    assert published.statuses["robot2"].level == "error"
    assert "no cell is free; its last map is used" in published.statuses["robot2"].message
    assert published.statuses["robot3"].message == "the map of robot3: all cells are unknown"


def test_a_merger_that_is_started_again_needs_one_answer():
    merger = LiveMerger()
    play(merger, growing(A), growing(B))
    again = LiveMerger(memory=merger.memory)
    again.update("robot2", B)
    again.update("robot1", A)
    published = again.step()

    assert published.reference == "robot1"  # though robot2 came first
    assert [event.change for event in published.events] == ["joined"]


def test_a_merger_that_is_started_again_forgets_no_robot_that_has_not_come_back():
    known = {"robot2": Similarity(1.0, 0.1, 2.0, 3.0), "robot3": Similarity(1.0, 0.2, 1.0, 1.0)}
    merger = LiveMerger(memory=Memory("robot1", known))
    merger.update("robot1", A)
    published = merger.step()

    assert published.placements == {}
    assert merger.memory == Memory("robot1", known)


def test_a_reference_that_is_named_is_waited_for():
    merger = LiveMerger(reference="robot2")
    merger.update("robot1", A)
    published = merger.step()

    assert published.grid is None
    assert "waits for a map of robot2" in published.statuses["robot1"].message
    published, events = play(merger, growing(A), growing(B))
    assert events == [("robot1", "joined")]
    assert published.reference == "robot2"


def test_nothing_is_asked_and_nothing_composed_again_where_no_map_has_changed(monkeypatch):
    merger = LiveMerger()
    first, _ = play(merger, growing(A), growing(B))
    monkeypatch.setattr("rectmerge.live.merger.build_graph", lambda *args, **words: pytest.fail("asked again"))

    assert merger.step().grid is first.grid


def test_of_three_robots_each_order_of_arrival_gives_the_same_group():
    c = known_part(A, 0.8)
    for order in itertools.permutations(("robot1", "robot2", "robot3")):
        merger = LiveMerger(reference="robot1", params=LiveParams(accepts=1))
        for robot in order:
            merger.update(robot, {"robot1": A, "robot2": B, "robot3": c}[robot])
        assert sorted(merger.step().placements) == ["robot2", "robot3"]


def test_a_change_of_a_third_map_that_is_joined_is_another_question_about_each_robot():
    merger = LiveMerger(reference="robot1", params=LiveParams(accepts=1))
    numbers = []
    for c in growing(A, (0.5, 0.65, 0.8, 1.0)):
        play(merger, [A], [B], [c])
        numbers.append(merger._tracks["robot2"].questions)

    assert numbers == [1, 2, 3, 4]
