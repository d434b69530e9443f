"""Maps in ROS bags: the newest nav_msgs/OccupancyGrid of a topic, from a ROS 1 bag, sqlite3 or MCAP."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from rectmerge.errors import MapFileError
from rectmerge.extras import missing
from rectmerge.grid import OccupancyGrid
from rectmerge.io.bag_sizes import bounded_sizes
from rectmerge.io.image_file import BROKEN, require_file
from rectmerge.io.occupancy_message import grid_of_message

MAP_TYPE = "nav_msgs/msg/OccupancyGrid"
SUFFIXES = (".bag", ".mcap", ".db3")
METADATA = "metadata.yaml"  # a folder with this file is a rosbag2
LONGEST_REASON = 160  # characters


class BagName(NamedTuple):
    """Parts of a name like ``run.mcap:/robot1/map``: the file or folder, and the topic, None if not given."""

    file: Path
    topic: str | None


class BagMessage(NamedTuple):
    """Message of a bag as it was recorded: seconds, topic, type such as ``nav_msgs/msg/OccupancyGrid``, and bytes."""

    time_s: float
    topic: str
    type: str
    data: bytes


class _Bag(NamedTuple):
    """An open bag: its connections, their messages as (connection, time, bytes), and the decoder of a map."""

    connections: Sequence[Any]
    messages: Callable[..., Iterator[tuple[Any, int, bytes]]]
    decode: Callable[[bytes, str], Any]


def split_bag(path: str | os.PathLike[str]) -> BagName | None:
    """Split the name of a map in a bag; return None if it is not such a name.

    A bag is a ``.bag``, ``.mcap`` or ``.db3`` file, existing or not, or a rosbag2 folder with its metadata.yaml.

    Examples
    --------
    >>> split_bag("runs/run.mcap:/robot1/map")
    BagName(file=...Path('runs/run.mcap'), topic='/robot1/map')
    >>> split_bag("map.pgm")
    """
    text = os.fspath(path)
    if Path(text).suffix in SUFFIXES or _is_there(Path(text) / METADATA):
        return BagName(Path(text), None)
    file, _, topic = text.rpartition(":")
    if file and (Path(file).suffix in SUFFIXES or (topic.startswith("/") and _is_there(Path(file), folder=True))):
        return BagName(Path(file), topic.rstrip("/") or None)
    return None


def is_bag(path: str | os.PathLike[str]) -> bool:
    """Return if a name is that of a map in a bag."""
    return split_bag(path) is not None


def bag_files(path: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Return the files of a bag: the bag, or all in a rosbag2 folder."""
    bag = split_bag(path)
    file = Path(path) if bag is None else bag.file
    return tuple(sorted(file.iterdir())) if _is_there(file, folder=True) else (file,)


def read_bag_map(path: str | os.PathLike[str]) -> OccupancyGrid:
    """Read the newest map on a topic of a bag.

    Parameters
    ----------
    path
        ``FILE:/topic``, or the bag alone where one topic holds maps. See `split_bag`.

    Raises
    ------
    MapFileError
        If rosbags is not installed, the bag or the topic cannot be read, or the map is unusable or has no free cell;
        the message names the file and the remedy.

    Notes
    -----
    Cells outside -1..100 are unknown. The resolution, 32 bits in the message, becomes the shortest decimal with these
    bits, 0.05 and not 0.05000000074505806. A quaternion of zeros, from publishers that leave it unset, is yaw 0; the
    height of the map's origin is ignored.
    """
    bag = split_bag(path)
    if bag is None:
        raise MapFileError(f"{path}: is no bag; name a .bag, .mcap or .db3 file or a rosbag2 folder, and its topic")
    _require_bag(bag.file)
    with _opened(bag.file) as opened:
        topic, connections = _select_topic(bag, opened.connections)
        newest: tuple[int, bytes] | None = None
        for _, time, data in opened.messages(connections=connections):
            if newest is None or time >= newest[0]:
                newest = time, data
        if newest is None:
            raise MapFileError(f"{bag.file}: there is no message on {topic}; record it until a map is published")
        message = opened.decode(newest[1], MAP_TYPE)
    return grid_of_message(message, f"{bag.file}:{topic}")


def bag_maps(path: str | os.PathLike[str]) -> Iterator[tuple[float, str, OccupancyGrid | MapFileError]]:
    """Yield every map in a bag as it was recorded: time in seconds, topic, and the map, or why it is none.

    Parameters
    ----------
    path
        A bag, or ``FILE:/topic`` for a single topic; see `split_bag`.

    Raises
    ------
    MapFileError
        If rosbags is not installed, the bag or the topic cannot be read, or the bag holds no map.
    """
    bag = split_bag(path)
    if bag is None:
        raise MapFileError(f"{path}: is no bag; name a .bag, .mcap or .db3 file or a rosbag2 folder")
    _require_bag(bag.file)
    with _opened(bag.file) as opened:
        connections = [each for each in opened.connections if each.msgtype == MAP_TYPE]
        if bag.topic is not None or not connections:
            connections = _select_topic(bag, opened.connections)[1]
        for connection, time, data in opened.messages(connections=connections):
            try:
                grid = grid_of_message(opened.decode(data, MAP_TYPE), f"{bag.file}:{connection.topic}")
            except MapFileError as fault:
                yield time * 1e-9, connection.topic, fault
            else:
                yield time * 1e-9, connection.topic, grid


def bag_messages(path: str | os.PathLike[str]) -> Iterator[BagMessage]:
    """Yield every message of a bag of ROS 2, serialized as it was recorded (CDR), in the order of their times.

    Raises
    ------
    MapFileError
        If rosbags is not installed, the bag cannot be read, or it is of ROS 1.
    """
    file = Path(path)
    _require_bag(file)
    if file.suffix == ".bag" and not file.is_dir():
        raise MapFileError(f"{file}: is a bag of ROS 1; name one of ROS 2: MCAP, sqlite3 or a rosbag2 folder")
    with _opened(file) as opened:
        for connection, time, data in opened.messages():
            yield BagMessage(time * 1e-9, connection.topic, connection.msgtype, bytes(data))


@contextmanager
def _opened(file: Path) -> Iterator[_Bag]:
    """Open a bag; turn the errors of a broken one, until it is closed, into one line."""
    try:
        from rosbags import rosbag1, rosbag2
        from rosbags.typesys import Stores, get_typestore

        broken: tuple[type[Exception], ...] = (*BROKEN, *_bag_errors())
    except ImportError:
        raise MapFileError(f"{file}: reading a bag {missing('rosbags')}") from None
    is_first = file.suffix == ".bag" and not file.is_dir()
    # the type is the same in all distributions, so a bag's own definitions are not needed
    store = get_typestore(Stores.ROS1_NOETIC if is_first else Stores.ROS2_HUMBLE)
    decode = store.deserialize_ros1 if is_first else store.deserialize_cdr
    try:
        with bounded_sizes(), rosbag1.Reader(file) if is_first else rosbag2.Reader(file) as reader:
            yield _Bag(reader.connections, reader.messages, decode)
    except MapFileError:
        raise
    except PermissionError:
        raise MapFileError(f"{file}: permission denied; make the bag readable") from None
    except broken as error:
        reason = (" ".join(str(error).split()) or type(error).__name__)[:LONGEST_REASON]
        mend = "rosbag reindex" if is_first else "ros2 bag reindex or ros2 bag convert"
        raise MapFileError(f"{file}: broken, truncated or unknown bag ({reason}); {mend} may mend it") from None


def _bag_errors() -> tuple[type[Exception], ...]:
    """Return the errors of rosbags and the libraries below it on broken bags, in addition to Python's own."""
    import apsw
    from rosbags import rosbag1, rosbag2
    from rosbags.serde import SerdeError
    from rosbags.typesys import TypesysError
    from ruamel.yaml.error import YAMLError

    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    ours = (rosbag1.ReaderError, rosbag2.ReaderError, SerdeError, TypesysError)
    return (*ours, apsw.Error, zstd.ZstdError, YAMLError, MemoryError)


def _require_bag(file: Path) -> None:
    if not _is_there(file, folder=True):
        require_file(file)
        if file.stat().st_size == 0:
            raise MapFileError(f"{file}: the file is empty; record or copy it again")
    elif not _is_there(file / METADATA):
        raise MapFileError(f"{file}: no rosbag2 folder: there is no {METADATA}; ros2 bag reindex makes it")


def _is_there(path: Path, *, folder: bool = False) -> bool:
    with suppress(OSError, ValueError):  # names that no file can have
        return path.is_dir() if folder else path.is_file()
    return False


def _select_topic(bag: BagName, connections: Sequence[Any]) -> tuple[str, list[Any]]:
    """Return the topic of the map with its connections; several may publish on one."""
    maps = [connection for connection in connections if connection.msgtype == MAP_TYPE]
    topics = sorted({each.topic for each in maps if each.msgcount} or {each.topic for each in maps})
    offer = f"its maps are on {', '.join(topics)}" if topics else "it holds no nav_msgs/OccupancyGrid at all"
    if bag.topic is None and len(topics) != 1:
        remedy = f"; name one, as in {bag.file}:{topics[0]}" if topics else ""
        raise MapFileError(f"{bag.file}: {offer}{remedy}")
    topic = topics[0] if bag.topic is None else bag.topic
    selected = [each for each in maps if each.topic.strip("/") == topic.strip("/")]
    if not selected:
        types = {each.msgtype for each in connections if each.topic.strip("/") == topic.strip("/")}
        fault = f"{topic} holds {min(types)}" if types else f"there is no topic {topic}"
        raise MapFileError(f"{bag.file}: {fault}; {offer}")
    return selected[0].topic, selected
