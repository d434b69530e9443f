"""Robots that explore one office, on a real ROS 2: the node merges their maps, whichever versions of these it sees."""

import pytest

pytest.importorskip("rclpy", reason="there is no rclpy: pip install 'rectmerge[live]' on Linux with Python 3.11")

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.grid import map_frame_to_pixels
from tests.ros.fleet import VERSIONS, explore, misplaced_cells

pytestmark = [
    pytest.mark.slow,
    pytest.mark.sim,
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # lark's
]
NODE = ("-c", "from rectmerge.cli.main import main; main()", "node", "--rate", "4", "--reference", "robot1")


@pytest.fixture(scope="module")
def explorers():
    return explore(5)


def is_in(merged, explorer, reference):
    """Whether the free space of a robot's last map is on the merged map, where it belongs."""
    truth, grid = reference.in_world.inverse() @ explorer.in_world, explorer.maps[-1]
    shared = measure_agreement(grid, merged, map_frame_to_pixels(truth.inverse(), grid, merged))
    return shared.overlap > 0.9


@pytest.mark.parametrize("robots", [3, 5])
def test_robots_become_one_map(start, listener, explorers, robots):
    fleet = explorers[:robots]
    start(*NODE, "--accepts", "1")
    for explorer in fleet:
        listener.send(explorer.name, explorer.maps[0])
    listener.wait_for(lambda: all(listener.is_compared(each.name) for each in fleet))
    for explorer in fleet:
        listener.send(explorer.name, explorer.maps[-1])
    listener.wait_for(lambda: all(f"{each.name}/map" in listener.transforms for each in fleet))
    listener.wait_for(lambda: all(listener.is_ok(each.name) for each in fleet))
    for explorer in fleet[1:]:
        _, placement = listener.transforms[f"{explorer.name}/map"]
        assert misplaced_cells(placement, fleet[0], explorer, explorer.maps[-1]) < 2.0
    listener.wait_for(lambda: all(is_in(listener.maps[-1][1], each, fleet[0]) for each in fleet))


def test_maps_that_come_faster_than_the_rate_while_the_clock_jumps_are_dropped_and_merged(start, listener, explorers):
    fleet = explorers[:2]
    start(*NODE, "--accepts", "1", "--", "--ros-args", "-p", "use_sim_time:=true")
    for turn in range(5 * VERSIONS):
        for explorer in fleet:
            listener.send(explorer.name, explorer.maps[turn // 5])
        listener.set_clock((1000, 0, 10**6)[turn % 3])
        listener.listen(0.1)
    listener.wait_for(lambda: listener.is_ok("robot2"))


def test_two_publishers_under_one_name_are_told(start, listener, explorers):
    start(*NODE)
    listener.send("robot1", explorers[0].maps[-1])
    listener.send("robot1", explorers[1].maps[-1], number=2)
    listener.wait_for(lambda: "robot1" in listener.statuses and not listener.is_ok("robot1"))

    assert "2 publishers send on /robot1/map: maps of two robots would mix" in listener.statuses["robot1"].message
