"""A file of JSON lines that only grows, by whole lines, and belongs to one process at a time."""

from __future__ import annotations

import contextlib
import fcntl
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError


class Journal:
    """Lines that survive the end of the process that wrote them; a line that it tore is dropped when it is opened.

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
            raise InputError(f"{path.parent}: another process is writing it") from None
        self._size = 0
        for start, line in self._lines():
            self._size = start + len(line)
        self._file.truncate(self._size)

    def append(self, line: dict[str, Any]) -> None:
        """Add a line.

        Raises
        ------
        InputError
            If it cannot be written; what there is of it is dropped when the journal is opened again.
        """
        data = json.dumps(line, allow_nan=False).encode() + b"\n"
        try:
            self._file.write(data)
            self._file.flush()
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written: {error.strerror}") from None
        self._size += len(data)

    def entries(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """Read every line, with where it begins."""
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
        self._size = 0

    def close(self) -> None:
        """Leave the file to others."""
        with contextlib.suppress(OSError):  # of a full disk, which `append` told of
            self._file.close()

    def delete(self) -> None:
        """Remove the file."""
        self.path.unlink()
        self._file.close()

    def _lines(self) -> Iterator[tuple[int, bytes]]:
        """Read whole lines with where they begin; the caller may read elsewhere meanwhile."""
        start = 0
        while True:
            self._file.seek(start)
            line = self._file.readline()
            if not line.endswith(b"\n"):
                return
            yield start, line
            start += len(line)
