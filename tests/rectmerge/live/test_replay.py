import json

import pytest

from rectmerge.cli import console
from rectmerge.cli.main import app
from rectmerge.errors import InputError
from rectmerge.io.map_file import read_map
from rectmerge.live.merger import LiveMerger
from rectmerge.live.replay import replay
from tests.rectmerge import bags
from tests.rectmerge.bags import GRID, KINDS, TEXT
from tests.rectmerge.live.growing import A, B, growing


def recorded(folder, kind="mcap", topics=("/robot1/map", "/robot2/map")):
    """A bag in which the maps of two robots grow, a message each second."""
    messages = []
    for number, maps in enumerate(zip(growing(A), growing(B), strict=True)):
        for topic, grid in zip(topics, maps, strict=True):
            x, y, yaw = grid.origin
            changes = {"cells": grid.occupancy, "resolution": 0.05, "at": (x, y, 0.0), "turn": bags.level(yaw)}
            messages.append((topic, GRID, changes))
        messages.append((f"/chat{number}", TEXT, {}))
    return bags.write(folder, kind, messages)


def run(*words):
    return console.run(app, "rectmerge", list(map(str, words)))


@pytest.mark.parametrize("kind", KINDS)
def test_a_recording_is_merged_on_its_own_clock(tmp_path, kind):
    steps = list(replay([recorded(tmp_path, kind)], LiveMerger(), period_s=3.0))
    events = [(step.time_s, event.change) for step in steps for event in step.published.events]

    assert [step.time_s for step in steps] == [3.0, 6.0, 9.0, 12.0]
    assert events == [(9.0, "joined")]


def test_recordings_of_two_robots_are_played_together(tmp_path):
    (tmp_path / "1").mkdir()
    (tmp_path / "2").mkdir()
    whole = recorded(tmp_path / "1")
    other = bags.write(tmp_path / "2", "bag", [("/robot9/map", GRID, {})])
    last = list(replay([whole, other], LiveMerger()))[-1].published

    assert sorted(last.statuses) == ["robot1", "robot2", "robot9"]
    assert sorted(last.placements) == ["robot2"]


def test_topics_of_another_pattern_are_named(tmp_path):
    bag = recorded(tmp_path, topics=("/map_1", "/map_2"))

    with pytest.raises(InputError, match=r"no topic is like /ROBOT/map: the maps are on /map_1, /map_2"):
        list(replay([bag], LiveMerger()))
    assert list(replay([bag], LiveMerger(), pattern="/map_ROBOT"))[-1].published.placements.keys() == {"2"}


def test_follow_writes_the_merged_map_and_every_event(tmp_path, capsys):
    status = run("follow", recorded(tmp_path), "-o", tmp_path / "out")
    shown = capsys.readouterr().out
    record = json.loads((tmp_path / "out" / "follow.json").read_text())

    assert status == console.YES
    assert "robot2 joined" in shown
    assert "2 of 2 robots" in shown
    assert record["reference"] == "robot1"
    assert [event["event"] for event in record["events"]] == ["joined"]
    assert [entry["robot"] for entry in record["transforms"]] == ["robot2"]
    assert read_map(tmp_path / "out" / "merged.yaml").shape == A.shape


def test_follow_says_no_where_a_robot_is_left_out(tmp_path, capsys):
    bag = bags.write(tmp_path, "mcap", [("/robot1/map", GRID, {}), ("/robot2/map", GRID, {})])

    assert run("follow", bag, "-o", tmp_path / "out", "--json") == console.NO
    assert json.loads(capsys.readouterr().out)["transforms"] == []


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (("missing.mcap",), "missing.mcap"),
        (("BAG", "--topics", "/map"), "ROBOT"),
        (("BAG", "--topics", "/ROBOT/costmap"), "no topic is like"),
        (("BAG", "--method", "nobody"), "nobody"),
    ],
)
def test_follow_refuses_in_one_line_and_writes_nothing(tmp_path, capsys, words, fault):
    bag = bags.write(tmp_path, "mcap")
    given = [bag if word == "BAG" else word for word in words]

    assert run("follow", *given, "-o", tmp_path / "out") == console.BAD_INPUT
    shown = capsys.readouterr().err
    assert fault in shown
    assert len(shown.splitlines()) == 1
    assert not (tmp_path / "out").exists()
