"""Pictures of single maps, their conflicts, and the rectangles of the paper's figures 3 to 6."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.composing.compose import Composition
from rectmerge.composing.resampling import resample
from rectmerge.grid import OCCUPIED, UNKNOWN, OccupancyGrid
from rectmerge.rectangles import Rectangle
from rectmerge.similarity import Similarity

Picture = NDArray[np.uint8]
Color = tuple[int, int, int]

SIDE_PX = 1200  # the longer side of a map in a picture, at most; small maps are enlarged
LARGEST_ZOOM = 16
LEGEND_PX = 34
FONT = cv2.FONT_HERSHEY_SIMPLEX
UNKNOWN_GREY, FREE_WHITE, WALL_BLACK = (205, 205, 205), (255, 255, 255), (0, 0, 0)
# Blue, vermilion and purple of M. Okabe and K. Ito: safe for every colour vision.
WALL_A, WALL_B, CONFLICT = (0, 114, 178), (213, 94, 0), (204, 121, 167)
YELLOW, PINK, GREEN = (214, 158, 0), (222, 50, 150), (18, 128, 60)
SERIES: tuple[Color, ...] = (WALL_A, WALL_B, GREEN, (136, 34, 168))


def draw_conflict(composition: Composition) -> Picture:
    """Draw a merged map with its cells of conflict in colour, widened for visibility."""
    grid, zoom = composition.grid, enlarge(zoom_for(composition.grid.shape))
    marks = OccupancyGrid(composition.conflict.view(np.int8) * np.int8(OCCUPIED - UNKNOWN) + np.int8(UNKNOWN))
    (codes, spots), _ = resample([grid, marks], [zoom, zoom])
    image = _shade(codes)
    image[cv2.dilate((spots == OCCUPIED).view(np.uint8), np.ones((3, 3), np.uint8)) > 0] = CONFLICT
    known = np.count_nonzero(grid.free) + np.count_nonzero(grid.occupied)
    label = f"conflict: {np.count_nonzero(composition.conflict)} of {known} known cells"
    return with_legend(image, {label: CONFLICT, "free": FREE_WHITE, "wall": WALL_BLACK, "unknown": UNKNOWN_GREY})


def draw_map(grid: OccupancyGrid, *, side_px: int = SIDE_PX) -> Picture:
    """Draw a map in the colours of ROS: free white, walls black, unknown grey; walls survive shrinking."""
    (codes,), _ = resample([grid], [enlarge(zoom_for(grid.shape, side_px))])
    return _shade(codes)


def draw_rectangles(
    grid: OccupancyGrid, rectangles: Sequence[Rectangle], *, numbered: int = 20, side_px: int = SIDE_PX
) -> Picture:
    """Draw the rectangles of a map, numbering the first ones from 1 (figure 3)."""
    image, zoom = draw_map(grid, side_px=side_px), zoom_for(grid.shape, side_px)
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
    numbered: int | None = None,
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
    numbered
        Number of rectangles of each series that bear their number; None for all. Outer ones are often too small.
    """
    image, zoom = draw_map(grid, side_px=side_px), zoom_for(grid.shape, side_px)
    for color, indices in zip(SERIES, series.values(), strict=False):
        for i in indices:
            cv2.rectangle(image, *_corners(rectangles[i], zoom), color, 2)
        path = np.array([_centre(rectangles[i], zoom) for i in indices], np.int32).reshape(-1, 1, 2)
        cv2.polylines(image, [path], isClosed=False, color=color, thickness=2, lineType=cv2.LINE_AA)
    for index in {i: None for indices in series.values() for i in indices[:numbered]}:
        _write_in(image, rectangles[index], str(index + 1), zoom)
    return with_legend(image, dict(zip(series, SERIES, strict=False)))


def draw_triangle(grid: OccupancyGrid, rectangles: Sequence[Rectangle], *, side_px: int = SIDE_PX) -> Picture:
    """Draw three rectangles of a map, numbered in order, and the triangle of their centres (figures 8 to 10)."""
    image, zoom = draw_map(grid, side_px=side_px), zoom_for(grid.shape, side_px)
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
    """Draw pairs of parallel edge lines, yellow and pink (figure 5), and the axes made upright by `angle`.

    Parameters
    ----------
    grid
        The map.
    pairs
        Two segments per pair, each of shape (2, 2): end points (u, v) in pixels of the map.
    angle
        Radians, counter-clockwise: the turn that puts the building upright (the paper's Lambda).
    """
    image, zoom = draw_map(grid, side_px=side_px), zoom_for(grid.shape, side_px)
    larger = enlarge(zoom)
    for pair in pairs:
        for segment, color in zip(pair, (YELLOW, PINK), strict=True):
            start, end = np.rint(larger.apply(segment)).astype(int).tolist()
            cv2.line(image, start, end, color, 2, cv2.LINE_AA)
    _draw_axes(image, angle)
    turn = f"upright after {math.degrees(angle):+.2f} deg"
    return with_legend(image, {"edge": YELLOW, "its parallel": PINK, turn: CONFLICT})


def side_by_side(pictures: Sequence[Picture], captions: Sequence[str], *, columns: int = 2) -> Picture:
    """Join pictures side by side in rows of `columns`, each under its caption."""
    height, width = (max(picture.shape[i] for picture in pictures) for i in (0, 1))
    tiles = []
    for picture, caption in zip(pictures, captions, strict=True):
        tile = np.full((height + LEGEND_PX + 12, width + 12, 3), 255, np.uint8)
        tile[LEGEND_PX + 6 : LEGEND_PX + 6 + picture.shape[0], 6 : 6 + picture.shape[1]] = picture
        write(tile, caption, (8, LEGEND_PX - 8), 0.6)
        tiles.append(tile)
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % columns)
    rows = [np.hstack(tiles[i : i + columns]) for i in range(0, len(tiles), columns)]
    return np.vstack(rows)


def zoom_for(shape: tuple[float, float], side_px: int = SIDE_PX) -> float:
    """Return the pixels per cell in a picture of a map of `shape`: a multiple of a half, or less than 1 if large."""
    zoom = min(LARGEST_ZOOM, side_px / max(shape))
    return math.floor(2 * zoom) / 2 if zoom >= 1 else zoom


def enlarge(zoom: float) -> Similarity:
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
    """Return a colour that differs from its neighbours' in order; a darker one for an outline."""
    hsv = np.array([[[index * 67 % 180, 150 if dark else 200, 120 if dark else 255]]], np.uint8)
    red, green, blue = cv2.cvtColor(hsv, cv2.COLOR_HSV2RGB)[0, 0].tolist()
    return red, green, blue


def _write_in(image: Picture, box: Rectangle, text: str, zoom: float) -> None:
    """Write a number in the middle of a rectangle, as large as fits but always legible."""
    (width, height), _ = cv2.getTextSize(text, FONT, 1.0, 1)
    room = min(0.8 * box.w * zoom / width, 0.8 * box.h * zoom / height)
    size = min(1.0, max(0.4, room))
    u, v = _centre(box, zoom)
    write(image, text, (round(u - size * width / 2), round(v + size * height / 2)), size)


def write(image: Picture, text: str, at: tuple[int, int], size: float, color: Color = WALL_BLACK) -> None:
    """Write a line with its lower left end at (u, v), and with a white rim for legibility on any ground."""
    for ink, thickness in ((FREE_WHITE, 3), (color, 1)):
        cv2.putText(image, text, at, FONT, size, ink, thickness, cv2.LINE_AA)


def _draw_axes(image: Picture, angle: float) -> None:
    """Draw the axes that become right and up when the map is turned by `angle`."""
    centre = np.array([image.shape[1] / 2, image.shape[0] / 2])
    length = 0.3 * min(image.shape[:2])
    for quarter in (0.0, math.pi / 2):
        along = np.array([math.cos(quarter - angle), -math.sin(quarter - angle)])  # v points down
        start, end = (np.rint(centre + sign * length * along).astype(int).tolist() for sign in (-1, 1))
        cv2.arrowedLine(image, start, end, CONFLICT, 2, cv2.LINE_AA, tipLength=0.05)


def with_legend(image: Picture, entries: Mapping[str, Color]) -> Picture:
    """Add a strip below a picture that names its colours, wrapped into rows."""
    steps = [46 + cv2.getTextSize(name, FONT, 0.5, 1)[0][0] for name in entries]
    width = max(image.shape[1], max(steps) + 8)
    places, left, top = [], 8, image.shape[0]
    for step in steps:
        if left > 8 and left + step > width:
            left, top = 8, top + LEGEND_PX
        places.append((left, top))
        left += step
    framed = np.full((top + LEGEND_PX, width, 3), 255, np.uint8)
    framed[: image.shape[0], : image.shape[1]] = image
    for (name, color), (u, v) in zip(entries.items(), places, strict=True):
        cv2.rectangle(framed, (u, v + 9), (u + 20, v + 25), color, cv2.FILLED)
        cv2.rectangle(framed, (u, v + 9), (u + 20, v + 25), (90, 90, 90), 1)
        cv2.putText(framed, name, (u + 26, v + 22), FONT, 0.5, (0, 0, 0), 1, cv2.LINE_AA)
    return framed
