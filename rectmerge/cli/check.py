"""The command `rectmerge check`."""

from __future__ import annotations

from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.cli.map_options import DialectName, Grey, MapA, MapB, Resolution, Strict
from rectmerge.cli.method_options import Fields, MethodName, ScaleText, Seed

PixelsText = Annotated[
    str, typer.Option("--pixels", metavar="A,B,TX,TY", help="The placement, from B's pixels to A's; or six numbers.")
]


def check(
    a: MapA,
    b: MapB,
    pixels: PixelsText,
    method: MethodName = None,
    scale: ScaleText = "auto",
    seed: Seed = 0,
    fields: Fields = None,
    json: console.Json = False,
    resolution_a: Resolution = None,
    resolution_b: Resolution = None,
    free: Grey = None,
    occupied: Grey = None,
    unknown: Grey = None,
    dialect: DialectName = None,
    strict_thresholds: Strict = False,
    quiet: console.Quiet = False,
    debug: console.Debug = False,
) -> None:
    """Judge a placement that was made by hand, with the verdict that `merge` would give it; writes nothing.

    The placement is made exact where it lies, and then weighed against every other; where nothing fits near there it
    says so, and tells what does. The numbers are those that `rectmerge view` shows: pixel (u, v) of B lies on pixel
    (a u - b v + tx, b u + a v + ty) of A.
    """
    from rectmerge.cli.map_options import name_maps, read_maps
    from rectmerge.cli.merge import lay_out
    from rectmerge.cli.method_options import choose_method, parse_scale
    from rectmerge.cli.placement_source import moved_cells, parse_pixels
    from rectmerge.cli.summary import describe, describe_check
    from rectmerge.methods import check as judge
    from rectmerge.results.folder import to_json

    told, bounds, solver = parse_pixels(pixels), parse_scale(scale), choose_method(method, fields or [])
    maps = [(a, resolution_a), (b, resolution_b)]
    inputs = name_maps(maps, greys=(free, occupied, unknown), dialect=dialect, strict=strict_thresholds)
    grid_a, grid_b = read_maps(inputs, quiet=quiet)
    found = judge(grid_a, grid_b, told, method=solver, scale=bounds, seed=seed)
    if json:
        moved = moved_cells(grid_b, told, found.candidates[0].pixels) if found.candidates else 0.0
        typer.echo(to_json(lay_out(found, grid_a, grid_b) | {"moved_cells": moved}))
    else:
        typer.echo("\n".join([describe(found, is_given=True), *describe_check(found, grid_b, told)]))
    raise typer.Exit(console.STATUS[found.verdict])
