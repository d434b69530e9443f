"""Map files: ROS map_server YAML with its PGM or PNG, maps in bags, and plain images with inferred grey levels."""

from __future__ import annotations

import logging
import os
from dataclasses import replace
from pathlib import Path, PureWindowsPath
from typing import NamedTuple

import numpy as np
import yaml

from rectmerge.errors import InputError, MapFileError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid, unusable
from rectmerge.io.atomic_file import replace_files
from rectmerge.io.bag_file import bag_files, is_bag, read_bag_map
from rectmerge.io.dialects import UNKNOWN_GREY, WHITE, Dialect, Legend, grey_levels, occupancy_table, read_cells
from rectmerge.io.grey_levels import Levels, infer_levels
from rectmerge.io.image_file import OPAQUE, WRITABLE, Pixels, encode_image, read_pixels
from rectmerge.io.map_yaml import read_header

YAML_SUFFIXES = (".yaml", ".yml")
FREE_GREY = 254  # as map savers write it
CARTOGRAPHERS_WORD = b"# Cartographer map"  # the second line of the images it writes
MAP_SAVERS = Legend()  # what map_saver writes
LOGGER = logging.getLogger("rectmerge")


class PlainMap(NamedTuple):
    """A map read from a plain image, with the grey levels it was read by."""

    grid: OccupancyGrid
    levels: Levels


def is_yaml(path: str | os.PathLike[str]) -> bool:
    """Whether a file is read as a map_server YAML rather than as a plain image: by its suffix."""
    return Path(path).suffix.lower() in YAML_SUFFIXES


def map_files(path: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Return the files that a map is read from: a YAML and its image, a bag's, or the plain image alone.

    Raises
    ------
    MapFileError
        If a YAML cannot be read.
    """
    if is_bag(path):
        return bag_files(path)
    return (Path(path), read_header(Path(path)).image) if is_yaml(path) else (Path(path),)


def read_map(
    path: str | os.PathLike[str],
    *,
    free: int | None = None,
    occupied: int | None = None,
    unknown: int | None = None,
    dialect: Dialect | None = None,
    strict_thresholds: bool = False,
) -> OccupancyGrid:
    """Read a map: a ROS map_server YAML with its image, a plain image, or the newest map on a topic of a ROS bag.

    Parameters
    ----------
    path
        A ``.yaml`` or ``.yml``, or an image. An image is read by itself, even if a YAML lies beside it: its
        resolution is then not known (None). Or ``run.mcap:/robot1/map``, as `rectmerge.io.bag_file.read_bag_map` has
        it.
    free, occupied, unknown
        Grey levels of a plain image, 0..255, where the guess of `rectmerge.io.grey_levels.infer_levels` is wrong.
    dialect
        By whose rules the image of a YAML is read, see `rectmerge.io.dialects.occupancy_table`; None is "nav2", and
        "cartographer" for an image that says it is Cartographer's.
    strict_thresholds
        Take a YAML at its word even where it turns unknown space free, see Notes.

    Raises
    ------
    MapFileError
        If the file cannot be read as a map, or has no free cell; the message names the file and the remedy.

    Notes
    -----
    Modes trinary, scale and raw, as nav2_map_server reads them; `rectmerge.io.dialects` says what its earlier versions,
    map_server of ROS 1 and Cartographer do otherwise. ``resolution: null`` is read as a resolution that is not known.

    The map savers of nav2 wrote ``free_thresh: 0.25`` for years beside grey 205 for unknown, which by that threshold is
    free: (255 - 205) / 255 = 0.196. Where 205 would turn free in an image that has the savers' free grey, 254, and no
    shades beside 205, it stays unknown, and the logger `rectmerge` warns.
    """
    if not is_yaml(path) and not is_bag(path):
        return read_image(path, free=free, occupied=occupied, unknown=unknown).grid
    if any(level is not None for level in (free, occupied, unknown)):
        how = "a YAML tells them by its thresholds" if is_yaml(path) else "a bag holds cells"
        raise MapFileError(f"{path}: grey levels are for plain images; {how}")
    if is_bag(path):
        return read_bag_map(path)
    return _read_yaml_map(Path(path), dialect, strict_thresholds=strict_thresholds)


def read_image(
    path: str | os.PathLike[str],
    *,
    free: int | None = None,
    occupied: int | None = None,
    unknown: int | None = None,
) -> PlainMap:
    """Read a plain image as `read_map` does, and return the grey levels as well; transparent pixels are unknown."""
    pixels = _checked_size(Path(path), read_pixels(Path(path)))
    grey = np.rint(np.arange(pixels.full + 1) * (255.0 / pixels.full)).astype(np.uint8)[pixels.values]
    try:
        levels = infer_levels(grey, free=free, occupied=occupied, unknown=unknown, seen=pixels.opaque)
    except InputError as error:
        raise MapFileError(f"{path}: {error}; name the levels with --free, --occupied and --unknown") from None
    occupancy = levels.classify(grey)
    if pixels.opaque is not None:
        occupancy[~pixels.opaque] = UNKNOWN
    return PlainMap(_checked(Path(path), OccupancyGrid(occupancy), f"read with {levels}"), levels)


def write_map(
    grid: OccupancyGrid, path: str | os.PathLike[str], *, image_suffix: str = ".pgm", legend: Legend = MAP_SAVERS
) -> None:
    """Write a map as map_saver does: the YAML `path` and an image of the same name beside it.

    Parameters
    ----------
    grid
        The map.
    path
        A ``.yaml``; its image gets the same stem. Both appear whole, the YAML last.
    image_suffix
        ".pgm" or ".png"; mode scale needs ".png" where cells are unknown.
    legend
        Mode, thresholds and negate of the file, such as those of a map that was read (`mapheader.read_header`).
        In mode trinary, the default, a trinary map (-1, 0, 100) is read back bit for bit and other values become free,
        occupied or unknown; modes scale and raw keep every value.

    Raises
    ------
    MapFileError
        If the name is not a YAML's, the legend has no grey for what the map holds, or the files cannot be written.

    Notes
    -----
    Where the resolution is not known the YAML says ``null``, which map_server refuses, rather than a false 1.0.
    """
    target = Path(path)
    if not is_yaml(target):
        raise MapFileError(f"{path}: a map is written under a name that ends in .yaml")
    if image_suffix not in WRITABLE:
        raise MapFileError(f"{path}: image_suffix must be one of {', '.join(WRITABLE)}, got {image_suffix!r}")
    image = target.with_suffix(image_suffix)
    try:
        pixels, header = encode_map(grid, image.name, legend)
    except InputError as error:
        raise MapFileError(f"{path}: {error}") from None
    replace_files({image: pixels, target: header})


def has_shades(grid: OccupancyGrid) -> bool:
    """Whether a map holds occupancies between free and occupied, which mode trinary cannot keep."""
    return bool(((grid.occupancy > FREE) & (grid.occupancy < OCCUPIED)).any())


def encode_map(grid: OccupancyGrid, image_name: str, legend: Legend = MAP_SAVERS) -> tuple[bytes, bytes]:
    """Return the bytes of a map's image and of its YAML, as `write_map` writes them.

    Parameters
    ----------
    grid
        The map.
    image_name
        What the YAML calls the image; its suffix, ".pgm" or ".png", says how it is encoded.
    legend
        As in `write_map`.
    """
    pixels = grey_levels(legend)[grid.occupancy]  # -1, unknown, is the last
    if legend.mode == "scale" and grid.unknown.any():
        if Path(image_name).suffix != ".png":
            raise InputError("mode scale tells unknown cells by transparency, so its image must be a .png")
        pixels = np.dstack([pixels, np.where(grid.occupancy == UNKNOWN, 0, OPAQUE).astype(np.uint8)])
    keys = {
        "image": image_name,
        "mode": legend.mode,
        "resolution": grid.resolution,
        "origin": list(grid.origin),
        "negate": int(legend.negate),
        "occupied_thresh": legend.occupied_thresh,
        "free_thresh": legend.free_thresh,
    }
    note = "# resolution not known: origin is in cells\n" if grid.resolution is None else ""
    header = note + yaml.safe_dump(keys, sort_keys=False, default_flow_style=None)
    return encode_image(pixels, Path(image_name).suffix), header.encode()


def _read_yaml_map(path: Path, dialect: Dialect | None, *, strict_thresholds: bool) -> OccupancyGrid:
    header = read_header(path)
    try:
        pixels = _checked_size(header.image, read_pixels(header.image))
    except MapFileError as error:
        raise MapFileError(f"{path}: its image {error}{_found_beside(path, header.image)}") from None
    dialect = dialect or _told_dialect(path, header.image)
    keep = not strict_thresholds and _turns_unknown_free(header.legend, pixels, dialect)
    if keep:
        LOGGER.warning(
            "%s: %sfree_thresh %g would turn grey 205, which map savers write for unknown, into free space; it is kept "
            "unknown (--strict-thresholds obeys the file, %s mends it)",
            path,
            "mode scale with " if header.legend.mode == "scale" else "",
            header.legend.free_thresh,
            _mending(header.legend, dialect),
        )
    occupancy = read_cells(pixels, header.legend, dialect, keep=keep)
    try:
        grid = OccupancyGrid(occupancy, header.resolution, header.origin)
    except InputError as error:
        raise MapFileError(f"{path}: {error}") from None
    return _checked(path, grid, "check negate, free_thresh and occupied_thresh")


def _found_beside(path: Path, image: Path) -> str:
    """Tell of a file beside a YAML that has the name of its missing image: maps are copied without their folder."""
    beside = path.with_name(PureWindowsPath(image).name or path.name)  # either kind of slash
    if os.path.lexists(image) or beside == path or not os.path.isfile(beside):  # noqa: PTH113 - no error, any name
        return ""
    return f"; {beside.name} lies beside the YAML: if it is the map's, write image: {beside.name}"


def _mending(legend: Legend, dialect: Dialect) -> str:
    """Say what in a YAML turns grey 205 back into unknown space."""
    savers = replace(legend, free_thresh=MAP_SAVERS.free_thresh)
    if occupancy_table(savers, dialect)[UNKNOWN_GREY] != FREE:
        return f"free_thresh: {savers.free_thresh:g}"
    return f"mode: trinary with free_thresh: {savers.free_thresh:g}"


def _told_dialect(path: Path, image: Path) -> Dialect:
    """Return the dialect that an image itself tells."""
    with image.open("rb") as file:
        if CARTOGRAPHERS_WORD not in file.read(len(CARTOGRAPHERS_WORD) + 8):
            return "nav2"
    LOGGER.info("%s: Cartographer's image: grey is read as probability (--dialect nav2 goes by thresholds)", path)
    return "cartographer"


def _turns_unknown_free(legend: Legend, pixels: Pixels, dialect: Dialect) -> bool:
    """Tell the known trap: the savers' grey for unknown read as free beside the grey that they write for free."""
    if legend.mode == "raw" or legend.negate or dialect == "cartographer":
        return False
    if occupancy_table(legend, dialect)[UNKNOWN_GREY] != FREE:
        return False
    opaque = pixels.luma if pixels.alpha is None else pixels.luma[pixels.alpha == OPAQUE]
    is_there = np.bincount(opaque.ravel(), minlength=WHITE + 1) > 0
    is_level = not is_there[[UNKNOWN_GREY - 1, UNKNOWN_GREY + 1]].any()  # and no shade among others
    return bool(is_there[UNKNOWN_GREY] and is_there[FREE_GREY] and is_level)


def _checked_size(path: Path, pixels: Pixels) -> Pixels:
    height, width = pixels.values.shape
    if min(height, width) < 2:
        raise MapFileError(f"{path}: {width} x {height} pixels are no map; give the whole image")
    return pixels


def _checked(path: Path, grid: OccupancyGrid, remedy: str) -> OccupancyGrid:
    """Refuse a map that nothing can be aligned with."""
    if why := unusable(grid):
        raise MapFileError(f"{path}: {why}; {remedy}")
    return grid
