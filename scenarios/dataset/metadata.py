"""Rows of a data set: ``metadata.jsonl`` read line by line, every row checked, and made into a pair."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.errors import DatasetError, InputError
from rectmerge.io.atomic_file import resolve_links
from rectmerge.io.map_file import map_files, read_map
from rectmerge.similarity import Similarity
from scenarios.pairs.pair import MapPair
from scenarios.pairs.truth import control_point_rmse

METADATA = "metadata.jsonl"
RESIDUAL_WITHIN_PX = 0.05  # numbers in rows are rounded
RESIDUAL_WITHIN = 0.02  # of the residual
T = TypeVar("T")
_KNOWN = {
    *("pair_id", "map_a_file_name", "map_b_file_name", "related", "pixels", "control_points", "residual_px"),
    *("suite", "place", "overlap", "map_a_yaml", "map_b_yaml"),
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CheckedRow:
    """One row of a data set that keeps the layout; its maps are read when asked.

    The maps are read from the images that the row names, never from a YAML that merely lies beside them, so a method
    sees what the image tells: a resolution stays hidden, and is kept in the pair's `info` for reports. Where the row
    names a YAML by `map_a_yaml` or `map_b_yaml`, the resolution may be known, and the map is read by it.

    Parameters
    ----------
    folder
        The split's folder, which file names are relative to.
    map_a, map_b
        The files that the maps are read from.
    pair_id, related, pixels, control_points, residual_px, suite, place, overlap, info
        As in `MapPair`; `info` keeps every other key of the row.
    """

    folder: Path
    pair_id: str
    map_a: str
    map_b: str
    related: bool
    pixels: Similarity | None
    control_points: NDArray[np.float64] | None
    residual_px: float | None
    suite: str
    place: str
    overlap: float | None
    info: Mapping[str, Any] = field(default_factory=dict)

    def pair(self) -> MapPair:
        """Read the maps, and measure their overlap under the truth if the row has none.

        Raises
        ------
        MapFileError
            If one of them cannot be read.
        """
        for name in (self.map_a, self.map_b):
            for file in map_files(self.folder / name):
                _require_inside(file, self.folder)
        a, b = (read_map(self.folder / name) for name in (self.map_a, self.map_b))
        overlap = self.overlap
        if overlap is None and self.pixels is not None:
            overlap = measure_agreement(a, b, self.pixels).overlap
        return MapPair(
            pair_id=self.pair_id,
            a=a,
            b=b,
            related=self.related,
            pixels=self.pixels,
            control_points=self.control_points,
            residual_px=self.residual_px,
            suite=self.suite,
            place=self.place,
            overlap=overlap,
            info=self.info,
        )


class MetadataLine(NamedTuple):
    """A line of a file: its start, in bytes; its place, as ``file:line``; and its text."""

    start: int
    place: str
    text: str


def metadata_lines(folder: Path) -> Iterator[MetadataLine]:
    """Read the lines of a split that are not empty.

    Raises
    ------
    DatasetError
        If they cannot be read.
    """
    path, start = folder / METADATA, 0
    try:
        with path.open("rb") as lines:
            for number, line in enumerate(lines, start=1):
                if line.strip():
                    yield MetadataLine(start, f"{path}:{number}", line.decode())
                start += len(line)
    except (OSError, UnicodeDecodeError) as error:
        raise DatasetError(f"{path}: cannot be read: {error}") from error


def line_at(folder: Path, start: int) -> MetadataLine:
    """Read the line of a split that begins at a byte.

    Raises
    ------
    DatasetError
        If it cannot be read.
    """
    path = folder / METADATA
    try:
        with path.open("rb") as lines:
            lines.seek(start)
            return MetadataLine(start, f"{path}, byte {start}", lines.readline().decode())
    except (OSError, UnicodeDecodeError) as error:
        raise DatasetError(f"{path}: cannot be read: {error}") from error


def parse_row(line: MetadataLine) -> dict[str, Any]:
    """Parse a row; an error names the line and the reason."""
    try:
        row = json.loads(line.text)
    except (ValueError, RecursionError) as error:
        raise DatasetError(f"{line.place}: not JSON: {error}") from error
    if not isinstance(row, dict):
        raise DatasetError(f"{line.place}: a row is an object, got {type(row).__name__}")
    return row


def check_row(row: dict[str, Any], folder: Path, suite: str, place: str) -> CheckedRow:
    """Check a row's layout; an error names the line and the reason.

    Parameters
    ----------
    row
        As it was read.
    folder
        The split's folder.
    suite
        The data set's name, for rows that tell no suite.
    place
        ``file:line``, for messages.

    Raises
    ------
    DatasetError
        If the row does not keep the layout.
    """
    try:
        related = _typed(row, "related", bool)
        _check_resolutions(row)
        pixels, points, residual = _truth(row) if related else _no_truth(row)
        images = {name: _map_file(row, f"map_{name}_file_name", folder) for name in "ab"}
        known = {name: f"map_{name}_yaml" for name in "ab" if row.get(f"map_{name}_yaml")}
        maps = images | {name: _map_file(row, key, folder) for name, key in known.items()}
        return CheckedRow(
            folder=folder,
            pair_id=_typed(row, "pair_id", str),
            map_a=maps["a"],
            map_b=maps["b"],
            related=related,
            pixels=pixels,
            control_points=points,
            residual_px=residual,
            suite=str(row.get("suite") or suite),
            place=str(row.get("place") or row["pair_id"]),
            overlap=_overlap(row),
            info={"split": folder.resolve().name, **{key: value for key, value in row.items() if key not in _KNOWN}},
        )
    except InputError as error:
        raise DatasetError(f"{place}: {error}") from error


def _require_inside(file: Path, folder: Path) -> None:
    """Refuse a file that a link or a YAML places outside the split's folder: a data set is whole in itself."""
    if not resolve_links(file).is_relative_to(resolve_links(folder)):
        raise DatasetError(f"{file} leads out of the data set, to {resolve_links(file)}")


def _typed(row: dict[str, Any], key: str, kind: type[T]) -> T:
    if key not in row:
        raise DatasetError(f"{key} is missing")
    value = row[key]
    if not isinstance(value, kind):
        raise DatasetError(f"{key} must be of type {kind.__name__}, got {value!r:.60}")
    return value


def _truth(row: dict[str, Any]) -> tuple[Similarity, NDArray[np.float64], float]:
    pixels = Similarity.from_matrix(_numbers(row, "pixels", (2, 3)))
    points = _numbers(row, "control_points", (-1, 4))
    residual = float(_numbers(row, "residual_px", ()))
    rmse = control_point_rmse(pixels.matrix, points)
    if not math.isclose(rmse, residual, rel_tol=RESIDUAL_WITHIN, abs_tol=RESIDUAL_WITHIN_PX):
        raise DatasetError(f"residual_px is {residual}, but pixels leave {rmse:.3f} on the control points")
    return pixels, points, residual


def _no_truth(row: dict[str, Any]) -> tuple[None, None, None]:
    for key in ("pixels", "control_points", "residual_px"):
        if row.get(key) is not None:
            raise DatasetError(f"{key} must be null where related is false")
    return None, None, None


def _numbers(row: dict[str, Any], key: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Read finite numbers of a shape; -1 stands for two or more."""
    wanted = "a number" if not shape else f"numbers of shape ({', '.join('N' if s < 0 else str(s) for s in shape)})"
    try:
        array = np.asarray(row[key], dtype=np.float64)
    except KeyError:
        raise DatasetError(f"{key} is missing") from None
    except (TypeError, ValueError, OverflowError):
        raise DatasetError(f"{key} must be {wanted}, got {row[key]!r:.60}") from None
    fits = array.ndim == len(shape) and all(
        n == s or (s < 0 and n >= 2) for n, s in zip(array.shape, shape, strict=True)
    )
    if not fits or not np.isfinite(array).all():
        raise DatasetError(f"{key} must be finite {wanted}, got shape {array.shape}")
    return array


def _check_resolutions(row: dict[str, Any]) -> None:
    for key in ("resolution_a", "resolution_b"):
        if row.get(key) is not None and float(_numbers(row, key, ())) <= 0:
            raise DatasetError(f"{key} must be > 0 metres per cell or null, got {row[key]}")


def _overlap(row: dict[str, Any]) -> float | None:
    if row.get("overlap") is None:
        return None
    overlap = float(_numbers(row, "overlap", ()))
    if not 0 <= overlap <= 1:
        raise DatasetError(f"overlap must lie in 0..1, got {overlap}")
    return overlap


def _map_file(row: dict[str, Any], key: str, folder: Path) -> str:
    """Read a file name, which must stay inside the split's folder and exist."""
    name = _typed(row, key, str)
    if PurePosixPath(name).is_absolute() or ".." in PurePosixPath(name).parts:
        raise DatasetError(f"{key} must stay inside the data set, got {name!r}")
    if not (folder / name).is_file():
        raise DatasetError(f"{key}: there is no file {name!r}")
    _require_inside(folder / name, folder)
    return name
