"""Command `rectmerge inspect`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rectmerge.cli.app import Json
from rectmerge.cli.map_options import MapOptions, OneMap
from rectmerge.errors import InputError


def inspect(
    map_file: OneMap,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="PICTURE.png", help="The picture to write.")],
    reading: MapOptions,
    json: Json = False,
) -> None:
    """Draw a map's rectangles and orientation, and report its size, accuracy, specks and frontiers."""
    from rectmerge.cli.map_options import input_files, read_maps
    from rectmerge.io.atomic_file import replace_file, require_other
    from rectmerge.io.image_file import encode_image
    from rectmerge.io.json_text import to_json
    from rectmerge.paper.inspection import inspect_map

    if output.suffix.lower() != ".png":
        raise InputError(f"{output}: the picture is a PNG; give it a name that ends in .png")
    inputs = reading.inputs(map_file)
    require_other(output, input_files(inputs))
    (grid,) = read_maps(inputs)
    inspection = inspect_map(grid)
    replace_file(output, encode_image(inspection.draw(), ".png"))
    typer.echo(to_json(inspection.as_dict()) if json else f"{inspection}\n  picture      {output}")
