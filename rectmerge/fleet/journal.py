"""Journal of a merge of many maps while it runs: an interrupted one goes on where it was."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rectmerge.alignment import Alignment
from rectmerge.errors import InputError
from rectmerge.fleet.saved_graph import read_alignment
from rectmerge.io.json_text import plain

JOURNAL_NAME = "asked.jsonl"


class Journal:
    """Answers of the pairs that a merge has asked, in a file beside its results until it is finished.

    Parameters
    ----------
    folder
        Folder of the results; it is made with the first answer.
    settings
        Settings of the method. Answers that were given with others, or by another version, are dropped.

    Raises
    ------
    InputError
        If the file cannot be read.

    Notes
    -----
    Its first line holds the settings, each further one a pair by the digests of both maps, so that an answer about a
    map that was changed, or is no longer given, is never taken over. A line that was cut off counts as not written.
    """

    def __init__(self, folder: Path, settings: Mapping[str, Any]) -> None:
        self.path = folder / JOURNAL_NAME
        self._settings = {"version": version("rectmerge"), **plain(settings)}
        self.answers: dict[tuple[str, str], Alignment] = self._read()

    def known(self, digests: Sequence[str]) -> dict[tuple[int, int], Alignment]:
        """Return the answers about maps with these digests, by the indices of (A, B)."""
        at: dict[str, list[int]] = {}
        for index, digest in enumerate(digests):
            at.setdefault(digest, []).append(index)
        return {
            (a, b): answer
            for (of_a, of_b), answer in self.answers.items()
            for a in at.get(of_a, ())
            for b in at.get(of_b, ())
            if a != b
        }

    def add(self, digests: tuple[str, str], answer: Alignment) -> None:
        """Write down the answer about the maps with these digests, A's first.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        lines = [{"pair": digests, "alignment": answer.as_dict()}]
        if not self.answers:
            lines.insert(0, {"settings": self._settings})
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("a" if self.answers else "w", encoding="utf-8") as file:
                file.writelines(json.dumps(plain(line), allow_nan=False) + "\n" for line in lines)
        except OSError as error:
            raise InputError(f"{self.path}: cannot be written: {error.strerror}") from error
        self.answers[digests] = answer

    def remove(self) -> None:
        """Remove the file: the merge is finished."""
        self.path.unlink(missing_ok=True)

    def _read(self) -> dict[tuple[str, str], Alignment]:
        try:
            text = self.path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            raise InputError(f"{self.path}: cannot be read: {error}; remove it to begin anew") from error
        head, *lines = text.split("\n")[:-1] or [""]
        try:
            if head and json.loads(head)["settings"] != self._settings:
                return {}
            entries = [json.loads(line) for line in lines]
            return {(entry["pair"][0], entry["pair"][1]): read_alignment(entry["alignment"]) for entry in entries}
        except (ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
            raise InputError(f"{self.path}: not the journal of a merge: {error}; remove it to begin anew") from error
