"""The ``alignment.json`` of a merge, as later commands take it up."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from rectmerge.alignment import Verdict
from rectmerge.errors import InputError

NAME = "alignment.json"


@dataclass(frozen=True, slots=True)
class AnswerFile:
    """The answer of an earlier merge, in its file.

    Parameters
    ----------
    path
        The file, by the name it was given.
    verdict, reason
        What every answer tells.
    told
        All it tells; whoever takes more from it does so under `refusing`.
    """

    path: Path
    verdict: Verdict
    reason: str
    told: Mapping[str, Any]

    @classmethod
    def read(cls, named: str | Path) -> AnswerFile:
        """Read an answer, named itself or by its folder.

        Raises
        ------
        InputError
            If there is none, or it is not one that a merge wrote.
        """
        path = _file_of(Path(named))
        with _refusing(path):
            told = json.loads(path.read_text(encoding="utf-8"))
            if not isinstance(told, dict):
                raise ValueError("no JSON object")
            if told["verdict"] not in get_args(Verdict):
                raise ValueError(f"no verdict {told['verdict']!r}")
            return cls(path, told["verdict"], str(told["reason"]), told)

    @property
    def folder(self) -> Path:
        """The folder of the merge."""
        return self.path.parent

    def told_of(self, name: str, key: str) -> Any:
        """Return what is told of map "a" or "b" under ``inputs``; None where it is not."""
        entry: Any = self.told
        for part in ("inputs", name, key):
            entry = entry.get(part) if isinstance(entry, Mapping) else None
        return entry

    def refusing(self) -> contextlib.AbstractContextManager[None]:
        """Turn what is missing or of no use in `told` into an `InputError` that names the file."""
        return _refusing(self.path)


def _file_of(named: Path) -> Path:
    with contextlib.suppress(OSError):  # a name too long: reading it says so
        if named.is_file():
            return named
    return named / NAME


@contextlib.contextmanager
def _refusing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}; name the folder of a merge") from None
    except KeyError as error:
        raise InputError(f"{path}: not an answer of rectmerge merge: there is no {error}; merge again") from None
    except (ValueError, TypeError, RecursionError) as error:
        raise InputError(f"{path}: not an answer of rectmerge merge: {error}; merge again") from None
