"""The node on a real ROS 2: its own process, robots in theirs, and a listener here."""

import math
import os
import signal
import subprocess
import sys
import time

import pytest

pytest.importorskip("rclpy", reason="there is no rclpy: pip install 'rectmerge[live]' on Linux with Python 3.11")

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import OccupancyGrid as GridMessage
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from rectmerge.analysis.displacement import displacement_cells
from rectmerge.grid import map_frame_to_pixels
from rectmerge.io.occupancy_message import grid_of_message
from rectmerge.live.node import LATCHED, MOST_ROBOTS
from rectmerge.similarity import Similarity
from tests.rectmerge.live.growing import B_IN_A, A, B

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning")]  # lark's
LONGEST_S = 120.0  # however busy the machine is
DOMAIN = 1 + os.getpid() % 100  # other tests and robots in the network do not meet these


class Listener:
    """What the node publishes, as a late subscriber hears it."""

    def __init__(self):
        self._context = Context()
        rclpy.init(context=self._context, domain_id=DOMAIN)
        self._node = Node("listener", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        many = QoSProfile(depth=MOST_ROBOTS, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.maps, self.transforms, self.statuses = [], {}, {}
        self._node.create_subscription(GridMessage, "/map", self._take_map, LATCHED)
        self._node.create_subscription(TransformStamped, "/rectmerge/transforms", self._take_transform, many)
        self._node.create_subscription(DiagnosticArray, "/diagnostics", self._take_diagnostics, 10)

    def _take_map(self, message):
        self.maps.append((message.header.frame_id, grid_of_message(message, "merged")))

    def _take_transform(self, message):
        move, turn = message.transform.translation, message.transform.rotation
        angle = 2 * math.atan2(turn.z, turn.w)
        self.transforms[message.child_frame_id] = message.header.frame_id, Similarity(1.0, angle, move.x, move.y)

    def _take_diagnostics(self, message):
        self.statuses |= {status.hardware_id: status for status in message.status}

    def wait_for(self, what):
        """Listen until something is so."""
        end = time.monotonic() + LONGEST_S
        while not what():
            assert time.monotonic() < end, f"not heard: {self.statuses}"
            self._executor.spin_once(timeout_sec=0.2)

    def close(self):
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


@pytest.fixture
def listener():
    heard = Listener()
    yield heard
    heard.close()


@pytest.fixture
def start(tmp_path):
    """Start processes of one ROS domain; they end with the test."""
    environment = os.environ | {
        "ROS_DOMAIN_ID": str(DOMAIN),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_HOME": str(tmp_path),
        "ROS_LOG_DIR": str(tmp_path / "log"),
    }
    processes = []

    def begin(*words):
        process = subprocess.Popen(
            [sys.executable, *words], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        processes.append(process)
        return process

    yield begin
    for process in processes:
        process.kill()
        process.communicate()


CODE = ("-c", "from rectmerge.cli.main import main; main()", "node", "--rate", "4")


def robot(start, name, which, *, frame="map", period_s=1.5, durability="latched"):
    return start("-m", "tests.rectmerge.live.robot_process", name, frame, which, str(period_s), durability)


def test_two_robots_become_one_map(start, listener):
    start(*CODE)
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
    listener.wait_for(lambda: listener.statuses["robot2"].level == DiagnosticStatus.OK)
    assert "lies on the map of robot1" in listener.statuses["robot2"].message


def test_a_node_that_was_killed_finds_its_merge_in_one_cycle_and_an_interrupt_ends_it(start, listener):
    node = start(*CODE)
    robot(start, "robot1", "A")
    robot(start, "robot2", "B")
    listener.wait_for(lambda: "robot2/map" in listener.transforms)
    node.kill()
    listener.transforms.clear()
    again = start(*CODE)  # the maps do not grow any more: a second answer cannot come
    listener.wait_for(lambda: "robot2/map" in listener.transforms)
    again.send_signal(signal.SIGINT)

    assert again.wait(timeout=LONGEST_S) in (0, 130)
    assert "Traceback" not in again.communicate()[1]


def test_frames_of_one_name_get_names_of_their_robots_and_a_warning(start, listener):
    start(*CODE)
    robot(start, "robot1", "A")
    listener.wait_for(lambda: "robot1/map" in listener.transforms)
    listener.wait_for(lambda: "robot1" in listener.statuses)

    assert listener.statuses["robot1"].level == DiagnosticStatus.WARN
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
    process = start(*CODE, "--", "--ros-args", *words)
    _, errors = process.communicate(timeout=LONGEST_S)

    assert process.returncode == 2
    assert fault in errors
    ours = [line for line in errors.splitlines() if "[rcl]" not in line]  # ROS adds its own word on its own arguments
    assert len(ours) == 1


def test_without_ros_the_command_says_what_to_install(start, tmp_path):
    (tmp_path / "rclpy.py").write_text("raise ImportError('hidden')")
    code = "import sys; sys.modules['rclpy'] = None; from rectmerge.cli.main import main; main()"
    process = start("-c", code, "node")
    _, errors = process.communicate(timeout=LONGEST_S)

    assert process.returncode == 2
    assert "pip install 'rectmerge[live]'" in errors
