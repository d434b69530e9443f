"""Occupancy grid and its three frames: pixel, cell and map."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity

UNKNOWN = -1
FREE = 0
OCCUPIED = 100
FREE_AT_MOST = 25  # map_saver's default thresholds, in percent
OCCUPIED_AT_LEAST = 65
MOST_CELLS = 150_000_000  # about 12,000 x 12,000: more would not fit a common machine's memory
LONGEST_SIDE_CELLS = 32_766  # OpenCV turns and rescales no image with a longer side


@dataclass(frozen=True, slots=True, eq=False)
class OccupancyGrid:
    """Occupancy grid as in nav_msgs, with its image's top row first.

    Frames
    ------
    pixel
        (u right, v down), pixel centres at integers, (0, 0) at the top left.
    cell
        Array index (row, col) = (v, u). ROS messages have row 0 at the bottom: flip at the edge.
    map
        Metres (cells where `resolution` is None), x and y of `origin`: the lower-left corner of the lower-left pixel,
        turned by its yaw.

    Parameters
    ----------
    occupancy
        Shape (H, W), int8: -1 unknown, 0..100 percent occupied.
    resolution
        Metres per cell, or None where it is not known.
    origin
        (x, y, yaw) in metres (cells where `resolution` is None) and radians.
    frame
        The name of the map frame as a bag gives it; None where there is none.

    Raises
    ------
    InputError
        If the array is not 2-D and non-empty, a value is outside -1..100, or resolution or origin is not usable.
    """

    occupancy: NDArray[np.int8]
    resolution: float | None = None
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    frame: str | None = None

    def __post_init__(self) -> None:
        array = np.ascontiguousarray(self.occupancy)
        if array.ndim != 2 or array.size == 0:
            raise InputError(f"occupancy must have shape (H, W) with at least one cell, got {array.shape}")
        if array.dtype != np.int8 and not np.issubdtype(array.dtype, np.integer):
            raise InputError(f"occupancy must hold integers -1..100, got {array.dtype}")
        if array.min() < UNKNOWN or array.max() > OCCUPIED:
            raise InputError(f"occupancy must lie in -1..100, got {array.min()}..{array.max()}")
        array = array.astype(np.int8)
        array.flags.writeable = False
        object.__setattr__(self, "occupancy", array)
        if self.resolution is not None:
            if not (math.isfinite(self.resolution) and self.resolution > 0):
                raise InputError(f"resolution must be a positive number of metres per cell or None: {self.resolution}")
            object.__setattr__(self, "resolution", float(self.resolution))  # YAML does not write numpy's numbers
        origin = tuple(float(v) for v in self.origin)
        if len(origin) != 3 or not all(map(math.isfinite, origin)):
            raise InputError(f"origin must be three finite numbers (x, y, yaw), got {self.origin}")
        object.__setattr__(self, "origin", origin)

    @property
    def shape(self) -> tuple[int, int]:
        """(H, W) in cells."""
        return self.occupancy.shape

    @property
    def cell_size(self) -> float:
        """Map units per cell: the resolution, or 1 where it is not known."""
        return 1.0 if self.resolution is None else self.resolution

    @property
    def unit(self) -> str:
        """The unit of the map frame: "m", or "cells" where the resolution is not known."""
        return "cells" if self.resolution is None else "m"

    @property
    def free(self) -> NDArray[np.bool_]:
        """Mask of free cells, shape (H, W)."""
        mask: NDArray[np.bool_] = self.occupancy.view(np.uint8) <= FREE_AT_MOST  # unknown, -1, reads as 255
        return mask

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Mask of occupied cells, shape (H, W)."""
        mask: NDArray[np.bool_] = self.occupancy >= OCCUPIED_AT_LEAST
        return mask

    @property
    def unknown(self) -> NDArray[np.bool_]:
        """Mask of cells that are neither free nor occupied, shape (H, W)."""
        return ~(self.free | self.occupied)

    def pixel_to_map(self, pixels: ArrayLike) -> NDArray[np.float64]:
        """Take (u, v) pixel points, shape (..., 2), to (x, y) map points."""
        uv = np.asarray(pixels, dtype=np.float64)
        local = np.stack([uv[..., 0] + 0.5, self.shape[0] - 0.5 - uv[..., 1]], axis=-1)  # cells, y up
        return self._placement.apply(local)

    def map_to_pixel(self, points: ArrayLike) -> NDArray[np.float64]:
        """Take (x, y) map points, shape (..., 2), to (u, v) pixel points."""
        local = self._placement.inverse().apply(points)
        return np.stack([local[..., 0] - 0.5, self.shape[0] - 0.5 - local[..., 1]], axis=-1)

    @property
    def _placement(self) -> Similarity:
        """From the grid's own corner, in cells with y up, to the map frame."""
        x, y, yaw = self.origin
        return Similarity(self.cell_size, yaw, x, y)


def unusable(grid: OccupancyGrid) -> str:
    """Return why a map cannot be aligned; empty where it has free cells."""
    if grid.free.any():
        return ""
    return "all cells are unknown" if grid.unknown.all() else "no cell is free"


def known_part(grid: OccupancyGrid) -> OccupancyGrid:
    """Return the smallest map, in the same map frame, that has all known cells; the map itself where it has none."""
    is_known = grid.occupancy != UNKNOWN
    rows, cols = np.flatnonzero(is_known.any(axis=1)), np.flatnonzero(is_known.any(axis=0))
    if len(rows) == 0:
        return grid
    top, bottom, left, right = rows[0], rows[-1] + 1, cols[0], cols[-1] + 1
    x, y = grid.pixel_to_map([left - 0.5, bottom - 0.5])
    return replace(grid, occupancy=grid.occupancy[top:bottom, left:right], origin=(float(x), float(y), grid.origin[2]))


def pixels_to_map_frame(pixels: Similarity, a: OccupancyGrid, b: OccupancyGrid) -> Similarity:
    """Turn the pixel similarity from B's image to A's into `b_to_a` between their map frames."""
    scale = pixels.scale * a.cell_size / b.cell_size
    angle = math.remainder(a.origin[2] - b.origin[2] - pixels.angle, math.tau)
    return _through_point(scale, angle, b.pixel_to_map([0.0, 0.0]), a.pixel_to_map(pixels.apply([0.0, 0.0])))


def map_frame_to_pixels(b_to_a: Similarity, a: OccupancyGrid, b: OccupancyGrid) -> Similarity:
    """Turn `b_to_a` between the map frames into the pixel similarity from B's image to A's."""
    scale = b_to_a.scale * b.cell_size / a.cell_size
    angle = math.remainder(a.origin[2] - b.origin[2] - b_to_a.angle, math.tau)
    at_b = b.pixel_to_map([0.0, 0.0])
    return _through_point(scale, angle, np.zeros(2), a.map_to_pixel(b_to_a.apply(at_b)))


def _through_point(scale: float, angle: float, source: NDArray[np.float64], target: NDArray[np.float64]) -> Similarity:
    tx, ty = target - Similarity(scale, angle).apply(source)
    return Similarity(scale, angle, float(tx), float(ty))
