"""Command `rectmerge trace`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.cli.map_options import MapA, MapB, PairOptions
from rectmerge.cli.method_options import Fields, choose_method
from rectmerge.errors import InputError


def trace(
    a: MapA,
    b: MapB,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the figures.")],
    reading: PairOptions,
    method: Annotated[str, typer.Option("--method", metavar="NAME", help="paper or paper-repaired.")] = "paper",
    fields: Fields = None,
    force: Annotated[bool, typer.Option("--force", help="Replace earlier figures in the folder.")] = False,
) -> None:
    """Draw the paper's figures 2 to 12 for two maps, with its Table I and the numbers of every iteration.

    Writes figure-02.png to figure-12.png, table-1.md, trace.md and alignment.json. Ends with status 0 if the method
    accepts its answer, else 1; maps that do not meet a condition of the paper's conclusion are refused with status 1.
    """
    from rectmerge.cli.map_options import input_files, read_maps
    from rectmerge.io.atomic_file import replace_files, require_other
    from rectmerge.io.image_file import encode_image
    from rectmerge.io.json_text import to_json
    from rectmerge.paper.figures import FIGURES, draw_figures
    from rectmerge.paper.iteration import ConditionError
    from rectmerge.paper.trace import neighbours_table, passes_table, trace_method
    from rectmerge.results.alignment_json import to_json_dict

    names = [*FIGURES, "table-1.md", "trace.md", "alignment.json"]
    if (held := [name for name in names if (output / name).exists()]) and not force:
        raise InputError(f"{output}: holds results ({held[0]}); name another folder, or --force replaces them")
    inputs = reading.pair(a, b)
    for name in names:
        require_other(output / name, input_files(inputs))
    if output.exists() and not output.is_dir():
        raise InputError(f"{output}: is not a folder; name another with -o")
    grid_a, grid_b = read_maps(inputs)
    try:
        traced = trace_method(grid_a, grid_b, method=choose_method(method, fields or []))
    except ConditionError as condition:
        console.say(f"rectmerge: a condition of the paper is not met: {condition}")
        raise typer.Exit(console.NO) from None
    table = passes_table(traced.passes)
    files = {name: encode_image(picture, ".png") for name, picture in draw_figures(traced).items()}
    files["table-1.md"] = f"{neighbours_table(traced.rmaps[0])}\n".encode()
    files["trace.md"] = f"{table}\n".encode()
    files["alignment.json"] = f"{to_json(to_json_dict(traced.alignment, grid_a, grid_b))}\n".encode()
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{output}: cannot be written: {error.strerror}; name another folder with -o") from None
    replace_files({output / name: data for name, data in files.items()})
    typer.echo(
        f"{table}\n\n{traced.alignment.verdict}: {traced.alignment.reason}\nwritten: {len(files)} files in {output}"
    )
    raise typer.Exit(console.STATUS[traced.alignment.verdict])
