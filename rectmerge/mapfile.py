"""Map files: ROS map_server YAML with its PGM or PNG, and plain images whose grey levels are inferred."""

from __future__ import annotations

import logging
import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from numpy.typing import NDArray

from rectmerge.errors import InputError, MapFileError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.imagefile import WRITABLE, Pixels, encode_image, read_pixels, replace_file
from rectmerge.levels import Levels, infer_levels
from rectmerge.mapheader import MapHeader, read_header

YAML_SUFFIXES = (".yaml", ".yml")
FREE_GREY, UNKNOWN_GREY, OCCUPIED_GREY = 254, 205, 0  # as map_saver writes them
FULL_GREY = 255
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
LOGGER = logging.getLogger("rectmerge")


class PlainMap(NamedTuple):
    """A map read from a plain image, with the grey levels it was read by."""

    grid: OccupancyGrid
    levels: Levels


def is_yaml(path: str | os.PathLike[str]) -> bool:
    """Whether a file is read as a map_server YAML rather than as a plain image: by its suffix."""
    return Path(path).suffix.lower() in YAML_SUFFIXES


def map_files(path: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Return the files that a map is read from: a YAML and its image, or the plain image alone.

    Raises
    ------
    MapFileError
        If a YAML cannot be read.
    """
    return (Path(path), read_header(Path(path)).image) if is_yaml(path) else (Path(path),)


def read_map(
    path: str | os.PathLike[str],
    *,
    free: int | None = None,
    occupied: int | None = None,
    unknown: int | None = None,
    strict_thresholds: bool = False,
) -> OccupancyGrid:
    """Read a map: a ROS map_server YAML with its image, or a plain image.

    Parameters
    ----------
    path
        A ``.yaml`` or ``.yml``, or an image. An image is read by itself, even if a YAML lies beside it: its
        resolution is then not known (None).
    free, occupied, unknown
        Grey levels of a plain image, 0..255, where the guess of `rectmerge.levels.infer_levels` is wrong.
    strict_thresholds
        Take a YAML at its word even where it turns unknown space free, see Notes.

    Raises
    ------
    MapFileError
        If the file cannot be read as a map, or has no free cell; the message names the file and the remedy.

    Notes
    -----
    Follows map_server 1.17 (image_loader.cpp) in its modes trinary, scale and raw. Departs from it: an alpha channel
    is not averaged with the colours (opaque grey 205 would turn free); in scale mode it still marks unknown cells.
    ``resolution: null`` is read as a resolution that is not known.

    The map savers of nav2 wrote ``free_thresh: 0.25`` for years beside grey 205 for unknown, which by that threshold is
    free: (255 - 205) / 255 = 0.196. Where 205 would turn free in an image that has the savers' free grey, 254, and no
    shades beside 205, it stays unknown, and the logger `rectmerge` warns.
    """
    if not is_yaml(path):
        return read_image(path, free=free, occupied=occupied, unknown=unknown).grid
    if any(level is not None for level in (free, occupied, unknown)):
        raise MapFileError(f"{path}: grey levels are for plain images; a YAML tells them by its thresholds")
    return _read_yaml_map(Path(path), strict_thresholds=strict_thresholds)


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


def write_map(grid: OccupancyGrid, path: str | os.PathLike[str], *, image_suffix: str = ".pgm") -> None:
    """Write a map as map_saver does in trinary mode: the YAML `path` and an image of the same name beside it.

    Parameters
    ----------
    grid
        The map. A trinary map (-1, 0, 100) is read back bit for bit; other values become free, occupied or unknown.
    path
        A ``.yaml``; its image gets the same stem. Both appear whole, the YAML last.
    image_suffix
        ".pgm" or ".png".

    Raises
    ------
    MapFileError
        If the name is not a YAML's, or the files cannot be written.

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
    pixels, header = encode_map(grid, image.name)
    replace_file(image, pixels)
    replace_file(target, header)


def encode_map(grid: OccupancyGrid, image_name: str) -> tuple[bytes, bytes]:
    """Return the bytes of a map's image and of its YAML, as `write_map` writes them.

    Parameters
    ----------
    grid
        The map.
    image_name
        What the YAML calls the image; its suffix, ".pgm" or ".png", says how it is encoded.
    """
    grey = np.where(grid.free, FREE_GREY, np.where(grid.occupied, OCCUPIED_GREY, UNKNOWN_GREY)).astype(np.uint8)
    keys = {
        "image": image_name,
        "mode": "trinary",
        "resolution": grid.resolution,
        "origin": list(grid.origin),
        "negate": 0,
        "occupied_thresh": OCCUPIED_THRESH,
        "free_thresh": FREE_THRESH,
    }
    note = "# resolution not known: origin is in cells\n" if grid.resolution is None else ""
    header = note + yaml.safe_dump(keys, sort_keys=False, default_flow_style=None)
    return encode_image(grey, Path(image_name).suffix), header.encode()


def _read_yaml_map(path: Path, *, strict_thresholds: bool) -> OccupancyGrid:
    header = read_header(path)
    try:
        pixels = _checked_size(header.image, read_pixels(header.image))
    except MapFileError as error:
        raise MapFileError(f"{path}: its image {error}") from None
    table = _occupancy_table(header, pixels.full)
    if not strict_thresholds and _turns_unknown_free(header, pixels, table):
        table[UNKNOWN_GREY] = UNKNOWN
        LOGGER.warning(
            "%s: free_thresh %g would turn grey 205, which map savers write for unknown, into free space; it is kept "
            "unknown (--strict-thresholds obeys the file, free_thresh: 0.196 mends it)",
            path,
            header.free_thresh,
        )
    occupancy = table[pixels.values]
    if header.mode == "scale" and pixels.opaque is not None:
        occupancy[~pixels.opaque & (occupancy > FREE) & (occupancy < OCCUPIED)] = UNKNOWN
    grid = OccupancyGrid(occupancy, header.resolution, header.origin)
    return _checked(path, grid, "check negate, free_thresh and occupied_thresh")


def _occupancy_table(header: MapHeader, full: int) -> NDArray[np.int8]:
    """Return what each pixel value means, shape (full + 1,), with map_server's arithmetic."""
    grey = np.arange(full + 1) * 255.0 / full
    if header.negate:
        grey = 255.0 - grey
    if header.mode == "raw":
        return np.where(grey <= OCCUPIED, grey, UNKNOWN).astype(np.int8)
    occupied = (255.0 - grey) / 255.0
    ratio = (occupied - header.free_thresh) / (header.occupied_thresh - header.free_thresh)
    between = UNKNOWN if header.mode == "trinary" else np.clip(1 + 98 * ratio, 1, 99)
    sure = np.where(occupied > header.occupied_thresh, OCCUPIED, FREE)
    is_sure = (occupied > header.occupied_thresh) | (occupied < header.free_thresh)
    return np.where(is_sure, sure, between).astype(np.int8)


def _turns_unknown_free(header: MapHeader, pixels: Pixels, table: NDArray[np.int8]) -> bool:
    """Tell the known trap: the savers' grey for unknown read as free beside the grey that they write for free."""
    if header.mode == "raw" or header.negate or pixels.full != FULL_GREY or table[UNKNOWN_GREY] != FREE:
        return False
    is_there = np.bincount(pixels.values.ravel(), minlength=FULL_GREY + 1) > 0
    is_level = not is_there[[UNKNOWN_GREY - 1, UNKNOWN_GREY + 1]].any()  # and no shade among others
    return bool(is_there[UNKNOWN_GREY] and is_there[FREE_GREY] and is_level)


def _checked_size(path: Path, pixels: Pixels) -> Pixels:
    height, width = pixels.values.shape
    if min(height, width) < 2:
        raise MapFileError(f"{path}: {width} x {height} pixels are no map; give the whole image")
    return pixels


def _checked(path: Path, grid: OccupancyGrid, remedy: str) -> OccupancyGrid:
    """Refuse a map that nothing can be aligned with."""
    if not grid.free.any():
        what = "all cells are unknown" if grid.unknown.all() else "no cell is free"
        raise MapFileError(f"{path}: {what}; {remedy}")
    return grid
