"""A file of JSON lines that only grows, by whole lines, and belongs to one process at a time."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError

BLOCK = 2**16  # bytes that are looked through at a time for the end of the last line


class Journal:
    """Lines that survive the end of the process that wrote them, which may have torn the last.

    A torn line is no entry; `mend` drops it, before the first `append`. Opening changes nothing, for the file may yet
    turn out to be somebody else's.

    Parameters
    ----------
    path
        The file; made where it does not exist.

    Raises
    ------
    InputError
        If it cannot be written, or another process has it open.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self._file = path.open("a+b")
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}") from None
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._file.close()
            raise InputError(f"{path.parent}: another process is writing into it") from None

    def mend(self) -> None:
        """Drop a torn last line."""
        end = self._file.seek(0, os.SEEK_END)
        while end > 0:
            start = max(0, end - BLOCK)
            self._file.seek(start)
            if (last := self._file.read(end - start).rfind(b"\n")) >= 0:
                end = start + last + 1
                break
            end = start
        self._file.truncate(end)

    def append(self, *lines: dict[str, Any]) -> None:
        """Add lines and hand them to the system.

        Raises
        ------
        InputError
            If they cannot be written; what there is of the last is dropped when the journal is mended.
        """
        data = "".join(json.dumps(line, allow_nan=False) + "\n" for line in lines).encode()
        try:
            self._file.write(data)
            self._file.flush()
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written: {error.strerror}") from None

    def entries(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield every line with its start, in bytes."""
        for start, line in self._lines():
            yield start, json.loads(line)

    def entry_at(self, start: int) -> dict[str, Any]:
        """Read the line that begins there."""
        self._file.seek(start)
        entry: dict[str, Any] = json.loads(self._file.readline())
        return entry

    def clear(self) -> None:
        """Drop all lines."""
        self._file.truncate(0)

    def close(self) -> None:
        """Leave the file to others."""
        with contextlib.suppress(OSError):  # of a full disk, which `append` reported
            self._file.close()

    def delete(self) -> None:
        """Remove the file."""
        self.path.unlink()
        self._file.close()

    def _lines(self) -> Iterator[tuple[int, bytes]]:
        """Yield whole lines with their starts, in bytes; the caller may move in the file meanwhile."""
        start = 0
        while True:
            self._file.seek(start)
            line = self._file.readline()
            if not line.endswith(b"\n"):
                return
            yield start, line
            start += len(line)
