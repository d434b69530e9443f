"""A pair's mission as a ROS bag, of ROS 2 or ROS 1: both robots' growing maps, odometry, scans and transforms."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, NamedTuple

import numpy as np

from rectmerge.grid import OccupancyGrid
from scenarios.dataset.recording import Recording, record
from scenarios.pairs.pair import MapPair, PairInputs
from sim.slam.poses import relative_poses

ROBOTS = ("robot1", "robot2")  # of the maps A and B
MAP, ODOMETRY, SCAN = "nav_msgs/msg/OccupancyGrid", "nav_msgs/msg/Odometry", "sensor_msgs/msg/LaserScan"
TF = "tf2_msgs/msg/TFMessage"
LATCHED = (MAP, "/tf_static")  # types and topics whose last message a late subscriber gets
BagForm = Literal["mcap", "rosbag1"]
FIRST_TIME = 1  # nanoseconds: ROS 1 takes no message at time 0
VERSION: Literal[8] = 8  # of rosbag2's metadata: the newest that all distributions from Humble on read


class _Sent(NamedTuple):
    """A message: time, in nanoseconds; rank among those of one time; and topic."""

    time: int
    order: int
    topic: str
    type: str
    message: Any


def encode_bag(pair: MapPair, made: PairInputs, name: str, *, form: BagForm = "mcap") -> dict[str, bytes]:
    """Write a pair's mission as a bag; the same pair gives the same bytes.

    Parameters
    ----------
    pair
        A pair made from a mission. The last message on ``/robot1/map`` is map A, on ``/robot2/map`` map B.
    made
        What it was made from.
    name
        Of the bag's folder, or of the file of ROS 1 without its suffix.
    form
        "mcap": a rosbag2 folder for ROS 2; "rosbag1": a ``.bag`` for ROS 1.

    Returns
    -------
    dict
        The files by name: the MCAP file, its chunks compressed with zstd, and metadata.yaml; or the ``.bag``, its
        chunks compressed with bz2.

    Notes
    -----
    Topics of each robot: ``map`` every five seconds, transient local; at every scan ``scan``, ``odom`` and, on ``/tf``,
    the transforms from ``map`` to ``odom`` to ``base``. By ``/tf_static`` the scanner stands above ``base``. A reading
    is inf where nothing was in reach and nan where it was lost (REP 117).
    """
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    is_first = form == "rosbag1"
    store = get_typestore(Stores.ROS1_NOETIC if is_first else Stores.ROS2_HUMBLE)
    if TF not in store.types:  # ROS 1 has it in a package that rosbags leaves out
        store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TF))
    recordings = dict(zip(ROBOTS, record(pair, made), strict=True))
    make = _Maker(store.types, has_sequence_numbers=is_first)
    streams = [stream for robot, recording in recordings.items() for stream in make.streams(robot, recording)]
    messages = heapq.merge(make.still(recordings), *streams, key=lambda sent: sent[:3])
    with TemporaryDirectory() as folder:
        (_write_first if is_first else _write_second)(Path(folder) / name, store, messages)
        return {file.name: file.read_bytes() for file in sorted(Path(folder).rglob("*")) if file.is_file()}


def _write_first(path: Path, store: Any, messages: Iterable[_Sent]) -> None:
    """Write a bag of ROS 1."""
    from rosbags.rosbag1 import Writer

    writer = Writer(path.with_suffix(".bag"))
    writer.set_compression(Writer.CompressionFormat.BZ2)  # the lz4 of ROS 1 does not read that of rosbags
    topics: dict[str, Any] = {}
    with writer:
        for sent in messages:
            if sent.topic not in topics:
                topics[sent.topic] = writer.add_connection(
                    sent.topic, sent.type, typestore=store, latching=int(_is_latched(sent))
                )
            time = max(sent.time, FIRST_TIME)
            writer.write(topics[sent.topic], time, store.serialize_ros1(sent.message, sent.type))


def _write_second(path: Path, store: Any, messages: Iterable[_Sent]) -> None:
    """Write a bag of ROS 2, a folder."""
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

    writer = Writer(path, version=VERSION, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    topics: dict[str, Any] = {}
    with writer:
        for sent in messages:
            if sent.topic not in topics:
                qos = [_quality(is_latched=_is_latched(sent))]
                topics[sent.topic] = writer.add_connection(
                    sent.topic, sent.type, typestore=store, offered_qos_profiles=qos
                )
            writer.write(topics[sent.topic], sent.time, store.serialize_cdr(sent.message, sent.type))


def _is_latched(sent: _Sent) -> bool:
    return sent.topic in LATCHED or sent.type in LATCHED


class _Maker:
    """Makes messages of a store of types."""

    def __init__(self, types: Any, *, has_sequence_numbers: bool) -> None:
        self._types = types
        self._sequence = (0,) if has_sequence_numbers else ()  # of a header: ROS 1 has one, which publishers fill in

    def streams(self, robot: str, recording: Recording) -> list[Iterator[_Sent]]:
        """Return a robot's messages, in streams that each are in order of time."""
        return [
            self._transforms(robot, recording),
            self._odometry(robot, recording),
            self._scans(robot, recording),
            self._maps(robot, recording),
        ]

    def still(self, recordings: dict[str, Recording]) -> Iterator[_Sent]:
        """Yield the static transforms of the scanners, once, before anything moves."""
        start = min(_nanoseconds(recording.times[0]) for recording in recordings.values())
        links = [
            self._link(start, f"{robot}/base", f"{robot}/scan", np.zeros(3), height_m=recording.lidar.height_m)
            for robot, recording in recordings.items()
        ]
        yield _Sent(start, 0, "/tf_static", TF, self._types[TF](transforms=links))

    def _transforms(self, robot: str, recording: Recording) -> Iterator[_Sent]:
        for time, drift, wheels in zip(
            map(_nanoseconds, recording.times), recording.drift, recording.wheels, strict=True
        ):
            links = [
                self._link(time, f"{robot}/map", f"{robot}/odom", drift),
                self._link(time, f"{robot}/odom", f"{robot}/base", wheels),
            ]
            yield _Sent(time, 1, "/tf", TF, self._types[TF](transforms=links))

    def _odometry(self, robot: str, recording: Recording) -> Iterator[_Sent]:
        steps = (
            relative_poses(recording.wheels[:-1], recording.wheels[1:]) / np.diff(recording.times)[:, None]
        )  # (S-1, 3), per second
        speeds = np.concatenate([np.zeros((1, 3)), steps])
        covariance = np.zeros(36)
        for time, wheels, (along, across, turn) in zip(
            map(_nanoseconds, recording.times), recording.wheels, speeds, strict=True
        ):
            vectors = [self._made("geometry_msgs/msg/Vector3", *v) for v in ((along, across, 0.0), (0.0, 0.0, turn))]
            twist = self._made("geometry_msgs/msg/Twist", *vectors)
            message = self._types[ODOMETRY](
                header=self._header(time, f"{robot}/odom"),
                child_frame_id=f"{robot}/base",
                pose=self._made("geometry_msgs/msg/PoseWithCovariance", self._pose(wheels), covariance),
                twist=self._made("geometry_msgs/msg/TwistWithCovariance", twist, covariance),
            )
            yield _Sent(time, 2, f"/{robot}/odom", ODOMETRY, message)

    def _scans(self, robot: str, recording: Recording) -> Iterator[_Sent]:
        lidar, angles = recording.lidar, recording.lidar.angles
        apart = float(np.median(np.diff(recording.times))) if len(recording.times) > 1 else 0.0
        for time, ranges in zip(map(_nanoseconds, recording.times), recording.ranges.astype(np.float32), strict=True):
            message = self._types[SCAN](
                header=self._header(time, f"{robot}/scan"),
                angle_min=float(angles[0]),
                angle_max=float(angles[-1]),
                angle_increment=math.radians(lidar.fov_deg) / lidar.beams,
                time_increment=0.0,  # the simulation reads all beams at once
                scan_time=apart,
                range_min=lidar.min_range_m,
                range_max=lidar.max_range_m,
                ranges=ranges,
                intensities=np.zeros(0, np.float32),
            )
            yield _Sent(time, 3, f"/{robot}/scan", SCAN, message)

    def _maps(self, robot: str, recording: Recording) -> Iterator[_Sent]:
        for scan, grid in recording.maps():
            time = _nanoseconds(recording.times[scan])
            yield _Sent(time, 4, f"/{robot}/map", MAP, self._map(time, f"{robot}/map", grid))

    def _map(self, time: int, frame: str, grid: OccupancyGrid) -> Any:
        info = self._types["nav_msgs/msg/MapMetaData"](
            map_load_time=self._time(time),
            resolution=grid.cell_size,
            width=grid.shape[1],
            height=grid.shape[0],
            origin=self._pose(grid.origin),
        )
        return self._types[MAP](header=self._header(time, frame), info=info, data=grid.occupancy[::-1].ravel())

    def _link(self, time: int, parent: str, child: str, pose: Any, *, height_m: float = 0.0) -> Any:
        x, y, yaw = map(float, pose)
        place = self._made("geometry_msgs/msg/Vector3", x, y, height_m)
        transform = self._made("geometry_msgs/msg/Transform", place, self._turn(yaw))
        return self._made("geometry_msgs/msg/TransformStamped", self._header(time, parent), child, transform)

    def _pose(self, pose: Any) -> Any:
        x, y, yaw = map(float, pose)
        return self._made("geometry_msgs/msg/Pose", self._made("geometry_msgs/msg/Point", x, y, 0.0), self._turn(yaw))

    def _turn(self, yaw: float) -> Any:
        return self._made("geometry_msgs/msg/Quaternion", 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))

    def _header(self, time: int, frame: str) -> Any:
        return self._made("std_msgs/msg/Header", *self._sequence, self._time(time), frame)

    def _time(self, time: int) -> Any:
        return self._made("builtin_interfaces/msg/Time", *divmod(time, 10**9))

    def _made(self, name: str, *fields: Any) -> Any:
        return self._types[name](*fields)


def _nanoseconds(seconds: float) -> int:
    return round(float(seconds) * 1e9)


def _quality(*, is_latched: bool) -> Any:
    """Return the quality of service that a topic is played with."""
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    never = QosTime(0, 0)  # no deadline
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1 if is_latched else 10,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if is_latched else QosDurability.VOLATILE,
        deadline=never,
        lifespan=never,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=never,
        avoid_ros_namespace_conventions=False,
    )
