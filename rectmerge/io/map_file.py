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
from rectmerge.io.dialects import UNKNOWN_GREY, Dialect, Legend, grey_levels, occupancy_table, read_cells
from rectmerge.io.grey_levels import Levels, infer_levels
from rectmerge.io.image_file import OPAQUE, WRITABLE, Pixels, encode_image, read_pixels, recode
from rectmerge.io.map_yaml import MapHeader, read_header
from rectmerge.io.savers_legend import doubtful_grey, turns_unknown_free

YAML_SUFFIXES = (".yaml", ".yml")
IMAGE_SUFFIXES = (".pgm", ".png", ".bmp", ".jpg", ".jpeg", ".tif", ".tiff", ".gif")
CARTOGRAPHER_COMMENT = b"# Cartographer map"  # the second line of its images
MAP_SAVER_LEGEND = Legend()
LOGGER = logging.getLogger("rectmerge")


class PlainMap(NamedTuple):
    """A map read from a plain image, with its grey levels."""

    grid: OccupancyGrid
    levels: Levels


def is_yaml(path: str | os.PathLike[str]) -> bool:
    """Return if a file is a map_server YAML by its suffix, not a plain image."""
    return Path(path).suffix.lower() in YAML_SUFFIXES


def map_files(path: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Return the files of a map: a YAML and its image, those of a bag, or the plain image alone.

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
        A ``.yaml`` or ``.yml``; an image; or ``run.mcap:/robot1/map``, see `rectmerge.io.bag_file.read_bag_map`. An
        image is read by itself, even if there is a YAML next to it: its resolution is then not known (None).
    free, occupied, unknown
        Grey levels of a plain image, 0..255, where `rectmerge.io.grey_levels.infer_levels` is wrong.
    dialect
        Dialect of the image of a YAML, see `rectmerge.io.dialects.occupancy_table`; None is "nav2", and "cartographer"
        for an image with Cartographer's comment.
    strict_thresholds
        Apply the thresholds of a YAML even where they turn unknown space free, see Notes.

    Raises
    ------
    MapFileError
        If the file cannot be read as a map, or has no free cell; the message names the file and the remedy.

    Notes
    -----
    Modes are trinary, scale and raw, as nav2_map_server reads them; `rectmerge.io.dialects` has the rules of
    earlier versions, of map_server of ROS 1 and of Cartographer. ``resolution: null`` means an unknown resolution.

    The map savers of nav2 wrote ``free_thresh: 0.25`` for years with grey 205 for unknown, which by that threshold is
    free: (255 - 205) / 255 = 0.196. Where 205 would turn free in an image that has the savers' free grey, 254, and next
    to no shades of 204 and 206, it stays unknown, and the logger `rectmerge` warns. It also warns of a map that reads
    more than 95 % free while one grey, not the lightest, covers most of it.
    """
    if not is_yaml(path) and not is_bag(path):
        return read_image(path, free=free, occupied=occupied, unknown=unknown).grid
    if any(level is not None for level in (free, occupied, unknown)):
        reason = "a YAML defines them by its thresholds" if is_yaml(path) else "a bag holds cells"
        raise MapFileError(f"{path}: grey levels are for plain images; {reason}")
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
    grey = pixels.grey
    try:
        levels = infer_levels(grey, free=free, occupied=occupied, unknown=unknown, seen=pixels.opaque)
    except InputError as error:
        raise MapFileError(f"{path}: {error}; name the levels with --free, --occupied and --unknown") from None
    occupancy = levels.classify(grey)
    if pixels.opaque is not None:
        occupancy[~pixels.opaque] = UNKNOWN
    return PlainMap(_checked(Path(path), OccupancyGrid(occupancy), f"read with {levels}"), levels)


def write_map(
    grid: OccupancyGrid, path: str | os.PathLike[str], *, image_suffix: str = ".pgm", legend: Legend = MAP_SAVER_LEGEND
) -> None:
    """Write a map as map_saver does: the YAML `path` and an image of the same name next to it.

    Parameters
    ----------
    grid
        The map.
    path
        A ``.yaml``; its image gets the same stem. Both appear whole, the YAML last.
    image_suffix
        ".pgm" or ".png"; mode scale needs ".png" where cells are unknown.
    legend
        Mode, thresholds and negate of the file, such as those of another map (`rectmerge.io.map_yaml.read_header`).
        In mode trinary, the default, a trinary map (-1, 0, 100) is read back bit for bit and other values become free,
        occupied or unknown; modes scale and raw keep every value.

    Raises
    ------
    MapFileError
        If the name is not a YAML's, the legend has no grey for a value of the map, or the files cannot be written.

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
    """Return if a map has occupancies between free and occupied, which mode trinary cannot keep."""
    return bool(((grid.occupancy > FREE) & (grid.occupancy < OCCUPIED)).any())


def encode_map(grid: OccupancyGrid, image_name: str, legend: Legend = MAP_SAVER_LEGEND) -> tuple[bytes, bytes]:
    """Encode the image and the YAML of a map, as `write_map` writes them.

    Parameters
    ----------
    grid
        The map.
    image_name
        Name of the image in the YAML; its suffix, ".pgm" or ".png", selects the encoding.
    legend
        As in `write_map`.
    """
    greys = grey_levels(legend)
    table = np.append(greys[: OCCUPIED + 1], np.full(255 - OCCUPIED, greys[-1]))  # unknown, -1, reads as 255
    pixels = recode(grid.occupancy.view(np.uint8), table.view(np.int8)).view(np.uint8)
    if legend.mode == "scale" and grid.unknown.any():
        if Path(image_name).suffix != ".png":
            raise InputError("mode scale marks unknown cells by transparency, so its image must be a .png")
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
        raise MapFileError(f"{path}: its image {error}{_nearby_hint(path, header.image)}") from None
    _note_oddities(path, header)
    dialect = dialect or _detect_dialect(path, header.image)
    keep = not strict_thresholds and turns_unknown_free(header.legend, pixels, dialect)
    if keep:
        LOGGER.warning(
            "%s: %sfree_thresh %g would turn grey 205, which map savers write for unknown, into free space; it is kept "
            "unknown (--strict-thresholds obeys the file, %s mends it)",
            path,
            "mode scale with " if header.legend.mode == "scale" else "",
            header.legend.free_thresh,
            _remedy(header.legend, dialect),
        )
    occupancy = read_cells(pixels, header.legend, dialect, keep=keep)
    try:
        grid = OccupancyGrid(occupancy, header.resolution, header.origin)
    except InputError as error:
        raise MapFileError(f"{path}: {error}") from None
    if (grey := doubtful_grey(pixels, grid)) is not None and not strict_thresholds:
        LOGGER.warning(
            "%s: %.0f %% of it reads free, most of it grey %d: if that is unknown space, lower free_thresh",
            path,
            100 * grid.free.mean(),
            grey,
        )
    return _checked(path, grid, "check negate, free_thresh and occupied_thresh")


def _note_oddities(path: Path, header: MapHeader) -> None:
    """Note what a YAML says that is taken otherwise, or that its author hardly meant."""
    if header.image != path.parent / header.named_image:
        LOGGER.info("%s: %s is not there; %s beside it is read", path, header.named_image, header.image.name)
    free, occupied = header.legend.free_thresh, header.legend.occupied_thresh
    if header.legend.mode != "raw" and free >= occupied:
        LOGGER.warning(
            "%s: free_thresh %g is not below occupied_thresh %g; it is read as map servers do", path, free, occupied
        )


def _nearby_hint(path: Path, image: Path) -> str:
    """Name a file beside a YAML that may be its missing image: of the image's name, or of the YAML's."""
    if os.path.lexists(image):
        return ""
    named = path.with_name(PureWindowsPath(image).name or path.name)  # either kind of slash
    if named != path and os.path.isfile(named):  # noqa: PTH113 - no error, any name
        return f"; {named.name} is in the YAML's folder: if it is the map's, write image: {named.name}"
    for same_stem in (path.with_suffix(suffix) for suffix in IMAGE_SUFFIXES):
        if same_stem.is_file():
            return f"; {same_stem.name} has the YAML's name: if it is the map's, write image: {same_stem.name}"
    return ""


def _remedy(legend: Legend, dialect: Dialect) -> str:
    """Return the YAML keys by which grey 205 is unknown space again."""
    savers = replace(legend, free_thresh=MAP_SAVER_LEGEND.free_thresh)
    if occupancy_table(savers, dialect)[UNKNOWN_GREY] != FREE:
        return f"free_thresh: {savers.free_thresh:g}"
    return f"mode: trinary with free_thresh: {savers.free_thresh:g}"


def _detect_dialect(path: Path, image: Path) -> Dialect:
    """Detect the dialect of an image by its comment."""
    with image.open("rb") as file:
        if CARTOGRAPHER_COMMENT not in file.read(len(CARTOGRAPHER_COMMENT) + 8):
            return "nav2"
    LOGGER.info("%s: Cartographer's image: grey is read as probability (--dialect nav2 goes by thresholds)", path)
    return "cartographer"


def _checked_size(path: Path, pixels: Pixels) -> Pixels:
    height, width = pixels.values.shape
    if min(height, width) < 2:
        raise MapFileError(f"{path}: {width} x {height} pixels are no map; give the whole image")
    return pixels


def _checked(path: Path, grid: OccupancyGrid, remedy: str) -> OccupancyGrid:
    """Return the map, or raise MapFileError if it cannot be aligned with any."""
    if why := unusable(grid):
        raise MapFileError(f"{path}: {why}; {remedy}")
    return grid
