"""Bounds on the size to which a bag's compressed chunks are unpacked."""

from __future__ import annotations

import bz2
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rectmerge.grid import MOST_CELLS

MOST_CHUNK_BYTES = 2 * MOST_CELLS  # a chunk holds messages, and the largest map has MOST_CELLS bytes


@contextmanager
def bounded_chunks() -> Iterator[None]:
    """Let rosbags meanwhile unpack no chunk to more than 300 million bytes, or than an MCAP file states.

    Notes
    -----
    rosbags has no limit of its own: its tables of decompressors are replaced. Messages that are compressed one by one,
    and whole compressed files, are not bounded.
    """
    from lz4.frame import LZ4FrameDecompressor
    from rosbags.rosbag1 import reader as rosbag1
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
        yield
    finally:
        for table, before in zip(tables, earlier, strict=True):
            table.update(before)


def _bounded(make: Callable[[], Any]) -> Callable[..., bytes]:
    """Return a decompressor for data and, in MCAP, the size that they should have."""

    def decompress(data: bytes, stated: int = MOST_CHUNK_BYTES) -> bytes:
        if stated > MOST_CHUNK_BYTES:
            raise ValueError(f"a chunk of {stated} bytes, more than {MOST_CHUNK_BYTES // 10**6} million")
        parts, room = [], stated
        while data:  # one frame after the other
            unpacker = make()
            parts.append(unpacker.decompress(data, room + 1))
            room -= len(parts[-1])
            if room < 0:
                raise ValueError(f"a chunk unpacks to more than {stated} bytes")
            if not unpacker.eof:
                raise ValueError("a chunk is cut off")
            data = unpacker.unused_data or b""
        return b"".join(parts)

    return decompress
