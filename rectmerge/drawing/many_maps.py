"""Pictures of many maps: all of a component laid over each other, and the graph of what belongs together."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from rectmerge.composing.resampling import known_ends, resample
from rectmerge.drawing.annotation import with_scale_bar, with_title
from rectmerge.drawing.maps import (
    CONFLICT,
    FREE_WHITE,
    GREEN,
    SIDE_PX,
    UNKNOWN_GREY,
    WALL_A,
    WALL_B,
    Color,
    Picture,
    draw_map,
    enlarge,
    with_legend,
    write,
    zoom_for,
)
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

WALLS: tuple[Color, ...] = (
    WALL_A, WALL_B, (0, 158, 115), CONFLICT, (86, 180, 233), (230, 159, 0), (90, 90, 90), (120, 60, 0)
)  # fmt: skip
MAX_NAMED = 16  # maps in the legend
THUMBNAIL_PX, SMALLEST_PX = 150, 48
DASH_PX = 8


def draw_many(maps: Mapping[str, OccupancyGrid], pixels: Mapping[str, Similarity], *, title: str = "") -> Picture:
    """Draw the walls of several maps on each other, each map in its colour, the first on top.

    Parameters
    ----------
    maps
        The maps by name, the reference first.
    pixels
        From each map's pixels to the reference's.
    title
        A line above the picture.

    Returns
    -------
    NDArray
        RGB, shape (H, W, 3). There are eight colours, which repeat.
    """
    ends = np.concatenate([pixels[name].apply(known_ends(grid)) for name, grid in maps.items()])
    corner, extent = ends.min(axis=0), np.ptp(ends, axis=0)
    zoom = enlarge(zoom_for((float(extent[1]), float(extent[0])), SIDE_PX))
    to_picture = zoom @ Similarity(tx=-float(corner[0]) - 0.5, ty=-float(corner[1]) - 0.5)
    layers, _ = resample(list(maps.values()), [to_picture @ pixels[name] for name in maps])
    image = np.full((*layers[0].shape, 3), UNKNOWN_GREY, np.uint8)
    for layer in layers:
        image[OccupancyGrid(layer).free] = FREE_WHITE
    for index, layer in reversed(list(enumerate(layers))):
        image[OccupancyGrid(layer).occupied] = WALLS[index % len(WALLS)]
    entries = {name: WALLS[index % len(WALLS)] for index, name in enumerate(list(maps)[:MAX_NAMED])}
    if len(maps) > MAX_NAMED:
        entries[f"and {len(maps) - MAX_NAMED} more"] = FREE_WHITE
    first = next(iter(maps.values()))
    framed = with_scale_bar(with_legend(image, entries), zoom.scale / first.cell_size, first.unit)
    return with_title(framed, title) if title else framed


@dataclass(frozen=True, slots=True, kw_only=True)
class Edge:
    """Line between two maps of a graph, drawn in a colour, dashed or whole."""

    a: str
    b: str
    color: Color
    is_dashed: bool = False
    is_thick: bool = False


EDGE_LEGEND: Mapping[str, Color] = {
    "used": WALL_A, "promoted by others": GREEN, "bridge, rests on one pair": CONFLICT, "thrown out (dashed)": WALL_B
}  # fmt: skip


def draw_graph(maps: Mapping[str, OccupancyGrid], edges: Sequence[Edge], *, title: str = "") -> Picture:
    """Draw maps as thumbnails around a circle, in the order given, with lines between them.

    Parameters
    ----------
    maps
        The maps by name; those of a component side by side.
    edges
        Lines between them.
    title
        A line above the picture.
    """
    side = max(SMALLEST_PX, min(THUMBNAIL_PX, int(2.2 * SIDE_PX / (len(maps) + 3))))
    radius = max(1.5 * side, (side + 40) * len(maps) / (2 * math.pi))
    middle = radius + side
    image = np.full((round(2 * middle), round(2 * middle), 3), 255, np.uint8)
    turns = (2 * math.pi * index / len(maps) - math.pi / 2 for index in range(len(maps)))
    at = {
        name: np.array([middle + radius * math.cos(turn), middle + radius * math.sin(turn)])
        for name, turn in zip(maps, turns, strict=True)
    }
    for edge in edges:
        steps = max(1, int(np.hypot(*(at[edge.b] - at[edge.a])) / DASH_PX)) if edge.is_dashed else 1
        stops = np.linspace(at[edge.a], at[edge.b], 2 * (steps // 2) + 2)
        for start, end in zip(stops[::2], stops[1::2], strict=True):
            first, last = (np.rint(stop).astype(int).tolist() for stop in (start, end))
            cv2.line(image, first, last, edge.color, 4 if edge.is_thick else 2, cv2.LINE_AA)
    for name, grid in maps.items():
        thumbnail = draw_map(grid, side_px=side)[:side, :side]
        height, width = thumbnail.shape[:2]
        left, top = np.rint(at[name] - [width / 2, height / 2]).astype(int).tolist()
        image[top : top + height, left : left + width] = thumbnail
        cv2.rectangle(image, (left - 1, top - 1), (left + width, top + height), (90, 90, 90), 1)
        write(image, name, (max(2, left), top + height + 16), 0.45)
    framed = with_legend(image, EDGE_LEGEND)
    return with_title(framed, title) if title else framed
