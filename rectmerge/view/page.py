"""Page of one alignment: a file with both maps, the candidates, and the scripts to place B on A by hand."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from rectmerge.elastic.straightening import straighten
from rectmerge.elastic.transform import BentTransform
from rectmerge.grid import OccupancyGrid
from rectmerge.paper.rmap import rmap
from rectmerge.results.inputs import GREYS, Input
from rectmerge.similarity import Similarity
from rectmerge.view.embedding import as_script, package_text
from rectmerge.view.pictures import draw_pair, draw_straightened
from rectmerge.view.shown_alignment import ShownAlignment

MAX_SIDE_PIXELS = 1024  # of the pictures
MAX_RECTANGLES = 40  # of each map, the largest
SCRIPTS = ("widget.js", "placement.js", "gestures.js", "page.js")
MARKS = {"accepted": "✓", "ambiguous": "?", "rejected": "✕"}
MEANINGS = {
    "accepted": "Map B lies on map A as candidate 1 shows.",
    "ambiguous": "Step through the candidates: what the maps show does not decide between them.",
    "rejected": "No candidate is to be used unseen.",
}


def html(
    alignment: ShownAlignment,
    inputs: Sequence[Input],
    a: OccupancyGrid,
    b: OccupancyGrid,
    *,
    bend: BentTransform | None = None,
) -> str:
    """Return the page of an alignment.

    Parameters
    ----------
    alignment
        The alignment of the merge.
    inputs
        The files of A and B: the commands that the page offers name them.
    a, b
        The maps that were read from these files.
    bend
        The bend of B in the merge, if there is one: candidate 1 then fades between B with and without it.
    """
    names = [Path(map_input.given).name for map_input in inputs]
    data = {
        "maps": draw_pair(a, b, MAX_SIDE_PIXELS) | _straightened(bend, a, b),
        "frames": {"a": _frame(a), "b": _frame(b)},
        "unit": a.unit,
        "candidates": [candidate.as_dict() for candidate in alignment.candidates],
        "start": _start(a, b).matrix.ravel().tolist(),
        "rectangles": {"a": _rectangles(a), "b": _rectangles(b)},
        "words": _command_words(inputs),
    }
    return Template(package_text("page.html")).substitute(
        title=escape(f"{names[1]} on {names[0]}"),
        style=package_text("page.css"),
        verdict=alignment.verdict,
        mark=MARKS[alignment.verdict],
        reason=escape(alignment.reason),
        meaning=MEANINGS[alignment.verdict],
        method=escape(alignment.method),
        confidence="no" if alignment.confidence is None else f"{alignment.confidence:.2f}",
        percent=f"{100 * min(max(alignment.confidence or 0.0, 0.0), 1.0):.0f}",
        a=escape(names[0]),
        b=escape(names[1]),
        unit=a.unit,
        data=as_script(data),
        script="\n".join(map(package_text, SCRIPTS)),
    )


def _straightened(bend: BentTransform | None, a: OccupancyGrid, b: OccupancyGrid) -> dict[str, Any]:
    """Return the picture of B without its bend; nothing where there is none."""
    return {} if bend is None else draw_straightened(b, straighten(b, bend.between_pixels(a, b)), MAX_SIDE_PIXELS)


def _frame(grid: OccupancyGrid) -> list[float]:
    """Return the transform from a map's pixels to its map frame, six numbers, row by row: v is down and y up."""
    origin, along_u, along_v = grid.pixel_to_map([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    columns = (along_u - origin, along_v - origin, origin)
    return [float(column[row]) for row in (0, 1) for column in columns]


def _start(a: OccupancyGrid, b: OccupancyGrid) -> Similarity:
    """Place B's middle on A's, upright, by the resolutions: the start by hand if there is no candidate."""
    known = a.resolution is not None and b.resolution is not None
    scale = b.cell_size / a.cell_size if known else 1.0
    (height_a, width_a), (height_b, width_b) = a.shape, b.shape
    tx, ty = (width_a - 1 - scale * (width_b - 1)) / 2, (height_a - 1 - scale * (height_b - 1)) / 2
    return Similarity(scale, 0.0, tx, ty)


def _rectangles(grid: OccupancyGrid) -> list[list[int]]:
    """List the largest rectangles (x, y, w, h) into which Algorithm 2 divides the free space."""
    boxes: list[list[int]] = rmap(grid.free, max_rectangles=MAX_RECTANGLES).boxes.tolist() if grid.free.any() else []
    return boxes


def _command_words(inputs: Sequence[Input]) -> str:
    """Write the maps, and the options on how they are read, as words of a command line."""
    options = ["--strict-thresholds"] if any(map_input.strict for map_input in inputs) else []
    for grey in GREYS:
        levels = [level for map_input in inputs if (level := map_input.greys[grey]) is not None]
        options += [f"--{grey}={level}" for level in levels[:1]]
    dialects = dict.fromkeys(map_input.dialect for map_input in inputs)
    options += [f"--dialect={dialect}" for dialect in dialects if dialect]
    for name, map_input in zip("ab", inputs, strict=True):
        options += [] if map_input.resolution is None else [f"--resolution-{name}={map_input.resolution!r}"]
    return shlex.join([*(map_input.given for map_input in inputs), *options])
