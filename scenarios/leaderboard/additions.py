"""Submissions beside the leaderboard's own runs: the same pairs, under labels that say where they are from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from rectmerge.errors import InputError
from scenarios.dataset.dataset_id import SHOWN_DIGITS
from scenarios.dataset.reader import RowSource, dataset_name, open_dataset
from scenarios.leaderboard.submission import Submission, data_set_record
from scenarios.report.reading import TRACKS, Runs, TrackResults, dataset_of
from scenarios.scoring.row import Row


def with_submissions(
    runs: Runs, submissions: Mapping[Path, Submission], data_sets: Mapping[str, str]
) -> tuple[Runs, dict[str, str]]:
    """Add submissions to the tracks of finished runs.

    Parameters
    ----------
    runs
        Of the leaderboard.
    submissions
        By the file that each was read from, whose name is added to its labels.
    data_sets
        Id of the data set of each suite, where it is known.

    Returns
    -------
    runs, reported
        The runs with the submissions' rows, and the status of each label that was added.

    Raises
    ------
    InputError
        If a submission is of no suite and track of the leaderboard, of another data set or of one that is no longer
        there, lacks some of the pairs, or has a label of another file's; the message names the file.
    """
    _require_own_labels(submissions)
    reported: dict[str, str] = {}
    tracks = {(track.suite, track.track): track for track in runs.tracks}
    for path, submission in submissions.items():
        by_track: dict[tuple[str, str], list[Row]] = {}
        for row in submission.as_rows():
            label = _label(path, row["method"])
            reported[label] = submission.standing
            track = row["suite"], TRACKS[submission.knows_scale[row["method"]]]
            by_track.setdefault(track, []).append({**row, "method": label})
        for key, rows in by_track.items():
            if key not in tracks:
                here = "; ".join(track.name for track in tracks.values())
                raise InputError(f"{path}: rows: the leaderboard has no {', '.join(key)}; it has: {here}")
            _require_data_set(path, submission, key[0], data_sets)
            tracks[key] = replace(tracks[key], rows=[*tracks[key].rows, *_of_track(path, rows, tracks[key])])
    return replace(runs, tracks=list(tracks.values())), reported


def data_set_ids(folders: Sequence[Path], runs: Runs) -> dict[str, str]:
    """Return the id of each suite's data set, of those that are still where the runs found them."""
    ids: dict[str, str] = {}
    for target in filter(None, map(dataset_of, folders)):
        (first, *_) = open_dataset(target)
        suite = first.row().suite if isinstance(first, RowSource) else dataset_name(target)
        ids[suite] = data_set_record(target).id
    return {track.suite: ids[track.suite] for track in runs.tracks if track.suite in ids}


def _label(path: Path, method: str) -> str:
    return f"{method} ({path.stem})"


def _require_own_labels(submissions: Mapping[Path, Submission]) -> None:
    """Refuse a label that two files have: their rows would count as those of one method."""
    files: dict[str, Path] = {}
    for path, label in ((path, _label(path, m.label)) for path, told in submissions.items() for m in told.methods):
        if (other := files.setdefault(label, path)) != path:
            raise InputError(f"{path}: its label {label!r} is that of {other} too; give one of the files another name")


def _require_data_set(path: Path, submission: Submission, suite: str, data_sets: Mapping[str, str]) -> None:
    here, there = data_sets.get(suite), submission.data_set.id
    if here is None:
        raise InputError(
            f"{path}: data_set.id: cannot be compared: the leaderboard's {suite} is no longer where its run found it; "
            "put it back"
        )
    if here != there:
        ids = f"{there[:SHOWN_DIGITS]}, the leaderboard is of {here[:SHOWN_DIGITS]}"
        raise InputError(f"{path}: data_set.id: is of another data set than the leaderboard's {suite}: {ids}")


def _of_track(path: Path, rows: Sequence[Row], track: TrackResults) -> list[Row]:
    """Return the rows on the track's pairs, all of which must be there: every pair counts."""
    pairs = {row["pair_id"] for row in track.rows}
    for label in {row["method"] for row in rows}:
        if lost := pairs - {row["pair_id"] for row in rows if row["method"] == label}:
            text = f"{len(lost)} of the {len(pairs)} pairs of {track.name} are missing, {min(lost)!r} first"
            raise InputError(f"{path}: rows: of {label}, {text}; every pair counts")
    return [row for row in rows if row["pair_id"] in pairs]
