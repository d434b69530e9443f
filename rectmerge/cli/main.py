"""The command `rectmerge`: merge two maps, check a placement, inspect one, use an answer, list the methods."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rectmerge.cli import console
from rectmerge.cli.check import check
from rectmerge.cli.map_options import DialectName, Grey, OneMap, Strict
from rectmerge.cli.merge import TwoMaps, merge
from rectmerge.cli.transform import transform
from rectmerge.cli.view import view
from rectmerge.errors import InputError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

app = typer.Typer(
    context_settings=console.SETTINGS, no_args_is_help=True, add_completion=True, pretty_exceptions_enable=False
)


@app.callback()
def common(version: console.Version = False) -> None:
    """Merge 2-D occupancy-grid maps of unknown rotation, scale and translation.

    Exit status: 0 yes, 1 no, 2 bad input or use, 3 ambiguous, 70 internal error, 130 interrupted.
    """


app.command(cls=TwoMaps)(merge)
app.command()(check)


@app.command()
def inspect(
    map_file: OneMap,
    output: Annotated[Path, typer.Option("--output", "-o", metavar="PICTURE.png", help="The picture to write.")],
    json: console.Json = False,
    free: Grey = None,
    occupied: Grey = None,
    unknown: Grey = None,
    dialect: DialectName = None,
    strict_thresholds: Strict = False,
    quiet: console.Quiet = False,
    debug: console.Debug = False,
) -> None:
    """Draw a map's rectangles and orientation, and tell its size and its own accuracy."""
    from rectmerge.cli.inspection import inspect_map
    from rectmerge.cli.map_options import files_of, name_maps, read_maps
    from rectmerge.io.image_file import encode_image, replace_file, require_other
    from rectmerge.results.folder import to_json

    if output.suffix.lower() != ".png":
        raise InputError(f"{output}: the picture is a PNG; give it a name that ends in .png")
    maps = [(map_file, None)]
    inputs = name_maps(maps, greys=(free, occupied, unknown), dialect=dialect, strict=strict_thresholds)
    require_other(output, files_of(inputs))
    (grid,) = read_maps(inputs, quiet=quiet)
    inspection = inspect_map(grid)
    replace_file(output, encode_image(inspection.draw(), ".png"))
    typer.echo(to_json(inspection.as_dict()) if json else f"{inspection}\n  picture      {output}")


@app.command()
def methods(json: console.Json = False, quiet: console.Quiet = False, debug: console.Debug = False) -> None:
    """List the methods and the fields that --set takes."""
    from rectmerge.methods import DEFAULT_METHOD, available
    from rectmerge.results.folder import to_json

    found = {name: _describe_method(point) for name, point in available().items()}
    if json:
        typer.echo(to_json({"default": DEFAULT_METHOD, "methods": found}))
        return
    for name, method in found.items():
        default = " (default)" if name == DEFAULT_METHOD else ""
        typer.echo(f"{name}{default}: {method['about']}")
        for field, value in method["fields"].items():
            typer.echo(f"    --set {name}.{field}={value}")


app.command()(transform)
app.command()(view)


def main() -> None:
    """Run the command and exit with its status."""
    console.end(app, "rectmerge")


def _describe_method(point: EntryPoint) -> dict[str, Any]:
    try:
        cls = point.load()
    except (ImportError, AttributeError) as error:
        return {"about": f"cannot be loaded: {console.one_line(error)}", "fields": {}}
    about = (cls.__doc__ or "").strip().partition("\n")[0]
    known = {field.name: field.default for field in dataclasses.fields(cls) if field.init and field.name != "name"}
    return {"about": about, "fields": known}
