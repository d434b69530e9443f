"""Corruptions that move points: the new cells, and the motion of the points by the same index map.

Every new cell takes the value of the old cell that moved there; of several, occupied wins over free and free over
unknown. `CorruptedMap.map_points` is that motion, between pixel centres.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.errors import InputError
from rectmerge.grid import UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.corruption.point_motions import CorruptedMap, Kink, Points, Stretch, Waves

Size = tuple[int, int]
MIDDLE = (0.3, 0.7)  # a kink leaves at least about this share of the known cells on either side


def bend(grid: OccupancyGrid, degrees: float, rng: np.random.Generator) -> CorruptedMap:
    """Bend a map smoothly, as a drifting heading causes.

    Parameters
    ----------
    grid
        The map.
    degrees
        Largest local turn of a wall. The wavelengths are one to two map diagonals: corridors become arcs, right
        angles stay nearly right.
    rng
        Randomness of the waves' direction, lengths and phases.

    Returns
    -------
    CorruptedMap
        The image grows so that nothing is lost.
    """
    angle = rng.uniform(0, 2 * math.pi)
    along = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    lengths = rng.uniform(1.0, 2.0, 2) * math.hypot(*grid.shape)
    sideways = (math.tan(math.radians(degrees)) * lengths / math.tau)[:, None] * along[::-1]
    waves = Waves(math.tau / lengths[:, None] * along, rng.uniform(0, math.tau, 2), sideways)
    margin = math.ceil(float(np.hypot(*sideways.T).sum()))
    low, (height, width) = np.array([-margin, -margin]), grid.shape
    old = waves.undo(_centres((width + 2 * margin, height + 2 * margin), low))
    return CorruptedMap(_onto(grid, sample_nearest(grid, old), low), (waves, _shift(-low)))


def stretch(grid: OccupancyGrid, percent: float, rng: np.random.Generator) -> CorruptedMap:
    """Stretch a map along one direction, as a wrong wheel radius causes in corridors of one direction.

    Parameters
    ----------
    grid
        The map.
    percent
        Percent of extra length along the direction; negative shortens.
    rng
        Randomness of the direction.

    Returns
    -------
    CorruptedMap
        The image grows so that nothing is lost.
    """
    angle = rng.uniform(0, math.pi)
    along = np.array([math.cos(angle), math.sin(angle)])
    size = np.array(grid.shape[::-1])
    motion = Stretch((size - 1) / 2, np.eye(2) + percent / 100 * np.outer(along, along))
    margin = math.ceil(abs(percent) / 100 * math.hypot(*size) / 2)
    low = np.array([-margin, -margin])
    old = motion.undo(_centres(size + 2 * margin, low))
    return CorruptedMap(_onto(grid, sample_nearest(grid, old), low), (motion, _shift(-low)))


def kink(grid: OccupancyGrid, degrees: float, rng: np.random.Generator) -> CorruptedMap:
    """Turn everything beyond a line about a point on it, as SLAM does when it loses its heading at a door.

    Parameters
    ----------
    grid
        The map.
    degrees
        Turn, counter-clockwise to the eye.
    rng
        Randomness of the line, which has known cells on both sides, and of the point, a known cell next to it.

    Returns
    -------
    CorruptedMap
        The image grows so that nothing known is lost. Where the parts overlap, occupied wins over free and free over
        unknown; between them a wedge stays unknown.
    """
    known = np.argwhere(~grid.unknown)[:, ::-1].astype(np.float64)  # (N, 2), pixels
    if not len(known):
        return CorruptedMap(grid)
    angle = rng.uniform(0, 2 * math.pi)
    beyond = np.array([math.cos(angle), math.sin(angle)])
    across = known @ beyond
    about = known[int(np.argsort(across, kind="stable")[int(rng.uniform(*MIDDLE) * len(known))])]
    turned = Similarity(1.0, -math.radians(degrees))  # pixels have v down
    tx, ty = about - turned.apply(about)
    slip = Kink(about, beyond, Similarity(1.0, turned.angle, float(tx), float(ty)))
    moved = slip.apply(known)
    low = np.minimum(0, np.floor(moved.min(axis=0))).astype(int)
    high = np.maximum(np.array(grid.shape[::-1]) - 1, np.ceil(moved.max(axis=0))).astype(int)
    centres = _centres(high - low + 1, low)
    old = slip.turn.inverse().apply(centres)
    stays = np.where(slip.is_beyond(centres), UNKNOWN, sample_nearest(grid, centres))
    turns = np.where(slip.is_beyond(old), sample_nearest(grid, old), UNKNOWN)
    return CorruptedMap(_onto(grid, np.maximum(stays, turns), low), (slip, _shift(-low)))


def resize_cells(grid: OccupancyGrid, factor: float) -> CorruptedMap:
    """Change the size of the cells, over the same floor.

    Parameters
    ----------
    grid
        The map.
    factor
        New cells per old cell along a side: 2 halves the resolution's metres per cell.

    Returns
    -------
    CorruptedMap
        Where several old cells fall into a new one, occupied wins over free and free over unknown, so that walls one
        cell thick survive.
    """
    height, width = (math.ceil(side * factor - 1e-9) for side in grid.shape)
    shift = (factor - 1) / 2  # pixel centres lie at integers, so (0, 0) is half a cell from the corner
    pixels = Similarity(factor, 0.0, shift, shift)
    cells = sample_nearest(grid, pixels.inverse().apply(_centres((width, height))))
    if factor < 1:
        v, u = np.indices(grid.shape)
        new = _nearest(pixels.apply(np.stack([u, v], axis=-1)))
        np.maximum.at(cells, (new[..., 1], new[..., 0]), grid.occupancy)
    resolution = None if grid.resolution is None else grid.resolution / factor
    corner = pixels.inverse().apply([-0.5, height - 0.5])
    x, y = grid.pixel_to_map(corner) * (factor if resolution is None else 1.0)  # a map frame in cells: in new ones
    return CorruptedMap(OccupancyGrid(cells, resolution, (float(x), float(y), grid.origin[2])), (pixels,))


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
    pixels, size = rotate_onto_canvas(grid.shape, turn_deg, 1.0, canvas)
    return OccupancyGrid(sample_nearest(grid, pixels.inverse().apply(_centres(size))), grid.resolution), pixels


def rotate_onto_canvas(
    shape: tuple[int, int], turn_deg: float, factor: float, canvas: Size | None = None
) -> tuple[Similarity, Size]:
    """Turn and rescale an image about its centre onto the middle of a canvas.

    Parameters
    ----------
    shape
        (H, W) of the image.
    turn_deg
        Degrees, counter-clockwise to the eye.
    factor
        Pixels of the new image per pixel of the old one, > 0.
    canvas
        Its (width, height); by default as large as it needs to be.

    Returns
    -------
    pixels, canvas
        The similarity from the pixels of the old image to those of the new one, and the new one's (width, height).

    Raises
    ------
    InputError
        If `factor` is not positive.
    """
    if not factor > 0:
        raise InputError(f"factor must be > 0, got {factor}")
    height, width = shape
    about = Similarity(factor, -math.radians(turn_deg))  # pixels have v down
    cos, sin = abs(math.cos(about.angle)), abs(math.sin(about.angle))
    canvas = canvas or (
        math.ceil(factor * (width * cos + height * sin) - 1e-6),
        math.ceil(factor * (width * sin + height * cos) - 1e-6),
    )
    shift = (np.array(canvas) - 1) / 2 - about.apply([(width - 1) / 2, (height - 1) / 2])
    return Similarity(factor, about.angle, float(shift[0]), float(shift[1])), canvas


def sample_nearest(grid: OccupancyGrid, pixels: Points) -> NDArray[np.int8]:
    """Return the values (H, W) of the cells nearest to pixels (H, W, 2), unknown outside."""
    at = _nearest(pixels)
    inside = ((at >= 0) & (at < grid.shape[::-1])).all(axis=-1)
    cells = np.full(at.shape[:-1], UNKNOWN, dtype=np.int8)
    cells[inside] = grid.occupancy[at[inside][:, 1], at[inside][:, 0]]
    return cells


def _centres(size: Size | NDArray[np.int64], low: ArrayLike = (0, 0)) -> Points:
    """Return pixel centres (H, W, 2) of an image of a size (width, height) whose first pixel is `low`."""
    v, u = np.indices((int(size[1]), int(size[0])))
    return np.stack([u, v], axis=-1).astype(np.float64) + np.asarray(low, dtype=np.float64)


def _nearest(pixels: Points) -> NDArray[np.int64]:
    return np.floor(pixels + 0.5).astype(np.int64)


def _onto(grid: OccupancyGrid, cells: NDArray[np.int8], low: NDArray[np.int64]) -> OccupancyGrid:
    """Return a map of other cells in the map frame of `grid`, the first of them at its pixel `low`."""
    x, y = grid.pixel_to_map([low[0] - 0.5, low[1] + len(cells) - 0.5])
    return OccupancyGrid(cells, grid.resolution, (float(x), float(y), grid.origin[2]))


def _shift(by: NDArray[np.int64]) -> Similarity:
    return Similarity(1.0, 0.0, float(by[0]), float(by[1]))
