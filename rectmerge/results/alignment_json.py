"""File ``alignment.json``: the record of a merge, as it is written and as later commands read it."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from rectmerge.alignment import SCHEMA, Alignment, Verdict
from rectmerge.analysis.shared_area import measure_shared_area
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.results.folder import note_interrupted

NAME = "alignment.json"
FLEET_NAME = "fleet.json"  # of a merge of more than two maps


def to_json_dict(alignment: Alignment, a: OccupancyGrid, b: OccupancyGrid) -> dict[str, Any]:
    """Return the record of an alignment, with the area that both maps show under each candidate."""
    record = alignment.as_dict()
    for candidate, entry in zip(alignment.candidates, record["candidates"], strict=True):
        entry["shared"] = measure_shared_area(a, b, candidate.pixels).as_dict()
    return record


@dataclass(frozen=True, slots=True)
class AlignmentFile:
    """The ``alignment.json`` of an earlier merge.

    Parameters
    ----------
    path
        The file, by the name it was given.
    verdict, reason
        The keys that every record has.
    record
        The whole record; read its other keys under `explain_errors`.
    """

    path: Path
    verdict: Verdict
    reason: str
    record: Mapping[str, Any]

    @classmethod
    def read(cls, path: str | Path) -> AlignmentFile:
        """Read the record of a merge, given the file or its folder.

        Raises
        ------
        InputError
            If there is no such file, or `rectmerge merge` did not write it.
        """
        file = _file_of(Path(path))
        _refuse_fleet(file)
        note_interrupted(file.parent)
        with explain_errors(file):
            record = json.loads(file.read_text(encoding="utf-8"))
            if not isinstance(record, dict):
                raise ValueError("no JSON object")
            if record["verdict"] not in get_args(Verdict):
                raise ValueError(f"no verdict {record['verdict']!r}")
            _require_agreement(record)
            return cls(file, record["verdict"], str(record["reason"]), record)

    @property
    def folder(self) -> Path:
        """The folder of the merge."""
        return self.path.parent

    def input_field(self, name: str, key: str) -> Any:
        """Return the value of a key of map "a" or "b" under ``inputs``; None where there is none."""
        entry: Any = self.record
        for part in ("inputs", name, key):
            entry = entry.get(part) if isinstance(entry, Mapping) else None
        return entry

    def explain_errors(self) -> contextlib.AbstractContextManager[None]:
        """Turn the errors of a key that is missing or unusable into an `InputError` that names the file."""
        return explain_errors(self.path)


def _require_agreement(record: Mapping[str, Any]) -> None:
    """Refuse a record of another version, or one whose answer is not its first candidate's."""
    if record["schema"] != SCHEMA:
        raise ValueError(f"its schema is {record['schema']!r:.60}, not {SCHEMA!r}")
    for key in ("b_to_a", "pixels"):
        if record.get(key) is not None and record[key] != record["candidates"][0][key]:
            raise ValueError(f"its {key} is not that of its first candidate")


def _file_of(path: Path) -> Path:
    with contextlib.suppress(OSError):  # a name too long: reading it says so
        if path.is_file():
            return path
    return path / NAME


def _refuse_fleet(file: Path) -> None:
    with contextlib.suppress(OSError):
        if file.name == FLEET_NAME or (not file.exists() and (file.parent / FLEET_NAME).is_file()):
            raise InputError(f"{file.parent}: holds more than two maps, but this is for the merge of two")


@contextlib.contextmanager
def explain_errors(path: Path) -> Iterator[None]:
    """Turn the errors of a file that is not as `rectmerge merge` writes it into an `InputError` that names it."""
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; name the folder of a merge") from None
    except KeyError as error:
        raise InputError(f"{path}: not an answer of rectmerge merge: there is no {error}; merge again") from None
    except (ValueError, TypeError, LookupError, ArithmeticError, AttributeError, RecursionError) as error:
        raise InputError(f"{path}: not an answer of rectmerge merge: {error}; merge again") from None
