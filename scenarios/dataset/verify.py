"""Verification of a data set: checksums, rows, truth, overlaps, maps and splits, all recomputed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.errors import DatasetError, InputError, RectMergeError
from rectmerge.grid import pixels_to_map_frame
from rectmerge.io.map_file import map_files, read_map
from rectmerge.similarity import Similarity
from scenarios.dataset.dataset_id import INFO, checksum, content_files, dataset_id
from scenarios.dataset.metadata import METADATA, MetadataLine, check_row, metadata_lines, parse_row
from scenarios.dataset.reader import dataset_name, split_folders
from scenarios.dataset.writer import JOURNAL, finished_info
from scenarios.pairs.pair import MapPair

FIT_WITHIN_PX = 0.05  # of the least-squares fit, on the control points: numbers in rows are rounded
OVERLAP_WITHIN = 0.01
RESOLUTION_WITHIN = 1e-6  # of itself


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Counts of a verification, and its faults, each with file and line.

    Parameters
    ----------
    pairs, files
        How many rows were checked, and how many checksums.
    faults
        Empty where the data set is what it says.
    dataset_id
        Hash of the content as it is.
    notes
        What could not be checked.
    """

    pairs: int
    files: int
    faults: tuple[str, ...]
    dataset_id: str
    notes: tuple[str, ...] = ()


@dataclass(slots=True)
class _FirstUses:
    """Ids and buildings seen so far, each with the place of its first use."""

    pair_ids: dict[str, str] = field(default_factory=dict)
    buildings: dict[str, tuple[str, str]] = field(default_factory=dict)  # split and place
    pairs: int = 0


def verify(dataset: str | Path, on_pair: Callable[[], None] = lambda: None) -> Verdict:
    """Check a data set, of our making or not.

    Parameters
    ----------
    dataset
        Its folder. Without ``dataset_info.json`` there are no checksums, and all the rest is checked.
    on_pair
        Called after every row.

    Raises
    ------
    DatasetError
        If there is no data set, or an unfinished one.
    InputError
        If ``dataset_info.json`` cannot be read.
    """
    root = Path(dataset)
    if (root / JOURNAL).is_file():
        raise DatasetError(f"{root}: is unfinished; the same `rectbench generate` again goes on with it")
    if not (folders := split_folders(root)):
        raise DatasetError(f"{root}: not a data set: there is no {METADATA} in it, in train/ or in test/")
    info, seen = finished_info(root), _FirstUses()
    checksums: dict[str, str] = (info or {}).get("checksums", {})
    names = content_files(root)
    content, unreadable = _measure(root, {*names, *checksums})
    readable = {name: expected for name, expected in checksums.items() if name not in unreadable}
    faults = [*unreadable.values(), *_wrong_files(root, readable, content)]
    for folder in folders:
        for line in metadata_lines(folder):
            faults += [f"{line.place}: {fault}" for fault in _wrong_in_line(line, folder, dataset_name(root), seen)]
            seen.pairs += 1
            on_pair()
    faults += _wrong_counts(root, info, folders)
    measured = dataset_id({name: content[name] for name in names if name in content})
    if not faults and measured != (declared := (info or {}).get("dataset_id", measured)):
        faults.append(f"{root / INFO}: dataset_id is {declared!s:.16}..., the content has {measured:.16}...")
    notes = () if checksums else (f"{root}: there is no dataset_info.json with checksums: files were not compared",)
    return Verdict(pairs=seen.pairs, files=len(checksums), faults=tuple(faults), dataset_id=measured, notes=notes)


def row_count(dataset: str | Path) -> int:
    """Count the rows of a data set."""
    return sum(1 for folder in split_folders(Path(dataset)) for _ in metadata_lines(folder))


def _measure(root: Path, names: set[str]) -> tuple[dict[str, str], dict[str, str]]:
    """Return the SHA-256 of each file that is there, and the fault of each that cannot be read, by their names."""
    content: dict[str, str] = {}
    faults: dict[str, str] = {}
    for name in sorted(names):
        try:
            if (root / name).is_file():
                content[name] = checksum(root / name)
        except OSError as error:
            faults[name] = f"{root / name}: cannot be read: {error.strerror}"
    return content, faults


def _wrong_files(root: Path, checksums: dict[str, str], content: dict[str, str]) -> Iterator[str]:
    """Yield the files that are not as ``dataset_info.json`` says, and those of which it says nothing."""
    for name, expected in checksums.items():
        if (actual := content.get(name)) is None:
            yield f"{root / name}: is missing"
        elif actual != expected:
            yield f"{root / name}: its SHA-256 is {actual[:12]}..., dataset_info.json has {expected[:12]}..."
    if checksums:
        yield from (f"{root / name}: is not in dataset_info.json" for name in sorted(content.keys() - checksums.keys()))


def _wrong_counts(root: Path, info: dict[str, Any] | None, folders: list[Path]) -> Iterator[str]:
    for split, expected in (info or {}).get("splits", {}).items():
        actual = sum(1 for folder in folders if folder.name == split for _ in metadata_lines(folder))
        if actual != expected["pairs"]:
            yield f"{root / split / METADATA}: has {actual} rows, dataset_info.json says {expected['pairs']}"


def _wrong_in_line(line: MetadataLine, folder: Path, suite: str, seen: _FirstUses) -> Iterator[str]:
    """Yield the faults of a row and its maps."""
    try:
        row = parse_row(line)
        pair = check_row(row, folder, suite, line.place).pair()
    except RectMergeError as error:
        yield str(error).removeprefix(f"{line.place}: ")
        return
    if (first := seen.pair_ids.setdefault(pair.pair_id, line.place)) != line.place:
        yield f"pair_id {pair.pair_id!r} is used in {first} too"
    for key in ("place", "world"):
        split, where = seen.buildings.setdefault(f"{key} {row.get(key)!r}", (folder.name, line.place))
        if row.get(key) and split != folder.name:
            yield f"{key} {row[key]!r} is in the split {split} too ({where})"
    for name in "ab":
        yield from _wrong_map(row, name, folder)
    if pair.pixels is not None and pair.control_points is not None:
        yield from _wrong_fit(pair.pixels, pair.control_points)
        yield from _wrong_frames(row.get("b_to_a"), pair, pair.pixels)
        if row.get("overlap") is not None:
            found = measure_agreement(pair.a, pair.b, pair.pixels).overlap
            if abs(found - row["overlap"]) > OVERLAP_WITHIN:
                yield f"overlap is {row['overlap']}, but under the truth the maps have {found:.4f}"


def _wrong_fit(pixels: Similarity, points: NDArray[np.float64]) -> Iterator[str]:
    try:
        fitted = Similarity.fit(points[:, 2:], points[:, :2])
    except InputError as error:
        yield f"control_points: {error}"
        return
    off = float(np.hypot(*(fitted.apply(points[:, 2:]) - pixels.apply(points[:, 2:])).T).max())
    if off > FIT_WITHIN_PX:
        yield f"pixels is not the least-squares fit to control_points: up to {off:.3f} pixels off"


def _wrong_frames(declared: Any, pair: MapPair, pixels: Similarity) -> Iterator[str]:
    """Check `b_to_a` if it is between the frames in which the maps are read."""
    if not isinstance(declared, dict) or declared.get("unit") != pair.a.unit:
        return
    try:
        b_to_a = Similarity(declared["scale"], declared["angle_rad"], *declared["translation"])
    except (KeyError, TypeError, InputError):
        yield f"b_to_a must have scale, angle_rad and translation, got {declared!r:.60}"
        return
    corners = pair.b.pixel_to_map([[0, 0], [pair.b.shape[1], pair.b.shape[0]]])
    off = b_to_a.apply(corners) - pixels_to_map_frame(pixels, pair.a, pair.b).apply(corners)
    if (cells := float(np.hypot(*off.T).max()) / pair.a.cell_size) > FIT_WITHIN_PX:
        yield f"b_to_a does not say what pixels says: up to {cells:.3f} cells off"


def _wrong_map(row: dict[str, Any], name: str, folder: Path) -> Iterator[str]:
    """Check the YAML of a map, which the row names or which has its image's name, and the building's raster."""
    image = folder / row[f"map_{name}_file_name"]
    header = folder / (row.get(f"map_{name}_yaml") or image.with_suffix(".yaml").relative_to(folder))
    if header.is_file():
        try:
            grid, shown = read_map(header), map_files(header)[1]
        except RectMergeError as error:
            yield f"map_{name}_yaml: {error}"
            return
        declared = row.get(f"resolution_{name}")
        if declared is not None and not _is_resolution(grid.resolution, declared):
            yield f"resolution_{name} is {declared}, {header.name} says {grid.resolution}"
        if shown.resolve() != image.resolve():
            yield f"{header.name} is of the image {shown.name}, not of {image.name}"
    if name == "a" and row.get("world"):
        try:
            read_map((folder / str(row["world"])).with_suffix(".yaml"))
        except RectMergeError as error:
            yield f"world: {error}"


def _is_resolution(resolution: float | None, declared: float) -> bool:
    """Return True if a map has the resolution that its row declares."""
    return resolution is not None and abs(resolution - declared) <= RESOLUTION_WITHIN * declared
