"""The node on a real ROS 2: its own process, robots in theirs, and a listener here."""

import signal
import sys
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy", reason="there is no rclpy: pip install 'rectmerge[live]' on Linux with Python 3.11")

from rectmerge.analysis.displacement import displacement_cells
from rectmerge.grid import map_frame_to_pixels
from rectmerge.live.node import update_message_type
from rectmerge.similarity import Similarity
from tests.rectmerge.live.growing import B_IN_A, A, B
from tests.ros.domain import LONGEST_S

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning")]  # lark's
NODE = ("-c", "from rectmerge.cli.main import main; main()", "node", "--rate", "4")
AT_ONCE = (*NODE, "--accepts", "1")  # which versions of a growing map a node sees, is luck


def robot(start, name, which, *, frame="map", period_s=1.5, durability="latched"):
    return start("-m", "tests.ros.robot_process", name, frame, which, str(period_s), durability)


def test_two_robots_become_one_map(start, listener):
    start(*AT_ONCE)
    robot(start, "robot1", "A", frame="robot1/map")
    listener.wait_for(lambda: listener.maps)

    assert listener.maps[0][0] == "map"
    assert listener.maps[0][1].shape == A.shape  # nothing is sure yet: the reference alone
    robot(start, "robot2", "B", frame="robot2/map", durability="volatile")
    listener.wait_for(lambda: "robot2/map" in listener.transforms)
    parent, placement = listener.transforms["robot2/map"]

    assert parent == "map"
    assert displacement_cells(B, map_frame_to_pixels(placement, A, B), B_IN_A) < 1.0
    assert listener.transforms["robot1/map"] == ("map", Similarity())
    listener.wait_for(lambda: listener.is_ok("robot2"))
    assert "lies on the map of robot1" in listener.statuses["robot2"].message


def test_a_node_that_was_killed_finds_its_merge_in_one_cycle_and_an_interrupt_ends_it(start, listener):
    node = start(*AT_ONCE)
    robot(start, "robot1", "A")
    robot(start, "robot2", "B")
    listener.wait_for(lambda: "robot2/map" in listener.transforms)
    node.kill()
    listener.transforms.clear()
    again = start(*NODE)  # asks two answers of maps that do not grow any more: its memory is one
    listener.wait_for(lambda: "robot2/map" in listener.transforms)
    again.send_signal(signal.SIGINT)

    assert again.wait(timeout=LONGEST_S) in (0, 130, -signal.SIGINT)
    assert "Traceback" not in again.communicate()[1]


def test_frames_of_one_name_get_names_of_their_robots_and_a_warning(start, listener):
    start(*AT_ONCE)
    robot(start, "robot1", "A")
    listener.wait_for(lambda: "robot1/map" in listener.transforms)
    listener.wait_for(lambda: "robot1" in listener.statuses)

    assert not listener.is_ok("robot1")
    assert "its frame 'map' is that of the merged map: TF has robot1/map instead" in listener.statuses["robot1"].message


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (("-p", "rate:=0.0"), "rate"),
        (("-p", "rate:=fast"), "rate"),
        (("-p", "method:=nobody"), "nobody"),
        (("-p", "broken"), "broken"),
    ],
)
def test_a_bad_parameter_is_one_line_and_no_start(start, words, fault):
    process = start(*NODE, "--", "--ros-args", *words)
    _, errors = process.communicate(timeout=LONGEST_S)

    assert process.returncode == 2
    assert fault in errors
    ours = [line for line in errors.splitlines() if "[rcl]" not in line]  # ROS adds its own word on its own arguments
    assert len(ours) == 1


def test_updates_of_maps_are_heard_where_their_type_is_there(monkeypatch):
    stand_in = SimpleNamespace(OccupancyGridUpdate=object())
    monkeypatch.setitem(sys.modules, "map_msgs", SimpleNamespace(msg=stand_in))
    monkeypatch.setitem(sys.modules, "map_msgs.msg", stand_in)
    assert update_message_type() is stand_in.OccupancyGridUpdate
    monkeypatch.setitem(sys.modules, "map_msgs.msg", None)
    assert update_message_type() is None


def test_without_ros_the_command_says_what_to_install(start, tmp_path):
    (tmp_path / "rclpy.py").write_text("raise ImportError('hidden')")
    code = "import sys; sys.modules['rclpy'] = None; from rectmerge.cli.main import main; main()"
    process = start("-c", code, "node")
    _, errors = process.communicate(timeout=LONGEST_S)

    assert process.returncode == 2
    assert "pip install 'rectmerge[live]'" in errors
