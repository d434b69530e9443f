"""Files that worlds are made from: the YAML of a ROS map, an image, or a JSON plan."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError, MapFileError, SimulationError
from rectmerge.extras import missing
from rectmerge.grid import FREE, UNKNOWN, OccupancyGrid
from rectmerge.io.grey_levels import infer_levels
from rectmerge.io.image_file import read_pixels, require_file
from rectmerge.io.map_file import YAML_SUFFIXES, is_yaml, read_map
from sim.importers.grids import NARROWEST_M, world_from_grid
from sim.world import World

IMAGE_SUFFIXES = (".pgm", ".png", ".pbm", ".ppm", ".bmp", ".jpg", ".jpeg", ".tif", ".tiff", ".gif")
MOST_JSON_BYTES = 16_000_000
WALL_M = 0.15  # thickness of a JSON plan's walls


def import_world(
    path: str | os.PathLike[str],
    *,
    resolution: float | None = None,
    narrowest_m: float = NARROWEST_M,
    max_speck_cells: int = 0,
    wall_m: float = WALL_M,
) -> World:
    """Make a world from a file: walls, floor, and rooms that a robot can tour.

    Parameters
    ----------
    path
        A ROS map's ``.yaml``, an image of a map or of a black-and-white floor plan, or a ``.json`` as in HouseExpo.
    resolution
        Metres per pixel, instead of the resolution in the file or where it has none. A JSON plan is in metres.
    narrowest_m, max_speck_cells
        Free space that is no floor, and cells that are no wall: see `sim.importers.grids.world_from_grid`.
    wall_m
        Thickness of a JSON plan's walls.

    Returns
    -------
    World
        Family "imported/" and the stem of the file, seed 0; (0, 0) is the lower left of its walls.

    Raises
    ------
    MapFileError
        If the file cannot be read, or no world can be made of it; the message names the file and the remedy.
    InputError
        If another value cannot be used.
    SimulationError
        If a JSON plan is to be read and shapely is not installed.

    Notes
    -----
    An image with a third grey level is a map, and that level is unknown. In an image of two, dark is wall, and light
    is outside where it is connected to the image's border, else floor.
    """
    file = Path(path)
    require_file(file)
    is_plan = file.suffix.lower() == ".json"
    if not (is_plan or is_yaml(file) or file.suffix.lower() in IMAGE_SUFFIXES):
        kinds = ", ".join((*YAML_SUFFIXES, *IMAGE_SUFFIXES))
        raise MapFileError(f"{path}: a world is made from a map or an image ({kinds}) or from a plan (.json)")
    if resolution is not None and not (math.isfinite(resolution) and resolution > 0):
        raise InputError(f"resolution must be a positive number of metres per pixel, got {resolution}")
    if is_plan and resolution is not None:
        raise MapFileError(f"{path}: a JSON plan is in metres; leave the resolution (--resolution) out")
    name = f"imported/{file.stem}"
    try:
        if is_plan:
            return _world_from_plan(_read_json(file), name, wall_m)
        grid = read_map(file) if is_yaml(file) else _read_drawing(file)
        grid = _with_resolution(grid, file, resolution)
        return world_from_grid(grid, name, narrowest_m=narrowest_m, max_speck_cells=max_speck_cells)
    except MapFileError:
        raise
    except InputError as error:
        raise MapFileError(f"{path}: {error}") from error


def _with_resolution(grid: OccupancyGrid, file: Path, resolution: float | None) -> OccupancyGrid:
    known = resolution or grid.resolution
    if known is not None:
        return OccupancyGrid(grid.occupancy, known)
    yamls = [other.name for suffix in YAML_SUFFIXES if (other := file.with_suffix(suffix)).exists() and other != file]
    instead = f"give {yamls[0]} beside it instead, or " if yamls else ""
    raise MapFileError(f"{file}: metres per pixel are not known; {instead}give the resolution (--resolution 0.05, say)")


def _read_drawing(file: Path) -> OccupancyGrid:
    """Read an image; of two grey levels the light one is unknown where it is connected to the border."""
    pixels = read_pixels(file)
    grey = pixels.grey
    try:
        levels = infer_levels(grey, seen=pixels.opaque)
    except InputError as error:
        raise MapFileError(f"{file}: {error}; draw the walls dark and the floor light") from None
    cells = levels.classify(grey)
    if pixels.opaque is not None:
        cells[~pixels.opaque] = UNKNOWN
    if levels.unknown is None:
        cells[_joined_to_border(cells <= FREE)] = UNKNOWN
    if not (cells == FREE).any():
        raise MapFileError(f"{file}: no light area is enclosed by dark walls; close the outer walls, doors included")
    return OccupancyGrid(cells)


def _joined_to_border(light: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the mask of light cells that are connected to the border of the image by their sides."""
    around = np.pad(light, 1, constant_values=True).view(np.uint8)
    _, parts = cv2.connectedComponents(around, connectivity=4)
    outside: NDArray[np.bool_] = (parts == parts[0, 0])[1:-1, 1:-1]
    return outside


def _read_json(file: Path) -> Any:
    try:
        if file.stat().st_size > MOST_JSON_BYTES:
            raise MapFileError(f"{file}: larger than {MOST_JSON_BYTES // 10**6} MB: too large for the plan of a house")
        return json.loads(file.read_bytes())
    except OSError as error:
        raise MapFileError(f"{file}: cannot be read: {error.strerror or error}") from error
    except RecursionError:
        raise MapFileError(f"{file}: nested too deeply for a plan") from None
    except ValueError as error:  # no JSON, or no text at all
        raise MapFileError(f"{file}: not JSON: {error}") from error


def _world_from_plan(plan: Any, name: str, wall_m: float) -> World:
    try:
        from sim.importers.plans import world_from_plan
    except ImportError as error:
        raise SimulationError(f"reading a JSON plan {missing('shapely')}") from error
    return world_from_plan(plan, name, wall_m=wall_m)
