"""The page of one answer: a file that holds both maps, the candidates, and all it needs to lay B on A by hand."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template

from rectmerge.grid import OccupancyGrid
from rectmerge.paper.rmap import rmap
from rectmerge.results.inputs import GREYS, Input
from rectmerge.similarity import Similarity
from rectmerge.view.answer import ShownAnswer
from rectmerge.view.embedding import as_script, text_of
from rectmerge.view.pictures import draw_pair

SIDE = 1024  # pixels of the pictures, at the most
RECTANGLES = 40  # of each map, the largest
SCRIPTS = ("widget.js", "placement.js", "gestures.js", "page.js")
MARKS = {"accepted": "✓", "ambiguous": "?", "rejected": "✕"}
MEANINGS = {
    "accepted": "Map B lies on map A as candidate 1 shows.",
    "ambiguous": "Step through the candidates: what the maps show does not decide between them.",
    "rejected": "No candidate is to be used unseen.",
}


def html(answer: ShownAnswer, inputs: Sequence[Input], a: OccupancyGrid, b: OccupancyGrid) -> str:
    """Return the page of an answer.

    Parameters
    ----------
    answer
        The merge's.
    inputs
        Where A and B come from: their names stand in the commands that the page offers.
    a, b
        The maps, as they were read from there.
    """
    names = [Path(one.given).name for one in inputs]
    held = {
        "maps": draw_pair(a, b, SIDE),
        "frames": {"a": _frame(a), "b": _frame(b)},
        "unit": a.unit,
        "candidates": [candidate.as_dict() for candidate in answer.candidates],
        "start": _start(a, b).matrix.ravel().tolist(),
        "rectangles": {"a": _rectangles(a), "b": _rectangles(b)},
        "words": _words(inputs),
    }
    return Template(text_of("page.html")).substitute(
        title=escape(f"{names[1]} on {names[0]}"),
        style=text_of("page.css"),
        verdict=answer.verdict,
        mark=MARKS[answer.verdict],
        reason=escape(answer.reason),
        meaning=MEANINGS[answer.verdict],
        method=escape(answer.method),
        confidence="no" if answer.confidence is None else f"{answer.confidence:.2f}",
        percent=f"{100 * min(max(answer.confidence or 0.0, 0.0), 1.0):.0f}",
        a=escape(names[0]),
        b=escape(names[1]),
        unit=a.unit,
        data=as_script(held),
        script="\n".join(map(text_of, SCRIPTS)),
    )


def _frame(grid: OccupancyGrid) -> list[float]:
    """Return the way from a map's pixels to its map frame, six numbers, row by row: v is down and y up."""
    origin, along_u, along_v = grid.pixel_to_map([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    columns = (along_u - origin, along_v - origin, origin)
    return [float(column[row]) for row in (0, 1) for column in columns]


def _start(a: OccupancyGrid, b: OccupancyGrid) -> Similarity:
    """Place B's middle on A's, upright, by the resolutions: where a hand may start if there is no candidate."""
    known = a.resolution is not None and b.resolution is not None
    scale = b.cell_size / a.cell_size if known else 1.0
    (height_a, width_a), (height_b, width_b) = a.shape, b.shape
    tx, ty = (width_a - 1 - scale * (width_b - 1)) / 2, (height_a - 1 - scale * (height_b - 1)) / 2
    return Similarity(scale, 0.0, tx, ty)


def _rectangles(grid: OccupancyGrid) -> list[list[int]]:
    """List the largest rectangles (x, y, w, h) into which Algorithm 2 parts the free space."""
    boxes: list[list[int]] = rmap(grid.free, max_rectangles=RECTANGLES).boxes.tolist() if grid.free.any() else []
    return boxes


def _words(inputs: Sequence[Input]) -> str:
    """Write the maps, and how they are read, as words of a command line."""
    options = ["--strict-thresholds"] if any(one.strict for one in inputs) else []
    for grey in GREYS:
        named = [level for one in inputs if (level := one.greys[grey]) is not None]
        options += [f"--{grey}={level}" for level in named[:1]]
    options += [f"--dialect={dialect}" for dialect in dict.fromkeys(one.dialect for one in inputs) if dialect]
    for name, one in zip("ab", inputs, strict=True):
        options += [] if one.resolution is None else [f"--resolution-{name}={one.resolution!r}"]
    return shlex.join([*(one.given for one in inputs), *options])
