"""Writer of a data set that grows by whole sources; the files do not depend on the order of the work."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple

from rectmerge.errors import InputError
from rectmerge.io.atomic_file import replace_file
from scenarios.dataset.card import card, picture
from scenarios.dataset.columns import Columns
from scenarios.dataset.dataset_id import CARD, INFO, PICTURE, checksum, dataset_id
from scenarios.dataset.fleets import FLEETS, FleetLines
from scenarios.dataset.metadata import METADATA
from scenarios.dataset.packing import Package
from scenarios.dataset.reader import SPLITS
from scenarios.execution.files import write_json
from scenarios.execution.journal import Journal

JOURNAL = "unfinished.jsonl"
FOLDERS = ("", *(f"{split}/{inner}" for split in SPLITS for inner in ("", "maps/", "worlds/", "bags/*/")))
OWN = (  # what --force clears, and nothing else
    *(
        f"{folder}*{suffix}"
        for folder in FOLDERS[1:]
        for suffix in (".png", ".yaml", ".mcap", ".bag", METADATA, FLEETS)
    ),
    *(CARD, PICTURE, INFO),
)


class DataSetWriter:
    """Writes a data set, and goes on with one that was interrupted.

    What is written lies in ``unfinished.jsonl``, a line for each source, until `finish` sorts it into the splits. A
    line is added when a source's files are there; `done` are the sources that need not be made again, with their pairs.

    Parameters
    ----------
    out
        The data set's folder; may not exist.
    identity
        What determines the data set, as plain data: an unfinished or finished one of another identity is refused.
    force
        Clear any data set in the folder first.

    Raises
    ------
    InputError
        If the folder holds something else, is in use by another process, or cannot be written.
    """

    def __init__(self, out: str | Path, identity: Mapping[str, Any], *, force: bool = False) -> None:
        self.folder, self.identity = Path(out), dict(identity)
        self._check_folder(force=force)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{out}: cannot be written: {error.strerror}") from None
        self._journal = Journal(self.folder / JOURNAL)
        try:
            self.done = self._begin(force=force)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> DataSetWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let another process go on with the folder."""
        self._journal.close()

    def write(self, package: Package) -> None:
        """Write a source's package: its files first, then its line.

        Raises
        ------
        InputError
            If it cannot be written.
        """
        for path, data in package.files.items():
            try:
                (self.folder / path).parent.mkdir(parents=True, exist_ok=True)
            except OSError as error:
                raise InputError(f"{self.folder}: cannot be written: {error.strerror}") from None
            replace_file(self.folder / path, data)
        sums = {path: hashlib.sha256(data).hexdigest() for path, data in package.files.items()}
        line = {"source": package.source_id, "rows": package.rows, "files": sums}
        self._journal.append({**line, "discarded": package.discarded, "failed": package.failed})
        self.done[package.source_id] = len(package.rows) + len(package.failed)

    def finish(self, about: Mapping[str, Any]) -> dict[str, Any]:
        """Write the splits, the card and ``dataset_info.json``, and drop the journal.

        Parameters
        ----------
        about
            What the card and the info say of it: `title`, `description` and perhaps the `command`.

        Returns
        -------
        dict
            The content of ``dataset_info.json``.

        Raises
        ------
        InputError
            If there is no pair, or a file cannot be written.
        """
        found = _JournalIndex.from_journal(self._journal)
        if not found.places:
            reason = found.failed[0]["reason"] if found.failed else "there are no sources"
            raise InputError(f"{self.folder}: no pair came to be: {reason}")
        counts = {split: self._write_split(split, found) for split in SPLITS}
        info: dict[str, Any] = {
            **self.identity,
            **about,
            "splits": {name: count for name, count in counts.items() if count},
        }
        info |= {"discarded": {"count": found.discarded.total(), "reasons": dict(sorted(found.discarded.items()))}}
        info |= {"failed": sorted(found.failed, key=lambda failure: str(failure["pair_id"]))}
        fleets = [split for split in info["splits"] if self._write_fleets(split, found.fleets)]
        tables = (*(f"{split}/{METADATA}" for split in info["splits"]), *(f"{split}/{FLEETS}" for split in fleets))
        sums = found.checksums | {name: checksum(self.folder / name) for name in tables}
        info["dataset_id"] = dataset_id(sums)
        replace_file(self.folder / PICTURE, picture(self.folder))
        replace_file(self.folder / CARD, card(info, min(path for path in found.checksums if "/maps/" in path)).encode())
        sums |= {name: checksum(self.folder / name) for name in (CARD, PICTURE)}
        info["checksums"] = dict(sorted(sums.items()))
        write_json(self.folder / INFO, info)
        self._journal.delete()
        return info

    def _check_folder(self, *, force: bool) -> None:
        """Refuse a folder in which something lies that is no data set of ours, or a finished data set."""
        if self.folder.exists() and not self.folder.is_dir():
            raise InputError(f"{self.folder}: is a file; a data set goes into a folder")
        if not self.folder.is_dir() or (self.folder / JOURNAL).is_file():
            return
        if (self.folder / INFO).is_file():
            if not force:
                raise InputError(f"{self.folder}: holds a finished data set; --force replaces it")
        elif held := next(self.folder.iterdir(), None):
            raise InputError(f"{self.folder}: holds something else ({held.name}); name another folder")

    def _begin(self, *, force: bool) -> dict[str, int]:
        """Continue an interrupted call, or start anew."""
        for part in (path for folder in FOLDERS for path in self.folder.glob(f"{folder}.*.part")):
            part.unlink()
        self._journal.mend()
        entries = (entry for _, entry in self._journal.entries())
        head = next(entries, None)
        if head is not None and not force:
            if differing := [key for key in {**self.identity, **head} if head.get(key) != self.identity.get(key)]:
                differs = ", ".join(differing)
                raise InputError(
                    f"{self.folder}: holds an unfinished data set that differs in {differs}; --force clears it"
                )
            return {entry["source"]: len(entry["rows"]) + len(entry["failed"]) for entry in entries}
        for path in (path for pattern in OWN for path in self.folder.glob(pattern)):
            path.unlink()
        self._journal.clear()
        self._journal.append(self.identity)
        return {}

    def _write_split(self, split: str, found: _JournalIndex) -> dict[str, int]:
        """Write a split's rows: the related pairs first, as `Columns` has it, each kind by id."""
        places = sorted(place for place in found.places if place.split == split)
        if not places:
            return {}
        path = self.folder / split / METADATA
        part = path.with_name(f".{path.name}.part")
        start, rows = -1, []
        try:
            with part.open("w", encoding="utf-8") as file:
                for place in places:
                    if place.start != start:  # a source of many pairs is read once, and not for each
                        start, rows = place.start, self._journal.entry_at(place.start)["rows"]
                    file.write(_line(found.columns.fitted(rows[place.nth])))
            part.replace(path)
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}") from None
        return {"pairs": len(places), "related": sum(not place.is_unrelated for place in places)}

    def _write_fleets(self, split: str, fleets: FleetLines) -> bool:
        """Write the fleets of a split; return whether it has any."""
        lines = fleets.of_split(split)
        if lines:
            replace_file(self.folder / split / FLEETS, "".join(map(_line, lines)).encode())
        return bool(lines)


class _Place(NamedTuple):
    """Position of a row in the journal; sorts in the order of the finished rows."""

    split: str
    is_unrelated: bool
    pair_id: str
    start: int
    nth: int


class _JournalIndex:
    """Index of a journal, without the rows themselves."""

    def __init__(self) -> None:
        self.places: list[_Place] = []
        self.columns = Columns()
        self.fleets = FleetLines()
        self.checksums: dict[str, str] = {}
        self.discarded: Counter[str] = Counter()
        self.failed: list[dict[str, str]] = []

    @classmethod
    def from_journal(cls, journal: Journal) -> _JournalIndex:
        found = cls()
        entries = journal.entries()
        next(entries)  # the identity
        for start, entry in entries:
            for nth, row in enumerate(entry["rows"]):
                found.columns.note(row)
                found.fleets.note(row)
                found.places.append(_Place(row["split"], not row["related"], row["pair_id"], start, nth))
            found.checksums |= entry["files"]
            found.discarded.update(entry["discarded"])
            failed = entry["failed"].items()
            found.failed += [{"source": entry["source"], "pair_id": key, "reason": why} for key, why in failed]
        return found


def finished_info(folder: str | Path) -> dict[str, Any] | None:
    """Return the content of a finished data set's ``dataset_info.json``; None if there is none."""
    path = Path(folder)
    if (path / JOURNAL).is_file() or not (path / INFO).is_file():
        return None
    try:
        info = json.loads((path / INFO).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path / INFO}: cannot be read: {error}") from None
    if not isinstance(info, dict):
        raise InputError(f"{path / INFO}: must be an object, got {type(info).__name__}")
    return info


def _line(row: Mapping[str, Any]) -> str:
    """Return a row as JSON without spaces: most of it are numbers, a thousand and more."""
    return json.dumps(row, allow_nan=False, separators=(",", ":")) + "\n"
