"""Trace of the paper's method on two maps: its R-maps, Lambdas, matches and ratios, kept for figures and tables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rectmerge.alignment import Alignment, Method
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.paper.edges import largest_neighbours
from rectmerge.paper.iteration import ConditionError, Pass
from rectmerge.paper.merging import Paper
from rectmerge.paper.orientation import Orientation, orthogonal_orientation
from rectmerge.paper.placed_image import PlacedImage
from rectmerge.paper.rmap import RMap


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """Two maps with every step that the paper's method took on them.

    Parameters
    ----------
    method
        The method, with its fields.
    maps
        Maps A and B, the paper's 1 and 2, as the method reads them.
    rmaps
        Their R-maps.
    orientations
        Results of Algorithm 3.
    passes
        Matches of the loop of Algorithm 5.
    alignment
        The answer of the method.
    """

    method: Paper
    maps: tuple[OccupancyGrid, OccupancyGrid]
    rmaps: tuple[RMap, RMap]
    orientations: tuple[Orientation, Orientation]
    passes: tuple[Pass, ...]
    alignment: Alignment


def trace_method(
    a: OccupancyGrid, b: OccupancyGrid, *, method: Method | None = None, scale: tuple[float, float] = (0.5, 2.0)
) -> Trace:
    """Run the paper's method on two maps and keep every step.

    Parameters
    ----------
    a, b
        The maps.
    method
        The method, by default `Paper` as it is.
    scale
        Bounds of the pixel scale.

    Raises
    ------
    ConditionError
        If a map does not meet one of the two conditions of the paper's conclusion; the message names it.
    InputError
        If the method is not one of the paper's.
    """
    method = method or Paper()
    if not isinstance(method, Paper):
        raise InputError(f"only the methods paper and paper-repaired have a trace, got {method.name!r}")
    maps = method.prepared(a), method.prepared(b)
    images = [PlacedImage.from_cells(grid.occupancy) for grid in maps]
    rmaps = [method.rectangles(image, name) for image, name in zip(images, "AB", strict=True)]
    orientations = [_orientation(method, found, name) for found, name in zip(rmaps, "AB", strict=True)]
    alignment, passes = method.align_in_steps(a, b, scale=scale)
    if not passes:
        raise ConditionError(alignment.reason)
    return Trace(
        method,
        maps,
        (rmaps[0], rmaps[1]),
        (orientations[0], orientations[1]),
        tuple(passes),
        alignment,
    )


def _orientation(method: Paper, rectangles: RMap, name: str) -> Orientation:
    """Return the result of Algorithm 3, or refuse a map without parallel edges."""
    orientation = orthogonal_orientation(
        rectangles,
        n_rectangles=method.n_rectangles,
        tau_cells=method.tau_cells,
        slope_tolerance_deg=method.slope_tolerance_deg,
        path_depth=method.path_depth or None,
        max_edge_points=method.max_edge_points,
        walled_share=method.walled_share,
    )
    if orientation is None:
        raise ConditionError(f"map {name} has no pair of parallel edges on facing sides of an empty space")
    return orientation


def neighbours_table(rectangles: RMap) -> str:
    """Return the series of largest neighbours of rectangle 1 as Markdown (Table I)."""
    series = largest_neighbours(rectangles, 1)
    longest = max(map(len, series.values()))
    heads = ["direction", *(str(number) for number in range(1, longest + 1))]
    rows = [[side, *map(str, labels), *[""] * (longest - len(labels))] for side, labels in series.items()]
    return markdown_table(heads, rows)


def passes_table(passes: Sequence[Pass]) -> str:
    """Return the numbers that section IV prints, one row per match, as Markdown."""
    heads = (
        *("iteration", "Lambda A", "Lambda B", "rectangles", "triangles", "Delta A", "Delta B"),
        *("min(J)", "Lambda_f", "ratio", "cumulative"),
    )
    return markdown_table(heads, [_row(step) for step in passes])


def _row(step: Pass) -> list[str]:
    angles = [f"{np.degrees(turn.angle):.4f}" for turn in step.turns]
    triangles = step.match.triangles
    deltas = ["{" + ", ".join(f"r{label}" for label in labels) + "}" for labels in (triangles.first, triangles.second)]
    return [
        str(step.iteration),
        *angles,
        " and ".join(str(len(found)) for found in step.rmaps),
        str(triangles.combinations),
        *deltas,
        f"{triangles.cost:.4f}",
        str(90 * step.match.quarter_turns),
        f"{step.match.ratio:.4f}" if step.is_rescaling else "-",
        f"{step.scale_after:.4f}",
    ]


def markdown_table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Lay out a table as Markdown."""
    return "\n".join(f"| {' | '.join(row)} |" for row in (heads, ["---"] * len(heads), *rows))
