import pytest

from rectmerge.errors import InputError
from rectmerge.live.robot_names import robot_of
from rectmerge.live.settings import Settings


@pytest.mark.parametrize(
    ("values", "fault"),
    [
        ({"topics": "/map"}, "ROBOT"),
        ({"topics": "ROBOT/map"}, "ROBOT"),
        ({"rate": 0.0}, "rate must be 0.01 to 100"),
        ({"accepts": 0}, "accepts must be 1 to 10"),
        ({"frame": ""}, "frame must name a frame"),
        ({"frame": "/map"}, "frame must name a frame"),
        ({"merged_topic": "/all/map"}, "merged_topic /all/map is one of the robots' topics"),
    ],
)
def test_a_setting_that_cannot_be_used_is_named(values, fault):
    with pytest.raises(InputError, match=fault):
        Settings(**values)


@pytest.mark.parametrize(
    ("topic", "pattern", "robot"),
    [
        ("/robot1/map", "/ROBOT/map", "robot1"),
        ("/site/robot1/map", "/ROBOT/map", "site/robot1"),
        ("/map", "/ROBOT/map", None),
        ("/map_7", "/map_ROBOT", "7"),
        ("/robot1/map_updates", "/ROBOT/map", None),
    ],
)
def test_a_robot_is_named_by_its_topic(topic, pattern, robot):
    assert robot_of(topic, pattern) == robot
    if robot is not None:
        assert Settings(topics=pattern, merged_topic="/merged").topic_of(robot) == topic
