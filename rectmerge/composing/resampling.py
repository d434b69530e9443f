"""Resampling of aligned grids on one common lattice of cells, with thin walls kept closed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import LONGEST_SIDE_CELLS, MOST_CELLS, OCCUPIED_AT_LEAST, UNKNOWN, OccupancyGrid
from rectmerge.similarity import Similarity

CELLS_AT_ONCE = 1 << 19
TIE = 0.5 + 1e-9  # a point midway between two cells goes to the later one, in spite of rounding
SPREAD_CELLS = 0.7  # less than 1, so that marks are neighbours; less than half the diagonal of a cell
STRAIGHT_CELLS = 1e-9  # a map turned by whole quarters, to less than this over its whole length, is not tilted


def resample(
    grids: Sequence[OccupancyGrid], placements: Sequence[Similarity]
) -> tuple[list[NDArray[np.int8]], tuple[int, int]]:
    """Read grids on one lattice of unit pixels that holds the whole first grid and the known cells of the others.

    Parameters
    ----------
    grids
        The maps, at least one.
    placements
        For each map the similarity from its pixels to the lattice's.

    Returns
    -------
    tuple
        One occupancy array of shape (H, W) per grid, and the (row, col) of the lattice's pixel (0, 0) in them.

    Raises
    ------
    InputError
        If the lattice would be absurdly large, or a grid has a side of more than 32,766 cells.

    Notes
    -----
    Every lattice cell takes the grid's cell that its centre falls in, so a coarse grid leaves no holes. Where a grid is
    finer or turned, a wall one cell thick could be stepped over; so the lattice cells that a wall's cell centres fall
    in are walls, too, and those at the corner where two wall cells touch by nothing else. With these a closed ring of
    wall cells, neighbours by side or corner, stays closed: no path of lattice cells that are neighbours by side leads
    through it, at any scale and turn. Up to a scale of 1, the marks alone are such a ring, as they lie less than the
    diagonal of a cell apart. Above it, a step between neighbours is shorter than a wall is thick, and can pass only
    within half a lattice cell of such a corner, where there are marks.
    """
    if (longest := max(max(grid.shape) for grid in grids)) > LONGEST_SIDE_CELLS:
        raise InputError(f"a side of a map may have {LONGEST_SIDE_CELLS} cells, got {longest}")
    top, left, height, width = _canvas(grids, placements)
    shift = Similarity(tx=float(-left), ty=float(-top))
    layers = [_lay(grid, shift @ pixels, (height, width)) for grid, pixels in zip(grids, placements, strict=True)]
    return layers, (-top, -left)


def _canvas(grids: Sequence[OccupancyGrid], placements: Sequence[Similarity]) -> tuple[int, int, int, int]:
    """Return top, left, height and width of the box around the first grid and every known cell of the others."""
    rows, cols = grids[0].shape
    whole = np.array([[x, y] for x in (-0.5, cols - 0.5) for y in (-0.5, rows - 0.5)])  # (4, 2)
    corners = [placements[0].apply(whole)]
    corners += [pixels.apply(known_ends(g)) for g, pixels in zip(grids[1:], placements[1:], strict=True)]
    points = np.concatenate(corners)
    left, top = np.floor(points.min(axis=0) + 0.5 + 1e-6).tolist()
    right, bottom = np.ceil(points.max(axis=0) + 0.5 - 1e-6).tolist()
    width, height = max(1.0, right - left), max(1.0, bottom - top)
    if not (width * height <= MOST_CELLS and max(width, height) <= LONGEST_SIDE_CELLS):
        raise InputError(
            f"the merged map would have {width:g} x {height:g} cells: is the scale right, and the resolution?"
        )
    return int(top), int(left), int(height), int(width)


def known_ends(grid: OccupancyGrid) -> NDArray[np.float64]:
    """List the outer corners of the first and the last known cell of each row, in pixels, (N, 2)."""
    known = grid.occupancy != UNKNOWN
    first, last = known.argmax(axis=1), known.shape[1] - 1 - cv2.flip(known.view(np.uint8), 1).view(bool).argmax(axis=1)
    rows = np.flatnonzero(known[np.arange(len(known)), first])
    first, last = first[rows], last[rows]
    ends = [np.stack([u, rows + half], axis=1) for u in (first - 0.5, last + 0.5) for half in (-0.5, 0.5)]
    return np.concatenate(ends)


def _lay(grid: OccupancyGrid, pixels: Similarity, shape: tuple[int, int]) -> NDArray[np.int8]:
    """Resample a grid onto the canvas, unknown outside the grid."""
    layer = np.full(shape, UNKNOWN, np.int8)
    ends = pixels.apply(known_ends(grid))
    if not len(ends):
        return layer
    low, high = ends.min(axis=0), ends.max(axis=0)
    (left, top), (right, bottom) = np.floor(low).astype(int).clip(0), np.ceil(high).astype(int) + 1
    cols = slice(left, min(right, shape[1]))
    for rows in row_bands(top, min(bottom, shape[0]), max(1, right - left)):
        layer[rows, cols] = _nearest(grid, pixels.inverse(), rows, cols)
    walls = np.argwhere(grid.occupied)  # (N, 2)
    values = grid.occupancy[walls[:, 0], walls[:, 1]]
    if not _is_straight(pixels, grid):
        for points, at in _corner_marks(grid, walls, pixels):
            mark_walls(layer, points, values[at])
    centres = pixels.apply(walls[:, ::-1])
    mark_walls(layer, *_unshown(layer, centres, values))
    return layer


def row_bands(first: int, last: int, width: int) -> Iterator[slice]:
    """Part rows into bands of about `CELLS_AT_ONCE` cells."""
    step = max(1, CELLS_AT_ONCE // width)
    return (slice(row, min(row + step, last)) for row in range(first, last, step))


def _nearest(grid: OccupancyGrid, back: Similarity, rows: slice, cols: slice) -> NDArray[np.int8]:
    """Read a grid at the lattice pixels of a window, unknown outside; `back` takes lattice pixels to the grid's."""
    (a, b, tx), (c, d, ty) = back.matrix
    if (a, b, c, d) == (1.0, 0.0, 0.0, 1.0) and tx.is_integer() and ty.is_integer():
        return _cut_out(
            grid, slice(rows.start + int(ty), rows.stop + int(ty)), slice(cols.start + int(tx), cols.stop + int(tx))
        )
    along, down = np.arange(cols.start, cols.stop), np.arange(rows.start, rows.stop)[:, np.newaxis]
    height, width = grid.shape
    at = np.empty((len(down), len(along), 2), np.int16)  # a longer side than 32,767 has no lattice
    at[..., 0] = np.floor(a * along + (b * down + (tx + TIE))).clip(-1, width)
    at[..., 1] = np.floor(c * along + (d * down + (ty + TIE))).clip(-1, height)
    codes = grid.occupancy.view(np.uint8)  # unknown, -1, reads as 255
    read = cv2.remap(codes, at, np.empty(0), cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=255)
    return read.view(np.int8)


def _cut_out(grid: OccupancyGrid, rows: slice, cols: slice) -> NDArray[np.int8]:
    """Copy a window of a grid, unknown outside it."""
    window = np.full((rows.stop - rows.start, cols.stop - cols.start), UNKNOWN, np.int8)
    top, left = max(0, rows.start), max(0, cols.start)
    seen = grid.occupancy[top : max(top, rows.stop), left : max(left, cols.stop)]
    down, right = top - rows.start, left - cols.start
    window[down : down + seen.shape[0], right : right + seen.shape[1]] = seen
    return window


def mark_walls(layer: NDArray[np.int8], points: NDArray[np.float64], values: NDArray[np.int8]) -> None:
    """Write values into the cells that contain the pixel points, shape (N, 2)."""
    u, v = np.floor(points + TIE).astype(int).T
    inside = (u >= 0) & (v >= 0) & (u < layer.shape[1]) & (v < layer.shape[0])
    layer[v[inside], u[inside]] = values[inside]


def _unshown(
    layer: NDArray[np.int8], points: NDArray[np.float64], values: NDArray[np.int8]
) -> tuple[NDArray[np.float64], NDArray[np.int8]]:
    """Drop points midway between two cells if one is a wall already: a mark in the other would double that wall."""
    low, high = (np.floor(points + side).astype(int) for side in (1 - TIE, TIE))
    midway = np.flatnonzero((low != high).any(axis=1))
    shown = np.zeros(len(points), np.bool_)
    for u in (low[midway, 0], high[midway, 0]):
        for v in (low[midway, 1], high[midway, 1]):
            inside = (u >= 0) & (v >= 0) & (u < layer.shape[1]) & (v < layer.shape[0])
            shown[midway[inside]] |= layer[v[inside], u[inside]] >= OCCUPIED_AT_LEAST
    return points[~shown], values[~shown]


def _is_straight(pixels: Similarity, grid: OccupancyGrid) -> bool:
    """Return if a placement turns by whole quarters: then nothing passes between cells that touch by a corner."""
    return abs(math.sin(2 * pixels.angle)) * pixels.scale * max(grid.shape) <= STRAIGHT_CELLS


def _corner_marks(
    grid: OccupancyGrid, walls: NDArray[np.intp], pixels: Similarity
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.intp]]]:
    """Yield points, shape (M, 2), where wall cells touch by a corner alone, and the index of one of the two in `walls`.

    These are the corner itself and two points on the line between the centres. At a scale above 1 they are close enough
    to be neighbours; below, they are no farther than the centres.
    """
    is_wall = np.pad(grid.occupied, 1)
    row, col = walls.T + 1
    reach = min(0.5, SPREAD_CELLS / (math.sqrt(2) * pixels.scale))
    for side in (-1, 1):
        at = np.flatnonzero(is_wall[row + 1, col + side] & ~is_wall[row + 1, col] & ~is_wall[row, col + side])
        corner, diagonal = walls[at, ::-1] + [0.5 * side, 0.5], np.array([side, 1.0])
        for t in (-reach, 0.0, reach):
            yield pixels.apply(corner + t * diagonal), at
