"""Packing of a source's pairs as files and rows of a data set, in the process that makes them."""

from __future__ import annotations

import functools
import hashlib
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
from PIL import Image

from rectmerge.errors import InputError, MapFileError, SimulationError
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.io.grey_levels import infer_levels
from rectmerge.io.json_text import plain
from rectmerge.io.map_file import encode_map
from scenarios.dataset.reader import SPLITS
from scenarios.dataset.rosbag import BagForm, encode_bag
from scenarios.execution.attempt import Attempt, attempt
from scenarios.execution.limits import Limits, call_within
from scenarios.pairs.pair import MapPair, MissionPairs, PairInputs, PairSource
from scenarios.pairs.truth import control_point_rmse
from scenarios.scoring.score import Outcome
from sim.missions.mission_log import MissionLog

MetadataRow = dict[str, Any]
WORLD_M = 0.05  # metres per cell of a building's raster
POINT_DIGITS, MATRIX_DIGITS, DIGITS = 3, 9, 6  # of control points in cells, of `pixels`, of everything else
EXACT = ("resolution_a", "resolution_b")  # kept to the last digit: the YAML tells the same


@runtime_checkable
class Explorer(Protocol):
    """A source of pairs that runs missions, whose building is known."""

    def mission_pairs(self) -> MissionPairs:
        """Run the mission and make its pairs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Package:
    """Files and rows that a source adds to a data set. Picklable.

    Parameters
    ----------
    source_id
        The source.
    rows
        One per pair, each with its `split`.
    files
        By path in the data set.
    discarded
        Why tries at its mission came to nothing.
    failed
        Pairs that could not be made, with the reason.
    """

    source_id: str
    rows: list[MetadataRow] = field(default_factory=list)
    files: dict[str, bytes] = field(default_factory=dict)
    discarded: list[str] = field(default_factory=list)
    failed: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class MadePairs:
    """Pairs of a source, and their package. Picklable.

    Parameters
    ----------
    pairs
        Those that can be kept where they are to be kept, and else all.
    package
        Without rows and files where nothing is to be kept; the reasons why pairs are missing it always has.
    failure, log
        What kind of failure the missing pairs are, and its traceback.
    """

    pairs: list[MapPair] = field(default_factory=list)
    package: Package
    failure: Outcome = "error"
    log: str | None = None


def make_within(
    limits: Limits, source: PairSource, first: int | None, count: int | None = None, *, bags: BagForm | None = None
) -> MadePairs:
    """Make the pairs of a source; missions run in a child process, which is killed if it exceeds its limits.

    Parameters
    ----------
    limits
        What a mission and its pairs may take.
    source, first, count, bags
        As `make` has them.
    """
    if not isinstance(source, Explorer):
        return make(source, first, count, bags=bags)
    tried = call_within(limits, functools.partial(make, source, first, count, bags=bags), does="makes pairs")
    return tried.value or failed_source(source, tried, count)


def failed_source(source: PairSource, tried: Attempt[Any], count: int | None = None) -> MadePairs:
    """Return the package of a source none of whose pairs could be made."""
    failed = dict.fromkeys(source.pair_ids[:count], tried.reason)
    package = Package(source_id=source.source_id, failed=failed)
    return MadePairs(package=package, failure=tried.failure or "error", log=tried.log)


def make(source: PairSource, first: int | None, count: int | None = None, *, bags: BagForm | None = None) -> MadePairs:
    """Make the pairs of a source and pack them; `failed` names the pairs that could not be made.

    Parameters
    ----------
    source
        Where the pairs come from.
    first
        The number of its first pair, after which files are named; None is nothing to be kept.
    count
        How many of its pairs are wanted; None is all.
    bags
        Form in which a pair is kept as a ROS bag, too, only of missions; None is no bag.
    """
    pairs: list[MapPair] = []
    package = Package(source_id=source.source_id)
    tried = attempt(functools.partial(_make, source, first, count, pairs, package, bags=bags))
    made, reason = {pair.pair_id for pair in pairs}, tried.reason or "its source ended without it"
    missing = (pair_id for pair_id in source.pair_ids[:count] if pair_id not in made)
    package.failed.update({pair_id: package.failed.get(pair_id, reason) for pair_id in missing})
    return MadePairs(pairs=pairs, package=package, failure=tried.failure or "error", log=tried.log)


def _make(
    source: PairSource,
    first: int | None,
    count: int | None,
    pairs: list[MapPair],
    package: Package,
    *,
    bags: BagForm | None,
) -> None:
    """Add pairs to those that were made, each when it is packed."""
    found: Sequence[MapPair] = ()
    log: MissionLog | None = None
    inputs: Mapping[str, PairInputs] = {}
    if isinstance(source, Explorer):
        explored = source.mission_pairs()
        package.discarded.extend(explored.log.discarded)
        wanted = source.pair_ids[:count]
        package.failed.update({pair_id: why for pair_id, why in explored.failed.items() if pair_id in wanted})
        found, log = [pair for pair in explored.pairs if pair.pair_id in wanted], explored.log
        inputs = explored.inputs
    for pair in islice(source.pairs(), count) if log is None else found:
        if pair.pair_id not in source.pair_ids:
            raise InputError(f"{pair.pair_id!r} is not in the pairs of {source.source_id}")
        if first is not None:
            number = first + source.pair_ids.index(pair.pair_id)
            row, files = _packed(pair, number, log)
            if bags:
                row["bag"], bag = _bag(pair, number, inputs.get(pair.pair_id), bags)
                files |= {f"{row['split']}/{path}": data for path, data in bag.items()}
            package.files.update(files)
            package.rows.append(row)
        pairs.append(pair)


def _packed(pair: MapPair, number: int, log: MissionLog | None) -> tuple[MetadataRow, dict[str, bytes]]:
    """Return the row and the files of a pair."""
    split = str(pair.info.get("split") or "test")
    if split not in SPLITS:
        raise SimulationError(f"{pair.pair_id}: split must be one of {', '.join(SPLITS)}, got {split!r}")
    row: MetadataRow = {"pair_id": pair.pair_id}
    files: dict[str, bytes] = {}
    stems = pair.files or (f"{number:06d}_a", f"{number:06d}_b")
    for name, stem, grid in zip("ab", stems, (pair.a, pair.b), strict=True):
        path = f"maps/{stem}"
        image, header = _encoded(grid, f"{stem}.png")
        row[f"map_{name}_file_name"], row[f"map_{name}_yaml"] = f"{path}.png", ""
        files[f"{split}/{path}.png"] = image
        if grid.resolution is not None:
            row[f"map_{name}_yaml"], files[f"{split}/{path}.yaml"] = f"{path}.yaml", header
    row |= {**_truth(pair), **_about(pair), "split": split}
    if log is not None:
        row["world"], raster = _building(log)
        files |= {f"{split}/{path}": data for path, data in raster.items()}
    return row, files


def _bag(pair: MapPair, number: int, made: PairInputs | None, form: BagForm) -> tuple[str, dict[str, bytes]]:
    """Write a pair's mission as a bag, by path in its split; empty if no robots can have made the pair."""
    if made is None:
        return "", {}
    folder = f"bags/{number:06d}"
    files = encode_bag(pair, made, f"{number:06d}", form=form)
    named = f"{folder}/{number:06d}.bag" if form == "rosbag1" else folder
    return named, {f"{folder}/{name}": data for name, data in files.items()}


def _truth(pair: MapPair) -> MetadataRow:
    """Return the truth, rounded, with the residual of the rounded numbers."""
    empty = dict.fromkeys(("pixels", "control_points", "residual_px", "b_to_a"))
    if pair.pixels is None or pair.control_points is None:
        return {"related": pair.related, **empty, "overlap": pair.overlap}
    matrix, points = pair.pixels.matrix.round(MATRIX_DIGITS), pair.control_points.round(POINT_DIGITS)
    b_to_a = pixels_to_map_frame(pair.pixels, pair.a, pair.b)
    return {
        "related": pair.related,
        "pixels": matrix.tolist(),
        "control_points": points.tolist(),
        "residual_px": round(control_point_rmse(matrix, points), DIGITS),
        "b_to_a": {
            "scale": round(b_to_a.scale, MATRIX_DIGITS),
            "angle_rad": round(b_to_a.angle, MATRIX_DIGITS),
            "translation": [round(b_to_a.tx, DIGITS), round(b_to_a.ty, DIGITS)],
            "unit": pair.a.unit,
        },
        "overlap": None if pair.overlap is None else round(float(pair.overlap), DIGITS),
    }


def _about(pair: MapPair) -> MetadataRow:
    info: Mapping[str, Any] = plain(pair.info)
    rounded = {key: value if key in EXACT else _rounded(value) for key, value in info.items()}
    return {"suite": pair.suite, "place": pair.place, **rounded}


def _rounded(value: Any) -> Any:
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    return round(value, DIGITS) if isinstance(value, float) else value


def _encoded(grid: OccupancyGrid, image_name: str) -> tuple[bytes, bytes]:
    """Encode a map as a PNG and a YAML.

    Raises
    ------
    MapFileError
        If the image alone does not tell the cells as they are.
    """
    image, header = encode_map(grid, image_name)
    grey = np.asarray(Image.open(io.BytesIO(image)))
    if not np.array_equal(infer_levels(grey).classify(grey), grid.occupancy):
        raise MapFileError(f"{image_name}: what its grey levels mean cannot be told from the image alone")
    return image, header


def _building(log: MissionLog) -> tuple[str, dict[str, bytes]]:
    """Draw the building of a mission at the height of A's laser, under a name that tells buildings apart."""
    raster = log.world.raster(WORLD_M, height_m=log.spec.a.lidar.height_m)
    digest = hashlib.sha256(str(raster.shape).encode() + raster.occupancy.tobytes()).hexdigest()[:12]
    stem = f"worlds/{log.world.family or 'world'}-{digest}"
    image, header = encode_map(raster, f"{Path(stem).name}.png")
    return f"{stem}.png", {f"{stem}.png": image, f"{stem}.yaml": header}
