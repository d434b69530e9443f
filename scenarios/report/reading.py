"""Finished runs: rows by suite and track, provenance, and maps."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from scenarios.bench.resume import RECORD, read_machine
from scenarios.bench.run import DATASET, read_rows
from scenarios.dataset.reader import RowSource, is_dataset, open_dataset
from scenarios.scoring.row import Row, by_method

TRACKS = {False: "unknown scale", True: "known scale"}


@dataclass(frozen=True, slots=True)
class TrackResults:
    """All rows of one suite and track."""

    suite: str
    track: str
    rows: Sequence[Row]

    @property
    def name(self) -> str:
        """Heading on the page."""
        return f"{self.suite}, {self.track}"

    def by_method(self) -> dict[str, list[Row]]:
        """Return the rows of each label, in order of first appearance."""
        return by_method(self.rows)


@dataclass(frozen=True, slots=True)
class Provenance:
    """Command, commit and machine of a run."""

    command: str
    commit: str
    machine: str


@dataclass(frozen=True, slots=True)
class Runs:
    """Rows, provenance and maps of finished runs.

    Parameters
    ----------
    tracks
        The rows, by suite and track in the order of the runs.
    provenance
        Of each run.
    maps
        Rows of data sets that hold the pairs' maps, by pair id; pairs that no data set holds are missing.
    """

    tracks: Sequence[TrackResults]
    provenance: Sequence[Provenance]
    maps: dict[str, RowSource]

    @classmethod
    def read(cls, folders: Sequence[Path]) -> Runs:
        """Read finished runs.

        Raises
        ------
        InputError
            If a folder holds no finished run, or two runs hold the same pair, method and track.
        """
        grouped: dict[tuple[str, str], list[Row]] = {}
        provenance, seen = [], set()
        maps: dict[str, RowSource] = {}
        for folder in folders:
            for row in read_rows(folder):
                track = TRACKS[bool(row.get("knows_scale"))]
                task = (row["suite"], track, row["pair_id"], row["method"])
                if task in seen:
                    raise InputError(f"{folder}: {row['method']} on {row['pair_id']} is in another run as well")
                seen.add(task)
                grouped.setdefault((row["suite"], track), []).append(row)
            provenance.append(_provenance(folder))
            maps |= _maps(folder)
        return cls([TrackResults(suite, track, rows) for (suite, track), rows in grouped.items()], provenance, maps)


def _provenance(folder: Path) -> Provenance:
    record = read_machine(folder)
    machine = f"{record['processor']}, {record['cores']} cores, {record['system']}, Python {record['python']}"
    return Provenance(str(record["command"]), str(record["commit"] or "unknown"), machine)


def dataset_of(folder: Path) -> Path | None:
    """Find a run's own data set, or the one that it was run on (or its split); None if that is no longer there.

    Raises
    ------
    InputError
        If the run's record cannot be read.
    """
    try:
        record: dict[str, Any] = tomllib.loads((folder / RECORD).read_text(encoding="utf-8"))
        paths = (folder / DATASET, Path(record.get("dataset", folder / DATASET)))
    except (OSError, ValueError, TypeError, RecursionError) as error:
        raise InputError(f"{folder / RECORD}: cannot be read: {error}") from None
    return next((path for path in paths if is_dataset(path)), None)


def _maps(folder: Path) -> dict[str, RowSource]:
    """Find the pairs of a run's data set."""
    path = dataset_of(folder)
    sources = [] if path is None else open_dataset(path)
    return {source.pair_id: source for source in sources if isinstance(source, RowSource)}
