"""Map B redrawn without its bend, so that a similarity lays it on A."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from rectmerge.composing.resampling import TIE, known_ends, mark_walls, row_bands
from rectmerge.elastic.warp import Warp
from rectmerge.grid import UNKNOWN, OccupancyGrid

ROUNDING = 1e-6  # cells


def straighten(b: OccupancyGrid, warp: Warp) -> OccupancyGrid:
    """Redraw map B so that the warp's similarity alone lays it on A.

    Parameters
    ----------
    b
        The map.
    warp
        From B's pixels to A's.

    Returns
    -------
    OccupancyGrid
        B's cells and map frame, on a larger canvas where the displacement needs it.

    Notes
    -----
    As in `rectmerge.composing.resampling.resample`, every cell takes B's cell that its centre comes from, and the cells
    that the centres of B's wall cells fall in are walls, too. Where stretching parts the marks of two neighbours, one
    between them joins them, so that a closed wall of one cell stays closed.
    """
    back = warp.similarity.inverse()
    ends = back.apply(warp.apply(known_ends(b)))
    if not len(ends):
        return b
    height, width = b.shape
    left, top = np.minimum(np.floor(ends.min(axis=0) + 0.5 + ROUNDING).astype(int), 0).tolist()
    right, bottom = np.maximum(np.ceil(ends.max(axis=0) + 0.5 - ROUNDING).astype(int), [width, height]).tolist()
    layer = np.full((bottom - top, right - left), UNKNOWN, np.int8)
    corner = np.array([left, top])
    for rows in row_bands(0, bottom - top, right - left):
        layer[rows] = _nearest(b, warp, corner, rows, right - left)
    for points, values in _wall_marks(b, warp):
        mark_walls(layer, points - corner, values)
    x, y = b.pixel_to_map([left - 0.5, bottom - 0.5])
    return OccupancyGrid(layer, b.resolution, (float(x), float(y), b.origin[2]), b.frame)


def _nearest(b: OccupancyGrid, warp: Warp, corner: NDArray[np.int_], rows: slice, width: int) -> NDArray[np.int8]:
    """Read B's cells at a band of the new map, unknown outside."""
    v, u = np.mgrid[rows, :width]
    placed = warp.similarity.apply(np.stack([u, v], axis=-1) + corner)
    at = np.floor(warp.undo(placed) + 0.5).astype(np.intp)
    inside = ((at >= 0) & (at < b.shape[::-1])).all(axis=-1)
    read = b.occupancy[at[..., 1].clip(0, b.shape[0] - 1), at[..., 0].clip(0, b.shape[1] - 1)]
    values: NDArray[np.int8] = np.where(inside, read, UNKNOWN).astype(np.int8)
    return values


def _wall_marks(b: OccupancyGrid, warp: Warp) -> Iterator[tuple[NDArray[np.float64], NDArray[np.int8]]]:
    """Yield the places of B's wall cells after the warp, (N, 2), and their values; then those between neighbours."""
    walls = np.argwhere(b.occupied)  # (N, 2)
    values = b.occupancy[walls[:, 0], walls[:, 1]]
    back = warp.similarity.inverse()
    moved = back.apply(warp.apply(walls[:, ::-1]))
    yield moved, values
    row_step = b.shape[1] + 1  # a neighbour beyond the end of a row is none of the next row
    keys = walls @ [row_step, 1]  # ascending
    cells = np.floor(moved + TIE)
    for down, right in ((0, 1), (1, -1), (1, 0), (1, 1)):
        wanted = keys + down * row_step + right
        neighbour = np.searchsorted(keys, wanted).clip(max=len(keys) - 1)
        is_parted = (keys[neighbour] == wanted) & (np.abs(cells - cells[neighbour]).max(axis=1) > 1)
        parted = np.flatnonzero(is_parted)
        yield back.apply(warp.apply(walls[parted, ::-1] + np.array([right, down]) / 2)), values[parted]
