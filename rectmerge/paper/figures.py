"""Counterparts of the paper's figures 2 to 12, drawn from a trace of its method on any two maps."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from rectmerge.composing.compose import compose
from rectmerge.drawing.maps import (
    Picture,
    draw_map,
    draw_parallels,
    draw_rectangles,
    draw_series,
    draw_triangle,
    side_by_side,
)
from rectmerge.drawing.overlay import draw_overlay
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.paper.edges import largest_neighbours
from rectmerge.paper.iteration import Pass, overlay
from rectmerge.paper.orientation import Orientation
from rectmerge.paper.placed_image import PlacedImage
from rectmerge.paper.rmap import RMap
from rectmerge.paper.trace import Trace
from rectmerge.paper.triangles import corresponding
from rectmerge.rectangles import Rectangle

SIDE_PX = 590  # of a map: two side by side fill the width of a page
NUMBERED = 20  # rectangles, as in the paper
FIGURES = tuple(f"figure-{number:02d}.png" for number in range(2, 13))
MARGIN_CELLS = 4


def draw_figures(trace: Trace) -> dict[str, Picture]:
    """Draw figures 2 to 12, by file name."""
    return dict(zip(FIGURES, _figures(trace), strict=True))


def _figures(trace: Trace) -> Iterator[Picture]:
    first, last = trace.passes[0], final_pass(trace)
    yield _pair([draw_map(grid, side_px=SIDE_PX) for grid in trace.maps], "map {}")
    yield _pair(
        [_numbered(grid, found.rectangles) for grid, found in zip(trace.maps, trace.rmaps, strict=True)], "map {}"
    )
    yield _draw_neighbours(trace.maps[0], trace.rmaps[0])
    lines = [_parallels(grid, orientation) for grid, orientation in zip(trace.maps, trace.orientations, strict=True)]
    yield _pair(lines, "map {}")
    upright = [_upright(image, found.rectangles) for image, found in zip(first.images, first.rmaps, strict=True)]
    yield _pair([_numbered(*each) for each in upright], "map {}, upright")
    yield _draw_correspondence(trace)
    yield _draw_triangles(first, first.images)
    quarter = first.match.quarter_turns * math.pi / 2
    yield _draw_triangles(first, (first.images[0].turned(quarter), first.images[1]))
    yield _draw_triangles(last, last.images)
    yield _draw_merged(trace)
    yield draw_result(trace)


def final_pass(trace: Trace) -> Pass:
    """Return the pass whose placement is the answer's first candidate: the last one if the loop ended."""
    if trace.alignment.trace["ended"]:
        return trace.passes[-1]
    rescaling = [step for step in trace.passes if step.is_rescaling] or list(trace.passes)
    return min(rescaling, key=lambda step: abs(math.log(step.match.ratio)))


def draw_result(trace: Trace) -> Picture:
    """Draw two maps, the map merged of them by the paper's method, and their agreement (figures 1 and 12)."""
    a, b = trace.maps
    pixels = final_pass(trace).pixels
    merged = compose([a, b], [None, pixels_to_map_frame(pixels, a, b)]).grid
    pictures = [draw_map(grid, side_px=SIDE_PX) for grid in (a, b, merged)]
    pictures.append(draw_overlay(a, b, pixels, side_px=SIDE_PX))
    return side_by_side(pictures, ["map A", "map B", "merged", "agreement"])


def _draw_neighbours(grid: OccupancyGrid, found: RMap) -> Picture:
    """Draw the series of largest neighbours of rectangle 1, cut to where they lie (figure 4)."""
    series = {str(side): [0, *(label - 1 for label in labels)] for side, labels in largest_neighbours(found, 1).items()}
    boxes = found.rectangles
    shown = [boxes[i] for indices in series.values() for i in indices]
    window = (
        min(box.x for box in shown),
        min(box.y for box in shown),
        max(box.x + box.w for box in shown),
        max(box.y + box.h for box in shown),
    )
    part, moved = _cut(grid, boxes, window)
    return draw_series(part, moved, series, side_px=2 * SIDE_PX)


def _draw_correspondence(trace: Trace) -> Picture:
    """Draw three rectangles of map A, and those of map B that correspond to one of them (figure 7)."""
    step, method = trace.passes[0], trace.method
    boxes = [found.rectangles for found in step.rmaps]
    three = [label - 1 for label in step.match.triangles.first]
    alike = corresponding(step.rmaps[0].boxes[three], step.rmaps[1].boxes, **method.tolerance)
    large = step.rmaps[1].areas >= method.min_area_cells
    candidates = np.flatnonzero(large)[: method.max_rectangles]
    partners = [boxes[1][i] for i in candidates if alike[:, i].any()]
    pictures = [
        draw_triangle(*_upright(step.images[0], [boxes[0][i] for i in three]), side_px=SIDE_PX),
        draw_rectangles(*_upright(step.images[1], partners), side_px=SIDE_PX),
    ]
    return side_by_side(pictures, ["map A: three rectangles", f"map B: {len(partners)} that correspond to one of them"])


def _draw_triangles(step: Pass, images: Sequence[PlacedImage]) -> Picture:
    """Draw the shared triangles of a pass on its images, or on these turned by quarter turns (figures 8 to 10)."""
    labels = step.match.triangles.first, step.match.triangles.second
    pictures = []
    for image, matched, found, three in zip(images, step.images, step.rmaps, labels, strict=True):
        boxes = [_carried(found.rectangles[label - 1], matched, image) for label in three]
        pictures.append(draw_triangle(*_upright(image, boxes), side_px=SIDE_PX))
    return _pair(pictures, "map {}: shared triangle")


def _draw_merged(trace: Trace) -> Picture:
    """Draw map B on map A as the first match with Lambda_f = 0 has them without rescaling, and as the last has them."""
    last = final_pass(trace)
    same_scale = next((step for step in trace.passes if step.is_rescaling), last)
    placements = [overlay(same_scale.images, same_scale.match, 1.0), last.pixels]
    pictures = [draw_overlay(*trace.maps, pixels, side_px=SIDE_PX) for pixels in placements]
    return side_by_side(pictures, ["without rescaling", "with rescaling"])


def _pair(pictures: Sequence[Picture], caption: str) -> Picture:
    return side_by_side(pictures, [caption.format(name) for name in "AB"])


def _numbered(grid: OccupancyGrid, boxes: Sequence[Rectangle]) -> Picture:
    return draw_rectangles(grid, boxes, numbered=NUMBERED, side_px=SIDE_PX)


def _parallels(grid: OccupancyGrid, turn: Orientation) -> Picture:
    lines = [np.array(line, np.float64) - 0.5 for line in (turn.line, turn.facing_line)]  # corners to pixel centres
    return draw_parallels(grid, [(lines[0], lines[1])], turn.turn, side_px=SIDE_PX)


def _carried(box: Rectangle, before: PlacedImage, after: PlacedImage) -> Rectangle:
    """Carry a rectangle from an image to the same image turned by quarter turns."""
    corners: NDArray[np.float64] = np.array([[box.x, box.y], [box.x + box.w, box.y + box.h]], np.float64) - 0.5
    moved = np.rint((after.pose @ before.pose.inverse()).apply(corners) + 0.5).astype(int)
    (x, y), (w, h) = moved.min(axis=0).tolist(), np.ptp(moved, axis=0).tolist()
    return Rectangle(x, y, w, h)


def _upright(image: PlacedImage, boxes: Sequence[Rectangle]) -> tuple[OccupancyGrid, list[Rectangle]]:
    """Cut an image to what it knows, which is little of its canvas, and move its rectangles along."""
    grid = OccupancyGrid(image.cells)
    v, u = np.nonzero(~grid.unknown)
    return _cut(grid, boxes, (int(u.min()), int(v.min()), int(u.max()) + 1, int(v.max()) + 1))


def _cut(
    grid: OccupancyGrid, boxes: Sequence[Rectangle], window: tuple[int, int, int, int]
) -> tuple[OccupancyGrid, list[Rectangle]]:
    """Cut a map to a window (left, top, right, bottom) and a margin, and move rectangles along."""
    left, top = max(0, window[0] - MARGIN_CELLS), max(0, window[1] - MARGIN_CELLS)
    part = OccupancyGrid(grid.occupancy[top : window[3] + MARGIN_CELLS, left : window[2] + MARGIN_CELLS])
    return part, [Rectangle(box.x - left, box.y - top, box.w, box.h) for box in boxes]
