"""Counterparts of the paper's figures 2 to 12 and Table I, drawn from our own buildings by the method `paper`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

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
from rectmerge.errors import SimulationError
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.io.atomic_file import replace_file
from rectmerge.methods import FREE_SCALE
from rectmerge.paper.edges import largest_neighbours
from rectmerge.paper.iteration import Pass, overlay
from rectmerge.paper.merging import Paper
from rectmerge.paper.orientation import Orientation, orthogonal_orientation
from rectmerge.paper.placed_image import PlacedImage
from rectmerge.paper.rmap import RMap, rmap
from rectmerge.paper.triangles import corresponding
from rectmerge.rectangles import Rectangle
from scenarios.execution.files import clear_folder
from scenarios.gallery.page_picture import small_png
from scenarios.pairs.pair import MapPair
from scenarios.pairs.paper_plan import simple_maps
from scenarios.suites.suite import load_suite

SIDE_PX = 590  # of a map: two beside each other fill a page's width
NUMBERED = 20  # rectangles, as in the paper
FIGURES = tuple(f"figure-{number:02d}.png" for number in range(2, 13))
TABLE = "table-1.md"
PRACTICAL_SEED = 0  # the first building of the suite headline whose maps `paper` merges rightly
MARGIN_CELLS = 4
# W is an identity matrix, as in the paper's example; doors are left out, as 10 cells do in the paper's
SIMPLE = Paper(min_area_cells=60, weights=(1.0, 1.0, 1.0, 1.0, 1.0))


@dataclass(frozen=True, slots=True, eq=False)
class Walked:
    """Two maps as the paper's method goes through them.

    Parameters
    ----------
    maps
        Maps A and B, the paper's 1 and 2.
    rmaps
        Their rectangles.
    turns
        What Algorithm 3 finds for each.
    passes
        Of the loop of Algorithm 5; the ratio of the last is 1.
    """

    maps: tuple[OccupancyGrid, OccupancyGrid]
    rmaps: tuple[RMap, RMap]
    turns: tuple[Orientation, Orientation]
    passes: tuple[Pass, ...]

    @classmethod
    def of(cls, a: OccupancyGrid, b: OccupancyGrid, method: Paper = SIMPLE) -> Walked:
        """Walk through the method.

        Raises
        ------
        RectMergeError
            If a condition of the paper is not met.
        SimulationError
            If the loop does not end at a ratio of 1.
        """
        found = rmap(a.free), rmap(b.free)
        turns = orthogonal_orientation(found[0]), orthogonal_orientation(found[1])
        passes = tuple(method.passes(a, b, scale=FREE_SCALE))
        if turns[0] is None or turns[1] is None or not math.isclose(passes[-1].match.ratio, 1.0, abs_tol=0.005):
            raise SimulationError("the paper's loop does not end on these maps: there is nothing to draw")
        return cls((a, b), found, (turns[0], turns[1]), passes)


def write_figures(folder: str | Path, *, force: bool = False, say: Callable[[str], None]) -> list[Path]:
    """Write all figures and the table, and return their files.

    Raises
    ------
    InputError
        If the folder holds earlier ones and `force` is off.
    SimulationError
        If the mission of figure 12 fails.
    """
    out = clear_folder(folder, () if force else (*FIGURES, TABLE), force=force)
    a, b, _ = simple_maps()
    simple = Walked.of(a, b)
    say("two robots explore an office, for figure 12 ...")
    pictures = [*_simple_figures(simple), draw_practical(practical_pair())]
    for name, picture in zip(FIGURES, pictures, strict=True):
        replace_file(out / name, small_png(picture))
    replace_file(out / TABLE, f"{neighbours_table(simple.rmaps[0])}\n".encode())
    return [out / name for name in (*FIGURES, TABLE)]


def practical_pair() -> MapPair:
    """Make the maps of figure 12: an office of the suite `headline`, without noise."""
    source = load_suite("headline").sources()[PRACTICAL_SEED]
    mission = replace(source.scenario.mission, rays="compiled")
    return next(replace(source, scenario=replace(source.scenario, noise=(0,), mission=mission)).pairs())


def neighbours_table(found: RMap) -> str:
    """Lay out the series of largest neighbours of rectangle 1 as Markdown (Table I)."""
    series = largest_neighbours(found, 1)
    longest = max(map(len, series.values()))
    heads = ["direction", *(str(number) for number in range(1, longest + 1))]
    rows = [[side, *map(str, labels), *[""] * (longest - len(labels))] for side, labels in series.items()]
    return "\n".join(f"| {' | '.join(row)} |" for row in (heads, ["---"] * len(heads), *rows))


def _simple_figures(walked: Walked) -> Iterator[Picture]:
    """Draw figures 2 to 11."""
    first, last = walked.passes[0], walked.passes[-1]
    boxes = [found.rectangles for found in first.rmaps]
    yield _pair([draw_map(grid, side_px=SIDE_PX) for grid in walked.maps], "map {}")
    as_given = [found.rectangles for found in walked.rmaps]
    yield _pair([_numbered(*each) for each in zip(walked.maps, as_given, strict=True)], "map {}")
    yield _draw_neighbours(walked.maps[0], walked.rmaps[0])
    yield _pair([_parallels(grid, turn) for grid, turn in zip(walked.maps, walked.turns, strict=True)], "map {}")
    yield _pair([_numbered(*_upright(*each)) for each in zip(first.images, boxes, strict=True)], "map {}, upright")
    yield _draw_correspondence(first)
    yield _draw_triangles(first, first.images)
    quarter = first.match.quarter_turns * math.pi / 2
    yield _draw_triangles(first, (first.images[0].turned(quarter), first.images[1]))
    yield _draw_triangles(last, last.images)
    yield _draw_merged(walked)


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


def _draw_correspondence(step: Pass) -> Picture:
    """Draw three rectangles of map A, and those of map B that correspond to one of them (figure 7)."""
    boxes = [found.rectangles for found in step.rmaps]
    three = [label - 1 for label in step.match.triangles.first]
    alike = corresponding(step.rmaps[0].boxes[three], step.rmaps[1].boxes, delta_cells=SIMPLE.delta_cells)
    large = step.rmaps[1].areas >= SIMPLE.min_area_cells
    partners = [boxes[1][i] for i in np.flatnonzero(alike.any(axis=0) & large)]
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


def _draw_merged(walked: Walked) -> Picture:
    """Draw map B on map A as the first pass has them, not rescaled, and as the last has them (figure 11)."""
    first = walked.passes[0]
    as_it_is = overlay(first.images, first.match, 1.0)
    placements = {"without rescaling": as_it_is, "with rescaling": walked.passes[-1].pixels}
    return side_by_side(
        [draw_overlay(*walked.maps, pixels, side_px=SIDE_PX) for pixels in placements.values()], [*placements]
    )


def draw_practical(pair: MapPair) -> Picture:
    """Draw two maps of robots and what the paper's method merges them to (figures 1 and 12).

    Raises
    ------
    SimulationError
        If the loop does not end on them.
    """
    last = Walked.of(pair.a, pair.b, Paper()).passes[-1]
    merged = compose([pair.a, pair.b], [None, pixels_to_map_frame(last.pixels, pair.a, pair.b)]).grid
    pictures = [draw_map(grid, side_px=SIDE_PX) for grid in (pair.a, pair.b, merged)]
    pictures.append(draw_overlay(pair.a, pair.b, last.pixels, side_px=SIDE_PX))
    return side_by_side(pictures, ["map A", "map B", "merged", "where they agree"])


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
