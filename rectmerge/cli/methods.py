"""Command `rectmerge methods`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import typer

from rectmerge.cli import console
from rectmerge.cli.app import Json

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


def methods(json: Json = False) -> None:
    """List the methods and the fields that --set takes."""
    from rectmerge.io.json_text import to_json
    from rectmerge.method_fields import flat_fields, to_text
    from rectmerge.methods import DEFAULT_METHOD, available

    described = {name: _describe_method(point) for name, point in available().items()}
    if json:
        typer.echo(to_json({"default": DEFAULT_METHOD, "methods": described}))
        return
    for name, method in described.items():
        default = " (default)" if name == DEFAULT_METHOD else ""
        typer.echo(f"{name}{default}: {method['about']}")
        for field, value in flat_fields(method["fields"]).items():
            typer.echo(f"    --set {name}.{field}={to_text(value)}")


def _describe_method(point: EntryPoint) -> dict[str, Any]:
    from rectmerge.method_fields import default_fields

    try:
        cls = point.load()
    except (ImportError, AttributeError) as error:
        return {"about": f"cannot be loaded: {console.one_line(error)}", "fields": {}}
    about = (cls.__doc__ or "").strip().partition("\n")[0]
    return {"about": about, "fields": default_fields(cls)}
