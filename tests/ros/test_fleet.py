"""Robots that explore one office, on a real ROS 2: the node merges their maps while these grow."""

import pytest

pytest.importorskip("rclpy", reason="there is no rclpy: pip install 'rectmerge[live]' on Linux with Python 3.11")

from rectmerge.analysis.displacement import displacement_cells
from rectmerge.analysis.overlap import measure_agreement
from rectmerge.grid import map_frame_to_pixels
from tests.ros.fleet import VERSIONS, explore

pytestmark = [
    pytest.mark.slow,
    pytest.mark.sim,
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # lark's
]
NODE = ("-c", "from rectmerge.cli.main import main; main()", "node", "--rate", "4", "--reference", "robot1")
MAP_EVERY_S = 1.0


@pytest.fixture(scope="module")
def explorers():
    return explore(5)


def is_in(merged, explorer, reference):
    """Whether the free space of a robot's last map is on the merged map, where it belongs."""
    truth, grid = reference.in_world.inverse() @ explorer.in_world, explorer.maps[-1]
    shared = measure_agreement(grid, merged, map_frame_to_pixels(truth.inverse(), grid, merged))
    return shared.overlap > 0.9


@pytest.mark.parametrize("robots", [3, 5])
def test_robots_become_one_map_and_none_is_ever_misplaced(start, listener, explorers, robots):
    fleet = explorers[:robots]
    start(*NODE, "--accepts", "1")  # which versions of a growing map the node sees, is luck
    for version in range(VERSIONS):
        for explorer in fleet:
            listener.send(explorer.name, explorer.maps[version])
        listener.listen(MAP_EVERY_S)
    listener.wait_for(lambda: all(f"{each.name}/map" in listener.transforms for each in fleet))
    listener.wait_for(lambda: all(listener.is_ok(each.name) for each in fleet))
    reference = fleet[0]
    for explorer in fleet[1:]:
        truth, maps = reference.in_world.inverse() @ explorer.in_world, (reference.maps[-1], explorer.maps[-1])
        placements = [placement for child, placement in listener.placements if child == f"{explorer.name}/map"]
        for placement in placements:  # every one that was ever published
            found, right = (map_frame_to_pixels(each, *maps) for each in (placement, truth))
            assert displacement_cells(maps[1], found, right) < 2.0
    listener.wait_for(lambda: all(is_in(listener.maps[-1][1], each, reference) for each in fleet))


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
