"""Command `rectmerge check`."""

from __future__ import annotations

from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.cli.app import Json
from rectmerge.cli.map_options import MapA, MapB, PairOptions
from rectmerge.cli.method_options import MethodOptions

PixelsText = Annotated[
    str, typer.Option("--pixels", metavar="A,B,TX,TY", help="The placement, from B's pixels to A's; or six numbers.")
]


def check(
    a: MapA,
    b: MapB,
    pixels: PixelsText,
    solving: MethodOptions,
    reading: PairOptions,
    json: Json = False,
) -> None:
    """Judge a placement by hand, with the verdict that `merge` would give it; writes no file.

    The placement is refined nearby and then compared with all others; where nothing fits nearby, the better placement
    is printed. The numbers are those of `rectmerge view`: pixel (u, v) of B lies on pixel
    (a u - b v + tx, b u + a v + ty) of A.
    """
    from rectmerge.aligning import check as judge
    from rectmerge.analysis.displacement import displacement_cells
    from rectmerge.cli.map_options import read_maps
    from rectmerge.cli.placement_options import parse_pixels
    from rectmerge.io.json_text import to_json
    from rectmerge.results.alignment_json import to_json_dict
    from rectmerge.results.summary import describe, describe_check

    placement, scale, method = parse_pixels(pixels), solving.parse_scale(), solving.make_method()
    grid_a, grid_b = read_maps(reading.pair(a, b))
    judged = judge(grid_a, grid_b, placement, method=method, scale=scale, seed=solving.seed)
    if json:
        moved = displacement_cells(grid_b, placement, judged.candidates[0].pixels) if judged.candidates else None
        typer.echo(to_json(to_json_dict(judged, grid_a, grid_b) | {"moved_cells": moved}))
    else:
        console.tell("\n".join([describe(judged, is_given=True), *describe_check(judged, grid_b, placement)]))
    raise typer.Exit(console.STATUS[judged.verdict])
