"""Data sets of map pairs on disk: ``DATASET/{train,test}/metadata.jsonl`` and its maps, as sources of pairs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rectmerge.errors import DatasetError
from scenarios.dataset.metadata import METADATA, CheckedRow, check_row, line_at, metadata_lines, parse_row
from scenarios.pairs.pair import MapPair, PairSource

SPLITS = ("train", "test")


@dataclass(frozen=True, slots=True, kw_only=True)
class RowSource:
    """One row of a data set, by the start of its line: a `PairSource` that reads the row when asked.

    Parameters
    ----------
    folder
        The split's folder, which file names are relative to.
    start
        Where the row's line begins in ``metadata.jsonl``, bytes.
    suite
        The data set's name, for rows that tell no suite.
    pair_id, related
        The row's.
    """

    folder: Path
    start: int
    suite: str
    pair_id: str
    related: bool

    @property
    def source_id(self) -> str:
        """The pair's id."""
        return self.pair_id

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """The one pair of the row."""
        return (self.pair_id,)

    def is_related(self, pair_id: str) -> bool:
        """Return `related` as it was when the data set was opened: the row may be unreadable by now."""
        return self.related

    @property
    def info(self) -> Mapping[str, Any]:
        """Return the optional keys of the row."""
        return self.row().info

    def row(self) -> CheckedRow:
        """Read the row anew.

        Raises
        ------
        DatasetError
            If it no longer keeps the layout.
        """
        line = line_at(self.folder, self.start)
        return check_row(parse_row(line), self.folder, self.suite, line.place)

    def pairs(self) -> Iterator[MapPair]:
        """Read the maps, and measure their overlap under the truth if the row has none.

        Raises
        ------
        InputError
            If something cannot be read.
        """
        yield self.row().pair()


def is_dataset(path: str | Path) -> bool:
    """Return True if a path is a data set, or one split of it."""
    return bool(split_folders(Path(path)))


def dataset_name(path: str | Path) -> str:
    """Return the name of a data set, which its splits share: its folder's."""
    named = Path(path).resolve()
    return named.parent.name if named.name in SPLITS else named.name


def open_dataset(path: str | Path, *, split: str | None = None) -> list[PairSource]:
    """Open a data set: check every row and return one source per pair.

    Parameters
    ----------
    path
        The data set's folder, or the folder of one of its splits.
    split
        "train" or "test"; None opens every split there is.

    Raises
    ------
    DatasetError
        If there is no such data set or split, or a row does not keep the layout; the message names file and line.
    """
    root, suite = Path(path), dataset_name(path)
    folders = split_folders(root, split)
    if not folders:
        wanted = f"{split}/{METADATA}" if split else f"{METADATA} in it, in train/ or in test/"
        raise DatasetError(f"{root}: not a data set: there is no {wanted}")
    sources: dict[str, PairSource] = {}
    for folder in folders:
        for line in metadata_lines(folder):
            row = check_row(parse_row(line), folder, suite, line.place)
            if row.pair_id in sources:
                raise DatasetError(f"{line.place}: pair_id {row.pair_id!r} is used twice")
            sources[row.pair_id] = RowSource(
                folder=folder, start=line.start, suite=suite, pair_id=row.pair_id, related=row.related
            )
    if not sources:
        raise DatasetError(f"{root}: the data set has no rows")
    return list(sources.values())


def split_folders(root: Path, split: str | None = None) -> list[Path]:
    """Return the folders that hold rows: of a data set, or of one split of it."""
    folders = [root / split] if split else [root, *(root / name for name in SPLITS)]
    return [folder for folder in folders if (folder / METADATA).is_file()]
