"""Small bags of every kind, written with rosbags, for tests that read them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore

GRID, TEXT = "nav_msgs/msg/OccupancyGrid", "std_msgs/msg/String"
KINDS = ("bag", "db3", "mcap")
LAID = ((0, 0, 100, 100), (0, -1, 0, 100), (0, 0, 0, 50))  # as a picture: the top row first
STORES = {1: get_typestore(Stores.ROS1_NOETIC), 2: get_typestore(Stores.ROS2_HUMBLE)}
PLUGINS = {"db3": rosbag2.StoragePlugin.SQLITE3, "mcap": rosbag2.StoragePlugin.MCAP}
MAP = ("/map", GRID, {})
ZSTD, MODE = rosbag2.CompressionFormat.ZSTD, rosbag2.CompressionMode
COMPRESSED = {
    "bag by bz2": ("bag", [rosbag1.Writer.CompressionFormat.BZ2]),
    "bag by lz4": ("bag", [rosbag1.Writer.CompressionFormat.LZ4]),
    "db3 as a file": ("db3", [MODE.FILE, ZSTD]),
    "db3 by message": ("db3", [MODE.MESSAGE, ZSTD]),
    "mcap by chunk": ("mcap", [MODE.STORAGE, ZSTD]),
}
Messages = Sequence[tuple[str, str, dict[str, Any]]]  # topic, type, and what differs from the usual


def level(yaw: float) -> tuple[float, float, float, float]:
    """The quaternion (x, y, z, w) of a yaw."""
    return 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)


def map_message(ros: int = 2, **changes: Any) -> Any:
    """An OccupancyGrid that shows `LAID`; changes are `cells`, `size`, `resolution`, `at`, `turn` and `frame`."""
    types = STORES[ros].types
    cells = np.array(changes.get("cells", LAID), np.int8)
    width, height = changes.get("size", cells.shape[::-1])
    time = types["builtin_interfaces/msg/Time"](sec=0, nanosec=0)
    first = {"seq": 0} if ros == 1 else {}
    point, turn = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/Quaternion"]
    pose = types["geometry_msgs/msg/Pose"](
        position=point(*changes.get("at", (1.0, -2.0, 0.0))),
        orientation=turn(*changes.get("turn", level(0.5))),
    )
    info = types["nav_msgs/msg/MapMetaData"](
        map_load_time=time,
        resolution=changes.get("resolution", 0.05),
        width=width,
        height=height,
        origin=pose,
    )
    header = types["std_msgs/msg/Header"](**first, stamp=time, frame_id=changes.get("frame", "map"))
    return types[GRID](header=header, info=info, data=cells[::-1].ravel())


def write(
    folder: Path,
    kind: str,
    messages: Messages = (("/map", GRID, {}),),
    *,
    silent: Sequence[str] = (),
    compression: Sequence[Any] = (),
) -> Path:
    """Write a bag of a kind, a message each second; of rosbag2 a folder. Topics of maps in `silent` get none."""
    ros = 1 if kind == "bag" else 2
    if ros == 1:
        path, writer = folder / "made.bag", rosbag1.Writer(folder / "made.bag")
    else:
        path = folder / f"made_{kind}"
        writer = rosbag2.Writer(path, version=9, storage_plugin=PLUGINS[kind])
    if compression:
        writer.set_compression(*compression)
    with writer:
        open_topics = {}
        for topic, name in [*((topic, GRID) for topic in silent), *((topic, name) for topic, name, _ in messages)]:
            if topic not in open_topics:
                open_topics[topic] = writer.add_connection(topic, name, typestore=STORES[ros])
        encode = STORES[ros].serialize_ros1 if ros == 1 else STORES[ros].serialize_cdr
        for second, (topic, name, changes) in enumerate(messages):
            message = map_message(ros, **changes) if name == GRID else STORES[ros].types[TEXT](data="hello")
            writer.write(open_topics[topic], second * 10**9, encode(message, name))
    return path


def storage(bag: Path) -> Path:
    """The file that holds a bag's messages."""
    return bag if bag.is_file() else next(path for path in bag.iterdir() if path.suffix != ".yaml")
