"""Simulated robots on real topics of ROS 2, merged by the node beside them."""

import pytest

pytest.importorskip("rclpy", reason="there is no rclpy: pip install 'rectmerge[live]' on Linux with Python 3.11")

from tests.ros.domain import LONGEST_S

pytestmark = [
    pytest.mark.slow,
    pytest.mark.sim,
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # lark's
]


def command(program, *words):
    return ("-c", f"from {program}.cli.main import main; main()", *words)


def test_simulated_robots_are_merged_while_they_explore(start, listener):
    start(*command("rectmerge", "node", "--rate", "4", "--accepts", "1"))
    start(*command("scenarios", "mission", "smoke", "--speed", "10"))
    listener.wait_for(lambda: "robot2/map" in listener.transforms)

    assert listener.transforms["robot2/map"][0] == "map"
    listener.wait_for(lambda: listener.is_ok("robot2"))


def test_a_suite_without_robots_is_refused_in_one_line(start, tmp_path):
    (tmp_path / "maps.toml").write_text("title = 'broken'")
    process = start(*command("scenarios", "mission", str(tmp_path / "maps.toml"), "--quiet"))
    _, errors = process.communicate(timeout=LONGEST_S)

    assert process.returncode == 2
    assert len(errors.splitlines()) == 1
