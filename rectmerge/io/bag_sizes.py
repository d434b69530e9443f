"""Bounds on the sizes to which a bag's compressed chunks, messages and files are unpacked."""

from __future__ import annotations

import bz2
import io
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

from rectmerge.grid import MOST_CELLS

MOST_CHUNK_BYTES = 2 * MOST_CELLS  # a chunk holds messages, and the largest map has MOST_CELLS bytes


@contextmanager
def bounded_sizes() -> Iterator[None]:
    """Let rosbags meanwhile unpack no chunk or message to more than 300 million bytes, nor than an MCAP file states.

    A whole compressed file is unpacked into the temporary folder, to at most half of its free space.

    Notes
    -----
    rosbags has no limit of its own: its decompressors are replaced.
    """
    from lz4.frame import LZ4FrameDecompressor
    from rosbags.rosbag1 import reader as rosbag1
    from rosbags.rosbag2 import reader as rosbag2
    from rosbags.rosbag2 import storage_mcap as mcap

    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    makers: dict[str, Callable[[], Any]] = {
        "bz2": bz2.BZ2Decompressor,
        "lz4": LZ4FrameDecompressor,
        "zstd": zstd.ZstdDecompressor,
    }
    tables: list[dict[str, Any]] = [rosbag1.decompressors, mcap.DECOMPRESSORS]
    earlier = [dict(table) for table in tables]
    try:
        for table in tables:
            table.update({name: _bounded(make) for name, make in makers.items() if name in table})
        bounded = SimpleNamespace(
            decompress=_bounded(zstd.ZstdDecompressor, "message"),
            open=lambda file, mode: _BoundedFile(zstd.open(file, mode), free_bytes() // 2),
        )
        vars(rosbag2)["zstd"] = bounded
        yield
    finally:
        vars(rosbag2)["zstd"] = zstd
        for table, before in zip(tables, earlier, strict=True):
            table.update(before)


def free_bytes() -> int:
    """Return the free space of the temporary folder."""
    return shutil.disk_usage(tempfile.gettempdir()).free


class _BoundedFile(io.BufferedIOBase):
    """A compressed file that is unpacked to a bounded size."""

    def __init__(self, file: Any, most_bytes: int) -> None:
        self._file = file
        self._most_bytes = self._room = most_bytes

    def read(self, size: int | None = -1) -> bytes:
        """Read unpacked bytes."""
        data = self._file.read(-1 if size is None else size)
        self._room -= len(data)
        if self._room < 0:
            raise ValueError(
                f"a file unpacks to more than {self._most_bytes} bytes, half of the temporary folder's space"
            )
        return bytes(data)

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        super().close()


def _bounded(make: Callable[[], Any], what: str = "chunk") -> Callable[..., bytes]:
    """Return a decompressor for data and, in MCAP, the size that they should have."""

    def decompress(data: bytes, stated: int = MOST_CHUNK_BYTES) -> bytes:
        if stated > MOST_CHUNK_BYTES:
            raise ValueError(f"a {what} of {stated} bytes, more than {MOST_CHUNK_BYTES // 10**6} million")
        parts, room = [], stated
        while data:  # one frame after the other
            unpacker = make()
            parts.append(unpacker.decompress(data, room + 1))
            room -= len(parts[-1])
            if room < 0:
                raise ValueError(f"a {what} unpacks to more than {stated} bytes")
            if not unpacker.eof:
                raise ValueError(f"a {what} is cut off")
            data = unpacker.unused_data or b""
        return b"".join(parts)

    return decompress
