"""Picture of two maps laid over each other: agreement, conflict and the origins of both maps."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.overlap import CONFLICT_REACH_CELLS
from rectmerge.analysis.specks import small_patches
from rectmerge.composing.compose import find_conflict
from rectmerge.composing.resampling import known_ends, resample
from rectmerge.drawing.annotation import Spot, circle_spots, draw_origins, find_spots, with_scale_bar, with_title
from rectmerge.drawing.maps import (
    CONFLICT,
    SIDE_PX,
    UNKNOWN_GREY,
    WALL_A,
    WALL_B,
    Color,
    Picture,
    enlarge,
    with_legend,
    zoom_for,
)
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

ONLY_A, ONLY_B, BOTH, WALL_BOTH = (198, 223, 240), (250, 219, 186), (255, 255, 255), (0, 0, 0)
AGREEMENT_REACH_CELLS = 1.0  # of A, between walls that agree: turned cells do not lie on each other exactly
SPECK_CELLS = 3  # a patch of conflict of no more cells is noise, and gets no circle
MARGIN_PX, SMALLEST_PX = 24, 320  # a smaller picture has no room for its marks


def draw_overlay(
    a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity, *, side_px: int = SIDE_PX, title: str = ""
) -> Picture:
    """Draw B on A under a placement: cells known to one map, cells of agreement and cells of conflict.

    Parameters
    ----------
    a, b
        The maps.
    pixels
        From B's pixels to A's.
    side_px
        The longer side of the maps in the picture, at most; large maps are shrunk, small ones enlarged.
    title
        A line above the picture, such as the verdict.

    Returns
    -------
    NDArray
        RGB, shape (H, W, 3): A upright, with the largest spots of conflict circled (single cells, as from noise, are
        not) and both maps' origins, the legend and a scale bar below. The colours are safe for every colour vision.
    """
    (row, col), known = _cut(a)
    to_known = Similarity(tx=-float(col), ty=-float(row))
    zoom = enlarge(zoom_for(_extent(known, b, to_known @ pixels), max(1, side_px - 2 * MARGIN_PX)))
    (code_a, code_b), (top, left) = resample([known, b], [zoom, zoom @ to_known @ pixels])
    conflict = find_conflict([code_a, code_b], reach=max(1, round(CONFLICT_REACH_CELLS * zoom.scale)))
    reach_px = max(1, round(AGREEMENT_REACH_CELLS * zoom.scale))
    image = _framed(_paint(OccupancyGrid(code_a), OccupancyGrid(code_b), conflict, reach_px), min(side_px, SMALLEST_PX))
    single = small_patches(conflict, round(SPECK_CELLS * max(1.0, zoom.scale) ** 2))
    spots = find_spots(np.pad(conflict & ~single, MARGIN_PX))
    circled = circle_spots(image, spots)
    to_picture = Similarity(tx=float(left + MARGIN_PX), ty=float(top + MARGIN_PX)) @ zoom @ to_known
    axes = {"A": (WALL_A, _axes(a, to_picture)), "B": (WALL_B, _axes(b, to_picture @ pixels))}
    draw_origins(image, axes, ruler=(zoom.scale / a.cell_size, a.unit))
    framed = with_scale_bar(
        with_legend(image, _legend(spots, circled, bool(single.any()))), zoom.scale / a.cell_size, a.unit
    )
    return with_title(framed, title) if title else framed


def _cut(grid: OccupancyGrid) -> tuple[tuple[int, int], OccupancyGrid]:
    """Cut a grid to its known cells; return their first (row, col), and the cut, or all of it if none is known."""
    ends = known_ends(grid)
    if not len(ends):
        return (0, 0), grid
    (left, top), (right, bottom) = (
        np.rint(ends.min(axis=0) + 0.5).astype(int),
        np.rint(ends.max(axis=0) + 0.5).astype(int),
    )
    return (int(top), int(left)), OccupancyGrid(grid.occupancy[top:bottom, left:right])


def _paint(on_a: OccupancyGrid, on_b: OccupancyGrid, conflict: NDArray[np.bool_], reach_px: int) -> Picture:
    image = np.full((*on_a.shape, 3), UNKNOWN_GREY, np.uint8)
    image[on_a.free], image[on_b.free], image[on_a.free & on_b.free] = ONLY_A, ONLY_B, BOTH
    image[on_a.occupied], image[on_b.occupied] = WALL_A, WALL_B
    around = np.ones((2 * reach_px + 1, 2 * reach_px + 1), np.uint8)
    near_a, near_b = (cv2.dilate(grid.occupied.view(np.uint8), around) > 0 for grid in (on_a, on_b))
    image[(on_a.occupied & near_b) | (on_b.occupied & near_a)] = WALL_BOTH
    image[conflict] = CONFLICT
    return image


def _legend(spots: Sequence[Spot], circled: int, has_single: bool) -> dict[str, Color]:
    places = f"{circled} of {len(spots)} places" if circled < len(spots) else f"{circled} place" + "s" * (circled != 1)
    entries = {"free: A only": ONLY_A, "B only": ONLY_B, "both": BOTH}
    entries |= {"wall: A": WALL_A, "B": WALL_B, "both ": WALL_BOTH}  # names are keys: a space keeps both
    conflict = f"conflict, {places} circled" if spots else "conflict: single cells" if has_single else "conflict: none"
    return entries | {conflict: CONFLICT}


def _framed(image: Picture, smallest_px: int) -> Picture:
    """Put unknown space around a picture, more to the right and below where it is small."""
    down, right = (max(MARGIN_PX, smallest_px - MARGIN_PX - side) for side in image.shape[:2])
    framed = np.full((image.shape[0] + MARGIN_PX + down, image.shape[1] + MARGIN_PX + right, 3), UNKNOWN_GREY, np.uint8)
    framed[MARGIN_PX:-down, MARGIN_PX:-right] = image
    return framed


def _axes(grid: OccupancyGrid, to_picture: Similarity) -> NDArray[np.float64]:
    """Return the map frame's origin and unit vectors along x and y in the picture, shape (3, 2)."""
    size = grid.cell_size
    origin, *ends = to_picture.apply(grid.map_to_pixel([[0.0, 0.0], [size, 0.0], [0.0, size]]))
    return np.stack([origin, *((end - origin) / math.hypot(*(end - origin)) for end in ends)])


def _extent(a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity) -> tuple[float, float]:
    """Return height and width, in cells of A, of the box around A and the known cells of B."""
    points = np.concatenate([pixels.apply(known_ends(b)), [[-0.5, -0.5], np.array(a.shape[::-1]) - 0.5]])
    width, height = np.ptp(points, axis=0).tolist()
    return height, width
