"""Pictures of maps: two laid over each other, their conflicts, and the rectangles of the paper's figures 3 to 6."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.composition import Composition, find_conflict
from rectmerge.grid import OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.overlap import CONFLICT_REACH_CELLS
from rectmerge.rectangles import Rectangle
from rectmerge.resampling import resample
from rectmerge.similarity import Similarity

Picture = NDArray[np.uint8]
Color = tuple[int, int, int]

SIDE_PX = 1200  # the longer side of a map in a picture, at most; small maps are enlarged
LARGEST_ZOOM = 16
LEGEND_PX = 34
UNKNOWN_GREY, FREE_WHITE, WALL_BLACK = (205, 205, 205), (255, 255, 255), (0, 0, 0)
ONLY_A, ONLY_B, BOTH = (189, 215, 238), (252, 221, 178), (219, 240, 208)
WALL_A, WALL_B, WALL_BOTH, CONFLICT = (23, 84, 166), (201, 98, 0), (0, 0, 0), (220, 0, 60)
YELLOW, PINK, GREEN = (214, 158, 0), (222, 50, 150), (18, 128, 60)
SERIES: tuple[Color, ...] = (WALL_A, WALL_B, GREEN, (136, 34, 168))


def draw_overlay(a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity, *, side_px: int = SIDE_PX) -> Picture:
    """Draw B on A under a placement: what each knows alone, where they agree and where they contradict each other.

    Parameters
    ----------
    a, b
        The maps.
    pixels
        From B's pixels to A's.
    side_px
        The longer side, at most, of this picture and of the others in this module.

    Returns
    -------
    NDArray
        RGB, shape (H, W, 3), with A upright and a legend below.
    """
    zoom = _enlarge(_zoom(_extent(a, b, pixels), side_px))
    (code_a, code_b), _ = resample([a, b], [zoom, zoom @ pixels])
    on_a, on_b = OccupancyGrid(code_a), OccupancyGrid(code_b)
    reach = max(1, round(CONFLICT_REACH_CELLS * zoom.scale))
    image = np.full((*code_a.shape, 3), UNKNOWN_GREY, np.uint8)
    image[on_a.free], image[on_b.free], image[on_a.free & on_b.free] = ONLY_A, ONLY_B, BOTH
    image[on_a.occupied], image[on_b.occupied] = WALL_A, WALL_B
    image[on_a.occupied & on_b.occupied] = WALL_BOTH
    image[find_conflict([code_a, code_b], reach=reach)] = CONFLICT
    entries = {"A only": ONLY_A, "B only": ONLY_B, "both free": BOTH, "wall A": WALL_A, "wall B": WALL_B}
    return with_legend(image, entries | {"wall both": WALL_BOTH, "conflict": CONFLICT})


def draw_conflict(composition: Composition) -> Picture:
    """Draw a merged map with the cells where its sources contradict each other in red, widened to be seen."""
    grid, zoom = composition.grid, _enlarge(_zoom(composition.grid.shape))
    marks = OccupancyGrid(np.where(composition.conflict, OCCUPIED, UNKNOWN).astype(np.int8))
    (codes, spots), _ = resample([grid, marks], [zoom, zoom])
    image = _shade(codes)
    image[cv2.dilate((spots == OCCUPIED).view(np.uint8), np.ones((3, 3), np.uint8)) > 0] = CONFLICT
    known = int((grid.free | grid.occupied).sum())
    label = f"conflict: {int(composition.conflict.sum())} of {known} known cells"
    return with_legend(image, {label: CONFLICT, "free": FREE_WHITE, "wall": WALL_BLACK, "unknown": UNKNOWN_GREY})


def draw_map(grid: OccupancyGrid, *, side_px: int = SIDE_PX) -> Picture:
    """Draw a map as ROS shows it: free white, walls black, unknown grey; walls survive where it is made smaller."""
    (codes,), _ = resample([grid], [_enlarge(_zoom(grid.shape, side_px))])
    return _shade(codes)


def draw_rectangles(
    grid: OccupancyGrid, rectangles: Sequence[Rectangle], *, numbered: int = 20, side_px: int = SIDE_PX
) -> Picture:
    """Draw the rectangles of a map, numbering the first ones from 1 (figure 3)."""
    image, zoom = draw_map(grid, side_px=side_px), _zoom(grid.shape, side_px)
    tint = image.copy()
    for i, box in enumerate(rectangles):
        cv2.rectangle(tint, *_corners(box, zoom), _hue(i), cv2.FILLED)
    image = cv2.addWeighted(tint, 0.35, image, 0.65, 0.0).astype(np.uint8)
    for i, box in enumerate(rectangles):
        cv2.rectangle(image, *_corners(box, zoom), _hue(i, dark=True), 1)
    for i, box in enumerate(rectangles[:numbered]):
        _write_in(image, box, str(i + 1), zoom)
    return image


def draw_series(
    grid: OccupancyGrid,
    rectangles: Sequence[Rectangle],
    series: Mapping[str, Sequence[int]],
    *,
    side_px: int = SIDE_PX,
) -> Picture:
    """Draw series of largest neighbours (figure 4, table I), one colour per direction.

    Parameters
    ----------
    grid
        The map.
    rectangles
        Its rectangles in order.
    series
        By direction, the indices of the rectangles from the starting one outwards, from 0.
    """
    image, zoom = draw_map(grid, side_px=side_px), _zoom(grid.shape, side_px)
    for color, indices in zip(SERIES, series.values(), strict=False):
        for i in indices:
            cv2.rectangle(image, *_corners(rectangles[i], zoom), color, 2)
        path = np.array([_centre(rectangles[i], zoom) for i in indices], np.int32).reshape(-1, 1, 2)
        cv2.polylines(image, [path], isClosed=False, color=color, thickness=2, lineType=cv2.LINE_AA)
    for index in {i: None for indices in series.values() for i in indices}:
        _write_in(image, rectangles[index], str(index + 1), zoom)
    return with_legend(image, dict(zip(series, SERIES, strict=False)))


def draw_triangle(grid: OccupancyGrid, rectangles: Sequence[Rectangle], *, side_px: int = SIDE_PX) -> Picture:
    """Draw three rectangles of a map, numbered in order, and the triangle of their centres (figures 8 to 10)."""
    image, zoom = draw_map(grid, side_px=side_px), _zoom(grid.shape, side_px)
    for box in rectangles:
        cv2.rectangle(image, *_corners(box, zoom), GREEN, 2)
    path = np.array([_centre(box, zoom) for box in rectangles], np.int32).reshape(-1, 1, 2)
    cv2.polylines(image, [path], isClosed=True, color=GREEN, thickness=2, lineType=cv2.LINE_AA)
    for number, box in enumerate(rectangles, start=1):
        _write_in(image, box, str(number), zoom)
    return image


def draw_parallels(
    grid: OccupancyGrid,
    pairs: Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]],
    angle: float,
    *,
    side_px: int = SIDE_PX,
) -> Picture:
    """Draw pairs of parallel edge lines, yellow and pink (figure 5), and the axes that `angle` makes upright.

    Parameters
    ----------
    grid
        The map.
    pairs
        Two segments per pair, each of shape (2, 2): end points (u, v) in pixels of the map.
    angle
        Radians, counter-clockwise: the turn that puts the building upright (the paper's Lambda).
    """
    image, zoom = draw_map(grid, side_px=side_px), _zoom(grid.shape, side_px)
    enlarge = _enlarge(zoom)
    for pair in pairs:
        for segment, color in zip(pair, (YELLOW, PINK), strict=True):
            start, end = np.rint(enlarge.apply(segment)).astype(int).tolist()
            cv2.line(image, start, end, color, 2, cv2.LINE_AA)
    _draw_axes(image, angle)
    turn = f"upright after {math.degrees(angle):+.2f} deg"
    return with_legend(image, {"edge": YELLOW, "its parallel": PINK, turn: CONFLICT})


def beside(pictures: Sequence[Picture], captions: Sequence[str], *, columns: int = 2) -> Picture:
    """Set pictures side by side in rows of `columns`, each under its caption."""
    height, width = (max(picture.shape[i] for picture in pictures) for i in (0, 1))
    tiles = []
    for picture, caption in zip(pictures, captions, strict=True):
        tile = np.full((height + LEGEND_PX + 12, width + 12, 3), 255, np.uint8)
        tile[LEGEND_PX + 6 : LEGEND_PX + 6 + picture.shape[0], 6 : 6 + picture.shape[1]] = picture
        _text(tile, caption, (8, LEGEND_PX - 8), 0.6)
        tiles.append(tile)
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % columns)
    rows = [np.hstack(tiles[i : i + columns]) for i in range(0, len(tiles), columns)]
    return np.vstack(rows)


def _extent(a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity) -> tuple[float, float]:
    height, width = b.shape
    corners = pixels.apply([[0, 0], [width, 0], [0, height], [width, height]])
    low, high = np.minimum(corners.min(axis=0), 0), np.maximum(corners.max(axis=0), a.shape[::-1])
    width, height = (high - low).tolist()
    return height, width


def _zoom(shape: tuple[float, float], side_px: int = SIDE_PX) -> float:
    """Return pixels of the picture per cell: a multiple of a half, or less than 1 for a large map."""
    zoom = min(LARGEST_ZOOM, side_px / max(shape))
    return math.floor(2 * zoom) / 2 if zoom >= 1 else zoom


def _enlarge(zoom: float) -> Similarity:
    """Return the similarity from pixel centres of a map to those of its enlarged picture."""
    return Similarity(zoom, 0.0, (zoom - 1) / 2, (zoom - 1) / 2)


def _shade(codes: NDArray[np.int8]) -> Picture:
    shown = OccupancyGrid(codes)
    image = np.full((*codes.shape, 3), UNKNOWN_GREY, np.uint8)
    image[shown.free], image[shown.occupied] = FREE_WHITE, WALL_BLACK
    return image


def _corners(box: Rectangle, zoom: float) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the first and the last pixel of a rectangle in the picture."""
    left, top = round(box.x * zoom), round(box.y * zoom)
    right, bottom = round((box.x + box.w) * zoom) - 1, round((box.y + box.h) * zoom) - 1
    return (left, top), (max(left, right), max(top, bottom))


def _centre(box: Rectangle, zoom: float) -> tuple[int, int]:
    return round((box.x + box.w / 2) * zoom), round((box.y + box.h / 2) * zoom)


def _hue(index: int, *, dark: bool = False) -> Color:
    """Return a hue, far from those of its neighbours in order; the darker one for an outline."""
    hsv = np.array([[[index * 67 % 180, 150 if dark else 200, 120 if dark else 255]]], np.uint8)
    red, green, blue = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0, 0].tolist()
    return red, green, blue


def _write_in(image: Picture, box: Rectangle, text: str, zoom: float) -> None:
    """Write a number in the middle of a rectangle, as large as fits and never too small to read."""
    (width, height), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 1.0, 1)
    room = min(0.8 * box.w * zoom / width, 0.8 * box.h * zoom / height)
    size = min(1.0, max(0.4, room))
    u, v = _centre(box, zoom)
    _text(image, text, (round(u - size * width / 2), round(v + size * height / 2)), size)


def _text(image: Picture, text: str, at: tuple[int, int], size: float) -> None:
    for color, thickness in (((255, 255, 255), 3), ((0, 0, 0), 1)):  # a white rim keeps it legible on any ground
        cv2.putText(image, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, color, thickness, cv2.LINE_AA)


def _draw_axes(image: Picture, angle: float) -> None:
    """Draw the directions that become right and up when the map is turned by `angle`."""
    centre = np.array([image.shape[1] / 2, image.shape[0] / 2])
    length = 0.3 * min(image.shape[:2])
    for quarter in (0.0, math.pi / 2):
        along = np.array([math.cos(quarter - angle), -math.sin(quarter - angle)])  # v points down
        start, end = (np.rint(centre + sign * length * along).astype(int).tolist() for sign in (-1, 1))
        cv2.arrowedLine(image, start, end, CONFLICT, 2, cv2.LINE_AA, tipLength=0.05)


def with_legend(image: Picture, entries: Mapping[str, Color]) -> Picture:
    """Add a strip that names the colours below a picture, widening it where the names need room."""
    widths = [46 + cv2.getTextSize(name, cv2.FONT_HERSHEY_SIMPLEX, 0.5, 1)[0][0] for name in entries]
    height, width = image.shape[0], max(image.shape[1], sum(widths) + 8)
    framed = np.full((height + LEGEND_PX, width, 3), 255, np.uint8)
    framed[:height, : image.shape[1]] = image
    left = 8
    for (name, color), step in zip(entries.items(), widths, strict=True):
        cv2.rectangle(framed, (left, height + 9), (left + 20, height + 25), color, cv2.FILLED)
        cv2.rectangle(framed, (left, height + 9), (left + 20, height + 25), (90, 90, 90), 1)
        cv2.putText(framed, name, (left + 26, height + 22), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 0, 0), 1, cv2.LINE_AA)
        left += step
    return framed
