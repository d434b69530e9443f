"""Map files: ROS map_server YAML with its PGM or PNG, and plain images whose grey levels are inferred."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, cast

import numpy as np
import yaml
from numpy.typing import NDArray

from rectmerge.errors import InputError, MapFileError
from rectmerge.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.imagefile import WRITABLE, Pixels, encode_image, read_pixels, replace_file, require_file
from rectmerge.levels import Levels, infer_levels

YAML_SUFFIXES = (".yaml", ".yml")
MAX_YAML_BYTES = 65_536
FREE_GREY, UNKNOWN_GREY, OCCUPIED_GREY = 254, 205, 0  # as map_saver writes them
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196

Mode = Literal["trinary", "scale", "raw"]


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
    return (Path(path), _read_header(Path(path)).image) if is_yaml(path) else (Path(path),)


def read_map(
    path: str | os.PathLike[str],
    *,
    free: int | None = None,
    occupied: int | None = None,
    unknown: int | None = None,
) -> OccupancyGrid:
    """Read a map: a ROS map_server YAML with its image, or a plain image.

    Parameters
    ----------
    path
        A ``.yaml`` or ``.yml``, or an image. An image is read by itself, even if a YAML lies beside it: its
        resolution is then not known (None).
    free, occupied, unknown
        Grey levels of a plain image, 0..255, where the guess of `rectmerge.levels.infer_levels` is wrong.

    Raises
    ------
    MapFileError
        If the file cannot be read as a map, or has no free cell; the message names the file and the remedy.

    Notes
    -----
    Follows map_server 1.17 (image_loader.cpp) in its modes trinary, scale and raw. Departs from it: an alpha channel
    is not averaged with the colours (opaque grey 205 would turn free); in scale mode it still marks unknown cells.
    ``resolution: null`` is read as a resolution that is not known.
    """
    if not is_yaml(path):
        return read_image(path, free=free, occupied=occupied, unknown=unknown).grid
    if any(level is not None for level in (free, occupied, unknown)):
        raise MapFileError(f"{path}: grey levels are for plain images; a YAML tells them by its thresholds")
    return _read_yaml_map(Path(path))


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


@dataclass(frozen=True, slots=True, kw_only=True)
class _Header:
    """The checked content of a map_server YAML."""

    image: Path
    resolution: float | None
    origin: tuple[float, float, float]
    negate: bool
    occupied_thresh: float
    free_thresh: float
    mode: Mode


def _read_yaml_map(path: Path) -> OccupancyGrid:
    header = _read_header(path)
    try:
        pixels = _checked_size(header.image, read_pixels(header.image))
    except MapFileError as error:
        raise MapFileError(f"{path}: its image {error}") from None
    occupancy = _occupancy_table(header, pixels.full)[pixels.values]
    if header.mode == "scale" and pixels.opaque is not None:
        occupancy[~pixels.opaque & (occupancy > FREE) & (occupancy < OCCUPIED)] = UNKNOWN
    grid = OccupancyGrid(occupancy, header.resolution, header.origin)
    return _checked(path, grid, "check negate, free_thresh and occupied_thresh")


def _occupancy_table(header: _Header, full: int) -> NDArray[np.int8]:
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


def _read_header(path: Path) -> _Header:
    require_file(path)
    if path.stat().st_size > MAX_YAML_BYTES:
        raise MapFileError(f"{path}: more than {MAX_YAML_BYTES // 1024} KB, so not a map_server YAML")
    try:
        keys = yaml.safe_load(path.read_bytes())
    except OSError as error:
        raise MapFileError(f"{path}: {error.strerror or error}; make the file readable") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise MapFileError(f"{path}: not valid YAML: {' '.join(str(error).split())[:200]}") from None
    if keys is None:
        raise MapFileError(f"{path}: the file is empty; a map_server YAML names image, resolution, origin, ...")
    if not isinstance(keys, dict):
        raise MapFileError(f"{path}: not a map_server YAML: it must map image, resolution, origin, ... to values")
    image = keys.get("image")
    if not isinstance(image, str) or not image or "\0" in image:
        raise MapFileError(f"{path}: image must name the map's image file, got {_short(image)}")
    mode = keys.get("mode", "trinary")
    if mode not in ("trinary", "scale", "raw"):
        raise MapFileError(f"{path}: mode must be trinary, scale or raw, got {_short(mode)}")
    negate = keys.get("negate", 0)
    if negate not in (0, 1, "0", "1"):
        raise MapFileError(f"{path}: negate must be 0 or 1, got {_short(negate)}")
    occupied_thresh, free_thresh = (_number(path, keys, key) for key in ("occupied_thresh", "free_thresh"))
    if not 0 <= free_thresh < occupied_thresh <= 1:
        raise MapFileError(
            f"{path}: thresholds must satisfy 0 <= free_thresh < occupied_thresh <= 1, "
            f"got {free_thresh:g} and {occupied_thresh:g}; map_saver writes 0.196 and 0.65"
        )
    return _Header(
        image=path.parent / image,
        resolution=_resolution(path, keys),
        origin=_origin(path, keys),
        negate=bool(int(negate)),
        occupied_thresh=occupied_thresh,
        free_thresh=free_thresh,
        mode=cast(Mode, mode),
    )


def _resolution(path: Path, keys: Mapping[str, Any]) -> float | None:
    if "resolution" in keys and keys["resolution"] is None:
        return None
    resolution = _number(path, keys, "resolution")
    if resolution <= 0:
        raise MapFileError(f"{path}: resolution must be > 0 metres per cell (null if not known), got {resolution:g}")
    return resolution


def _origin(path: Path, keys: Mapping[str, Any]) -> tuple[float, float, float]:
    origin = keys.get("origin")
    if not isinstance(origin, list) or len(origin) != 3:
        raise MapFileError(f"{path}: origin must be [x, y, yaw], got {_short(origin)}")
    named = {f"origin[{i}]": value for i, value in enumerate(origin)}
    x, y, yaw = (_number(path, named, key) for key in named)
    return x, y, yaw


def _number(path: Path, keys: Mapping[str, Any], key: str) -> float:
    """Read a finite number; text such as 5e-2, which YAML 1.1 does not take for a number, counts too."""
    if key not in keys:
        raise MapFileError(f"{path}: the key {key} is missing; map_server needs it")
    value = keys[key]
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise MapFileError(f"{path}: {key} must be a finite number, got {_short(value)}")
    return number


def _short(value: object) -> str:
    text = "nothing" if value is None else repr(value) if isinstance(value, str | int | float) else type(value).__name__
    return text if len(text) <= 60 else text[:57] + "..."
