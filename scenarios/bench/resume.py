"""The folder of a run that may end at any moment and goes on where it stopped: one writer, whole lines."""

from __future__ import annotations

import json
import tomllib
from array import array
from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.io.json_text import plain
from scenarios.execution.journal import Journal
from scenarios.execution.terminal import open_with_progress
from scenarios.scoring.row import Row, row_fault

RECORD, MACHINE, RESULTS, SUMMARY = "run.toml", "machine.json", "results.jsonl", "summary.json"
DESCRIBED_BY = ("processor", "cores", "system", "python", "commit", "command")  # keys of a machine's record
TOLD_APART_BY = ("suite", "seed", "methods", "pairs")  # keys of the record, for people


class Results:
    """The rows of a run that this process alone may add to.

    Parameters
    ----------
    journal
        ``results.jsonl`` in the run's folder.
    """

    def __init__(self, journal: Journal) -> None:
        self.folder = journal.path.parent
        self._journal = journal
        self._done = _task_numbers(journal.path)

    @property
    def count(self) -> int:
        """Return the number of rows at the start."""
        return len(self._done)

    def holds(self, task_id: str) -> bool:
        """Return True if the row of a task existed at the start."""
        number = np.uint64(int(task_id, 16))
        place = int(np.searchsorted(self._done, number))
        return place < len(self._done) and bool(self._done[place] == number)

    def add(self, rows: Iterable[Row]) -> None:
        """Append rows as whole lines and hand them to the system.

        Raises
        ------
        InputError
            If they cannot be written.
        """
        self._journal.append(*map(plain, rows))


@contextmanager
def open_results(out: str | Path, record: str, *, force: bool) -> Iterator[Results]:
    """Open a run's folder to begin a run, or to go on with the one that it holds.

    Parameters
    ----------
    out
        The folder; made where there is none.
    record
        What ``run.toml`` is to hold; a run with another ``run_id`` is a run of something else.
    force
        Clear what the folder holds.

    Raises
    ------
    InputError
        If another process is writing into it, it holds a run of something else and `force` is off, it cannot be
        written, or a row in it is damaged.
    """
    folder = Path(out)
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder}: is a file; results go into a folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be written: {error.strerror}") from error
    with closing(Journal(folder / RESULTS)) as journal:
        if force:
            _clear(folder, journal)
        _check_same(folder, record)
        journal.mend()
        yield Results(journal)


def read_row_file(path: Path, *, has_progress: bool = False) -> Iterator[Row]:
    """Read rows one by one.

    Parameters
    ----------
    path
        ``results.jsonl`` of a run.
    has_progress
        Show on a terminal how far a large file is read.

    Raises
    ------
    InputError
        If a line is not a row.
    """
    try:
        opened = open_with_progress(path) if has_progress else path.open("rb")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    with opened as lines:
        for number, line in enumerate(lines, start=1):
            try:
                row = json.loads(line)
            except (ValueError, RecursionError) as error:
                raise InputError(f"{path}:{number}: not JSON: {error}") from None
            if why := row_fault(row):
                raise InputError(f"{path}:{number}: not a row of a run: {why}")
            yield cast(Row, row)


def read_machine(folder: Path) -> dict[str, Any]:
    """Read the record of the machine and the code of a run.

    Returns
    -------
    dict
        As `scenarios.execution.executors.describe_machine` makes it.

    Raises
    ------
    InputError
        If it cannot be read, or is not that of a run.
    """
    path = folder / MACHINE
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(record, dict):
            raise TypeError(f"it is a {type(record).__name__}")
    except (OSError, ValueError, TypeError, RecursionError) as error:
        raise InputError(f"{path}: cannot be read: {error}") from None
    if lost := next((key for key in DESCRIBED_BY if key not in record), None):
        raise InputError(f"{path}: is not that of a run: there is no {lost!r}")
    return record


def _clear(folder: Path, journal: Journal) -> None:
    """Clear a run's files, the rows last, so that a run half cleared is still refused."""
    for name in (SUMMARY, MACHINE, RECORD):
        (folder / name).unlink(missing_ok=True)
    journal.clear()


def _check_same(folder: Path, record: str) -> None:
    path = folder / RECORD
    if not path.exists() and not (folder / RESULTS).stat().st_size:
        return
    try:
        before = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        before = {}
    if before.get("run_id") != (now := tomllib.loads(record))["run_id"]:
        differs = next((key for key in TOLD_APART_BY if before.get(key) != now[key]), "content of the pairs")
        raise InputError(f"{folder}: holds a run of something else (another {differs}); --force clears it")


def _task_numbers(path: Path) -> NDArray[np.uint64]:
    """Return the ids of the rows as numbers, ascending: eight bytes each, however many there are."""
    return np.sort(np.frombuffer(array("Q", (_number(row, path) for row in read_row_file(path))), dtype=np.uint64))


def _number(row: Row, path: Path) -> int:
    try:
        return int(row["task_id"], 16)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: a row has no task_id of this version; --force clears the run") from error
