"""Bags read back by the libraries `mcap` and `mcap-ros2-support`, which share nothing with the one that wrote them."""

import json
import math
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

import rectmerge as rm
from rectmerge.grid import OccupancyGrid
from scenarios.dataset.recording import record
from scenarios.dataset.rosbag import encode_bag
from scenarios.pairs.map_view import MapSpec
from tests.scenarios.dataset.walked_pairs import SPECS, made
from tests.sim.small_worlds import walked_log


def write(folder: Path, files: dict[str, bytes]) -> Path:
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    return folder


def played(bag: Path) -> dict[str, list]:
    """What a bag holds, as (seconds, schema, message), by topic."""
    topics: dict[str, list] = {}
    (file,) = bag.glob("*.mcap")
    with file.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        for schema, channel, message, content in reader.iter_decoded_messages():
            topics.setdefault(channel.topic, []).append((message.log_time / 1e9, schema.name, content))
    return topics


def grid_of(message) -> OccupancyGrid:
    info, cells = message.info, np.array(message.data, np.int8)
    at, turn = info.origin.position, info.origin.orientation
    origin = (at.x, at.y, 2 * math.atan2(turn.z, turn.w))
    return OccupancyGrid(cells.reshape(info.height, info.width)[::-1], info.resolution, origin)


@pytest.fixture(scope="module")
def pair_and_bag(tmp_path_factory):
    pair, source = made(noise=1)
    return pair, write(tmp_path_factory.mktemp("bag") / "000003", encode_bag(pair, source, "000003"))


@pytest.fixture(scope="module")
def topics(pair_and_bag):
    return played(pair_and_bag[1])


def test_a_bag_holds_what_both_robots_sent(topics):
    kinds = {topic: {kind for _, kind, _ in sent} for topic, sent in topics.items()}
    counts = {topic: len(sent) for topic, sent in topics.items()}

    assert kinds == {
        "/robot1/map": {"nav_msgs/msg/OccupancyGrid"},
        "/robot2/map": {"nav_msgs/msg/OccupancyGrid"},
        "/robot1/odom": {"nav_msgs/msg/Odometry"},
        "/robot2/odom": {"nav_msgs/msg/Odometry"},
        "/robot1/scan": {"sensor_msgs/msg/LaserScan"},
        "/robot2/scan": {"sensor_msgs/msg/LaserScan"},
        "/tf": {"tf2_msgs/msg/TFMessage"},
        "/tf_static": {"tf2_msgs/msg/TFMessage"},
    }
    a, b = (len(robot.times) for robot in (made()[1].log.a, made()[1].log.b))
    assert (counts["/robot1/scan"], counts["/robot2/odom"], counts["/tf"]) == (a, b, a + b)
    assert (counts["/robot1/map"], counts["/robot2/map"]) == (6, 5)


@pytest.mark.parametrize(("topic", "name"), [("/robot1/map", "a"), ("/robot2/map", "b")])
def test_the_last_maps_are_those_of_the_pair_with_their_resolution(pair_and_bag, topics, topic, name):
    pair, bag = pair_and_bag
    wanted, (time, _, message) = getattr(pair, name), topics[topic][-1]
    read = rm.read_map(f"{bag}:{topic}")

    assert time == topics[topic.replace("map", "scan")][-1][0]
    assert message.header.frame_id == topic.strip("/")
    for grid in (grid_of(message), read):
        assert (grid.occupancy == wanted.occupancy).all()
        assert grid.resolution == pytest.approx(pair.info[f"resolution_{name}"], rel=1e-7)
        assert grid.origin == pytest.approx(wanted.origin, abs=1e-9)
    assert (pair.a.resolution, pair.b.resolution, read.resolution) == (0.05, None, (0.05, 0.06)["ab".index(name)])


@pytest.mark.parametrize("robot", ["robot1", "robot2"])
def test_maps_grow_every_five_seconds_in_one_frame(topics, robot):
    sent = topics[f"/{robot}/map"]
    grids = [grid_of(message) for _, _, message in sent]
    known = [int((~grid.unknown).sum()) for grid in grids]
    last = grids[-1]

    assert np.diff([time for time, _, _ in sent[:-1]]) == pytest.approx(5.0)
    assert known[:-1] == sorted(known[:-1])  # corruptions, which come last, remove cells
    assert known[0] < 0.8 * known[-1]
    for grid in grids[:-1]:
        free = grid.pixel_to_map(np.argwhere(grid.free)[:, ::-1])
        col, row = np.rint(last.map_to_pixel(free)).astype(int).T
        assert last.free[row, col].mean() > 0.95


@pytest.mark.parametrize("robot", ["robot1", "robot2"])
def test_scans_placed_by_the_transforms_hit_the_walls_of_the_map(topics, robot):
    grid = grid_of(topics[f"/{robot}/map"][-1][2])
    walls = np.pad(grid.occupied, 1)
    near = np.logical_or.reduce([np.roll(walls, (i, j), (0, 1)) for i in (-1, 0, 1) for j in (-1, 0, 1)])[1:-1, 1:-1]
    links = {
        (time, link.header.frame_id, link.child_frame_id): link.transform
        for time, _, message in topics["/tf"]
        for link in message.transforms
    }
    shares = []
    for time, _, scan in topics[f"/{robot}/scan"][::7]:
        ranges = np.array(scan.ranges)
        heading = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
        hit = np.isfinite(ranges)
        points = (ranges[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=-1))[hit]
        for parent, child in ((f"{robot}/odom", f"{robot}/base"), (f"{robot}/map", f"{robot}/odom")):
            points = moved(points, links[time, parent, child])
        col, row = np.rint(grid.map_to_pixel(points)).astype(int).T
        inside = (row >= 0) & (col >= 0) & (row < grid.shape[0]) & (col < grid.shape[1])
        shares.append((near[row[inside], col[inside]].sum()) / hit.sum())

    assert min(shares) > 0.85
    assert scan.angle_max == pytest.approx(heading[-1], abs=1e-4)


def moved(points, transform):
    turn = 2 * math.atan2(transform.rotation.z, transform.rotation.w)
    cos, sin = math.cos(turn), math.sin(turn)
    place = transform.translation
    return points @ np.array([[cos, sin], [-sin, cos]]) + (place.x, place.y)


def test_odometry_begins_at_its_origin_and_tells_the_speed(topics):
    sent = [message for _, _, message in topics["/robot1/odom"]]
    speeds = [message.twist.twist.linear.x for message in sent]
    first, frames = sent[0].pose.pose, {(message.header.frame_id, message.child_frame_id) for message in sent}

    assert (first.position.x, first.position.y, first.orientation.w) == (0.0, 0.0, 1.0)
    assert frames == {("robot1/odom", "robot1/base")}
    assert 0.2 < max(speeds) < 1.0


def test_scanners_stand_above_the_bases_and_late_subscribers_get_maps(pair_and_bag, topics):
    ((time, _, message),) = topics["/tf_static"]
    bag = yaml.safe_load((pair_and_bag[1] / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    latched = {
        topic["topic_metadata"]["name"]
        for topic in bag["topics_with_message_count"]
        if yaml.safe_load(topic["topic_metadata"]["offered_qos_profiles"])[0]["durability"] == 1
    }

    assert time == min(sent[0][0] for sent in topics.values())
    assert [link.child_frame_id for link in message.transforms] == ["robot1/scan", "robot2/scan"]
    assert {link.transform.translation.z for link in message.transforms} == {walked_log().spec.a.lidar.height_m}
    assert latched == {"/robot1/map", "/robot2/map", "/tf_static"}
    assert (bag["storage_identifier"], bag["relative_file_paths"]) == ("mcap", ["000003.mcap"])


@pytest.fixture(scope="module")
def first_bag(tmp_path_factory):
    """A pair, and its bag of ROS 1."""
    pair, source = made(noise=1)
    files = encode_bag(pair, source, "000003", form="rosbag1")
    assert list(files) == ["000003.bag"]
    assert files == encode_bag(pair, made(noise=1)[1], "000003", form="rosbag1")  # the same bytes
    return pair, write(tmp_path_factory.mktemp("first"), files) / "000003.bag"


@pytest.mark.parametrize(("topic", "name"), [("/robot1/map", "a"), ("/robot2/map", "b")])
def test_a_bag_of_ros_1_ends_with_the_maps_of_the_pair(first_bag, topic, name):
    pair, bag = first_bag
    wanted, read = getattr(pair, name), rm.read_map(f"{bag}:{topic}")

    assert (read.occupancy == wanted.occupancy).all()
    assert read.origin == pytest.approx(wanted.origin, abs=1e-9)
    assert read.frame == topic.strip("/")


READ_BY_ROS = """
import collections, json, sys, rosbag
counts, last = collections.Counter(), {}
with rosbag.Bag(sys.argv[1]) as bag:
    for topic, message, time in bag.read_messages():
        counts[topic] += 1
        if topic.endswith("/map"):
            last[topic] = [message.info.width, message.info.height, sum(message.data), message.header.frame_id]
    types = {topic: info.msg_type for topic, info in bag.get_type_and_topic_info().topics.items()}
print(json.dumps([counts, last, types]))
"""


def test_the_rosbag_of_ros_reads_the_same(first_bag, topics):
    python = "/usr/bin/python3"
    if not Path(python).exists() or subprocess.run([python, "-c", "import rosbag"], capture_output=True).returncode:
        pytest.skip("Debian's python3-rosbag is not installed")
    pair, bag = first_bag

    done = subprocess.run([python, "-c", READ_BY_ROS, bag], capture_output=True, text=True, check=True)

    counts, last, types = json.loads(done.stdout)
    assert counts == {topic: len(sent) for topic, sent in topics.items()}
    assert types["/robot1/scan"] == "sensor_msgs/LaserScan"
    for topic, grid in (("/robot1/map", pair.a), ("/robot2/map", pair.b)):
        assert last[topic] == [*grid.shape[::-1], int(grid.occupancy.astype(int).sum()), topic.strip("/")]


def test_the_same_pair_gives_the_same_bytes(pair_and_bag):
    pair, bag = pair_and_bag
    again = encode_bag(pair, made()[1], "000003")

    assert again == {file.name: file.read_bytes() for file in bag.iterdir()}


def test_a_map_by_odometry_does_not_drift_in_its_own_bag():
    blind = MapSpec(poses="odometry", turn_deg=25.0)
    recording, other = record(*made(blind, SPECS[1]))

    assert np.ptp(recording.drift, axis=0) == pytest.approx(0.0, abs=1e-9)
    assert len(recording.drift) == len(recording.times)
    assert other.grid.resolution == 0.06
