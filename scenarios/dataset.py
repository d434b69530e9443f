"""Data sets of map pairs on disk: ``DATASET/{train,test}/metadata.jsonl`` and its maps, every row checked."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import DatasetError, InputError
from rectmerge.overlap import measure_agreement
from rectmerge.similarity import Similarity
from scenarios.pairs import MapPair, PairSource
from scenarios.truth import control_point_rmse

SPLITS = ("train", "test")
METADATA = "metadata.jsonl"
RESIDUAL_WITHIN_PX = 0.05  # numbers in rows are rounded
RESIDUAL_WITHIN = 0.02  # of the residual
T = TypeVar("T")
_KNOWN = {
    *("pair_id", "map_a_file_name", "map_b_file_name", "related", "pixels", "control_points", "residual_px"),
    *("suite", "place", "overlap", "map_a_yaml", "map_b_yaml"),
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RowSource:
    """One checked row of a data set; its maps are read when asked.

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

    @property
    def source_id(self) -> str:
        """The pair's id."""
        return self.pair_id

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """The one pair of the row."""
        return (self.pair_id,)

    def pairs(self) -> Iterator[MapPair]:
        """Read the maps, and measure their overlap under the truth where the row does not tell it.

        Raises
        ------
        MapFileError
            If one of them cannot be read.
        """
        from rectmerge.mapfile import read_map

        a, b = (read_map(self.folder / name) for name in (self.map_a, self.map_b))
        overlap = self.overlap
        if overlap is None and self.pixels is not None:
            overlap = measure_agreement(a, b, self.pixels).overlap
        yield MapPair(
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


def is_dataset(path: str | Path) -> bool:
    """Say whether a path is a data set, or one split of it."""
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
        for place, row in metadata_rows(folder / METADATA):
            source = checked_row(row, folder, suite, place)
            if source.pair_id in sources:
                raise DatasetError(f"{place}: pair_id {source.pair_id!r} is used twice")
            sources[source.pair_id] = source
    if not sources:
        raise DatasetError(f"{root}: the data set has no rows")
    return list(sources.values())


def split_folders(root: Path, split: str | None = None) -> list[Path]:
    """Return the folders that hold rows: of a data set, or of one split of it."""
    folders = [root / split] if split else [root, *(root / name for name in SPLITS)]
    return [folder for folder in folders if (folder / METADATA).is_file()]


def metadata_rows(path: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Read rows with their place, as ``file:line``.

    Raises
    ------
    DatasetError
        If the file cannot be read, or a line is no JSON object.
    """
    for place, line in metadata_lines(path):
        yield place, parsed_row(line, place)


def metadata_lines(path: Path) -> Iterator[tuple[str, str]]:
    """Read the lines that are not empty with their place, as ``file:line``."""
    try:
        with path.open(encoding="utf-8", newline="\n") as lines:
            for number, line in enumerate(lines, start=1):
                if line.strip():
                    yield f"{path}:{number}", line
    except (OSError, UnicodeDecodeError) as error:
        raise DatasetError(f"{path}: cannot be read: {error}") from error


def parsed_row(line: str, place: str) -> dict[str, Any]:
    """Parse a row, or say where and why it is none."""
    try:
        row = json.loads(line)
    except ValueError as error:
        raise DatasetError(f"{place}: not JSON: {error}") from error
    if not isinstance(row, dict):
        raise DatasetError(f"{place}: a row is an object, got {type(row).__name__}")
    return row


def checked_row(row: dict[str, Any], folder: Path, suite: str, place: str) -> RowSource:
    """Turn a row into a source, or say where and why not.

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
        return RowSource(
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
    except (TypeError, ValueError):
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
    return name
