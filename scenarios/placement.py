"""One robot's log made into one map as a method sees it, turned and cropped, and where the world lies in it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.errors import InputError
from rectmerge.grid import UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.corruption import damage, noise_strength
from sim.lidar import Lidar
from sim.mapping import build_map
from sim.mission import RobotLog

Size = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class MapSpec:
    """How a map is made from a log.

    Parameters
    ----------
    resolution
        Metres per cell.
    turn_deg
        How far the building stands turned in the image, degrees, counter-clockwise to the eye; "random" draws it.
    turn
        "frame": the map frame is turned before mapping, so every cell is as sharp as in an upright map.
        "image": the finished image is turned by nearest neighbour, as the paper does.
    extent_cells
        (width, height) of the upright map: the window with the most known cells, filled up with unknown. Only with
        "image".
    canvas
        (width, height) of the turned image, about the same centre; by default as large as it needs to be. Only with
        "image".
    hide_resolution
        Whether methods are kept from knowing the resolution.

    Raises
    ------
    InputError
        If a value cannot be used.
    """

    resolution: float = 0.05
    turn_deg: float | Literal["random"] = 0.0
    turn: Literal["frame", "image"] = "frame"
    extent_cells: Size | None = None
    canvas: Size | None = None
    hide_resolution: bool = True

    def __post_init__(self) -> None:
        if not 0.005 <= self.resolution <= 1.0:
            raise InputError(f"resolution must be 0.005 to 1 metres per cell, got {self.resolution}")
        if self.turn_deg != "random" and not (isinstance(self.turn_deg, int | float) and math.isfinite(self.turn_deg)):
            raise InputError(f'turn_deg must be a number of degrees or "random", got {self.turn_deg!r}')
        if self.turn not in ("frame", "image"):
            raise InputError(f'turn must be "frame" or "image", got {self.turn!r}')
        for name, size in (("extent_cells", self.extent_cells), ("canvas", self.canvas)):
            if size is not None and (self.turn != "image" or min(size) < 1):
                raise InputError(f'{name} needs turn = "image" and two positive numbers, got {list(size)}')


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlacedMap:
    """A map and where the world lies in it.

    Parameters
    ----------
    grid
        The map as a method sees it.
    turn_deg
        How far the building stands turned in it, degrees counter-clockwise to the eye.
    """

    grid: OccupancyGrid
    turn_deg: float
    _upright: OccupancyGrid
    _frame: Similarity  # from the map frame to the world
    _turned: Similarity  # from the upright map's pixels to the grid's

    def world_to_pixel(self, points: ArrayLike) -> NDArray[np.float64]:
        """Take world points (x, y), shape (..., 2), metres, to pixels (u, v) of the map."""
        return self._turned.apply(self._upright.map_to_pixel(self._frame.inverse().apply(points)))


def place_map(log: RobotLog, lidar: Lidar, spec: MapSpec, *, noise: int, seed: np.random.SeedSequence) -> PlacedMap:
    """Build, damage, crop and turn one robot's map.

    Parameters
    ----------
    log, lidar
        The true ranges, and the scanner that read them.
    spec
        What the map should be.
    noise
        Noise level 0 to 3, of the scanner and of the cells.
    seed
        Of the turn and the grid's phase, which do not depend on the noise level, and of the noise.
    """
    of_frame, of_scans, of_cells = (np.random.default_rng(child) for child in seed.spawn(3))
    drawn, phase = of_frame.uniform(-180.0, 180.0), of_frame.uniform(0.0, spec.resolution, 2)
    turn_deg = drawn if spec.turn_deg == "random" else float(spec.turn_deg)
    yaw = -math.radians(turn_deg) if spec.turn == "frame" else 0.0
    frame = (float(log.poses[0, 0] + phase[0]), float(log.poses[0, 1] + phase[1]), yaw)  # about where the robot started
    strength = noise_strength(noise)
    ranges = lidar.observe(log.ranges, None, of_scans, level=strength) if strength else lidar.limit(log.ranges)
    reach = lidar.max_range_m
    upright = build_map(log.poses, lidar.angles, ranges, resolution=spec.resolution, max_range_m=reach, frame=frame)
    upright = damage(upright, noise, of_cells)
    if spec.extent_cells is not None:
        upright = crop_to_known(upright, spec.extent_cells)
    grid, turned = upright, Similarity()
    if spec.turn == "image":
        grid, turned = turn_image(upright, turn_deg, spec.canvas)
    if spec.hide_resolution:
        grid = OccupancyGrid(grid.occupancy)
    to_world = Similarity(1.0, frame[2], frame[0], frame[1])
    return PlacedMap(grid=grid, turn_deg=turn_deg, _upright=upright, _frame=to_world, _turned=turned)


def crop_to_known(grid: OccupancyGrid, size: Size) -> OccupancyGrid:
    """Cut the window of a size (width, height) that holds the most known cells; unknown where the map ends.

    Of equally good windows the one nearest to the map's middle is taken. The map frame stays where it is.
    """
    width, height = size
    pad_x, pad_y = max(0, width - grid.shape[1]), max(0, height - grid.shape[0])
    left, top = pad_x // 2, pad_y // 2
    around = ((top, pad_y - top), (left, pad_x - left))
    cells = np.pad(grid.occupancy, around, constant_values=UNKNOWN)
    sums = cv2.integral((cells != UNKNOWN).astype(np.uint8))
    held = sums[height:, width:] - sums[:-height, width:] - sums[height:, :-width] + sums[:-height, :-width]
    rows, cols = np.nonzero(held == held.max())
    middle = (rows - (held.shape[0] - 1) / 2) ** 2 + (cols - (held.shape[1] - 1) / 2) ** 2
    row, col = int(rows[np.argmin(middle)]), int(cols[np.argmin(middle)])
    part = cells[row : row + height, col : col + width]
    corner = [col - left - 0.5, row - top + height - 0.5]  # pixel of the window's lower-left corner, in the old image
    x, y = grid.pixel_to_map(corner)
    return OccupancyGrid(part, grid.resolution, (float(x), float(y), grid.origin[2]))


def turn_image(grid: OccupancyGrid, turn_deg: float, canvas: Size | None = None) -> tuple[OccupancyGrid, Similarity]:
    """Turn a map's image about its centre by nearest neighbour.

    Parameters
    ----------
    grid
        The map.
    turn_deg
        Degrees, counter-clockwise to the eye.
    canvas
        (width, height) of the turned image; by default as large as it needs to be.

    Returns
    -------
    turned, pixels
        The turned map, its map frame at its own lower-left corner, and the similarity from the pixels of the old
        image to those of the new one: exactly the index map that was used.
    """
    height, width = grid.shape
    angle = -math.radians(turn_deg)  # pixels have v down
    cos, sin = abs(math.cos(angle)), abs(math.sin(angle))
    new_width, new_height = canvas or (
        math.ceil(width * cos + height * sin - 1e-6),
        math.ceil(width * sin + height * cos - 1e-6),
    )
    about = Similarity(1.0, angle)
    shift = np.array([new_width - 1, new_height - 1]) / 2 - about.apply([(width - 1) / 2, (height - 1) / 2])
    pixels = Similarity(1.0, angle, float(shift[0]), float(shift[1]))
    v, u = np.indices((new_height, new_width))
    old = np.floor(pixels.inverse().apply(np.stack([u, v], axis=-1)) + 0.5).astype(int)  # (H, W, 2)
    inside = ((old >= 0) & (old < [width, height])).all(axis=-1)
    cells = np.full((new_height, new_width), UNKNOWN, dtype=np.int8)
    cells[inside] = grid.occupancy[old[inside][:, 1], old[inside][:, 0]]
    return OccupancyGrid(cells, grid.resolution), pixels
