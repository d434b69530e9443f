"""Command `rectmerge view`: an alignment as a page, opened in a browser."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.cli.map_options import MergeFolder
from rectmerge.errors import InputError

PAGE = "view.html"
SUFFIXES = (".html", ".htm")


def view(
    folder: MergeFolder,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="PAGE.html", help=f"The page; DIR/{PAGE} unless given.")
    ] = None,
    a: Annotated[Path | None, typer.Option("--a", metavar="FILE", help="Map A, if it has moved since.")] = None,
    b: Annotated[Path | None, typer.Option("--b", metavar="FILE", help="Map B, if it has moved since.")] = None,
    open_page: Annotated[bool, typer.Option("--open/--no-open", help="Open the page in a browser.")] = True,
) -> None:
    """Show an alignment in a browser: both maps, the candidates, and map B to be placed by hand.

    Where the merge has bent map B, candidate 1 fades between map B as it is and unbent.

    The page is one file that needs no network. It shows a placement by hand as options to paste into a command. The
    path of the page goes to stdout. The status is 0 whatever the verdict.

    Of a merge of more than two maps it shows each component with its maps to fade, the graph of pairs, and all reasons.
    """
    from rectmerge.fleet.record import FleetFile
    from rectmerge.results.alignment_json import AlignmentFile
    from rectmerge.results.inputs import saved_inputs
    from rectmerge.results.saved_bend import read_bend
    from rectmerge.view.page import html
    from rectmerge.view.shown_alignment import ShownAlignment

    if output is not None and output.suffix.lower() not in SUFFIXES:
        raise InputError(f"{output}: the page is HTML; give it a name that ends in .html")
    if (fleet := FleetFile.find(folder)) is not None:
        if a is not None or b is not None:
            raise InputError(f"{folder}: holds more than two maps; --a and --b are for the merge of two")
        _show(_fleet_html(fleet), output or fleet.parent / PAGE, is_opened=open_page)
        return
    file = AlignmentFile.read(folder)
    page = output or file.folder / PAGE
    alignment = ShownAlignment.from_file(file)
    inputs = saved_inputs(file, a=a, b=b)
    grid_a, grid_b = (map_input.read() for map_input in inputs)
    if not alignment.fits(grid_a, grid_b):
        console.note(f"rectmerge: {folder}: these are not the maps of the merge, or they have changed; merge again")
    _show(html(alignment, inputs, grid_a, grid_b, bend=read_bend(file)), page, is_opened=open_page)


def _fleet_html(path: Path) -> str:
    """Return the page of a merge of more than two maps."""
    from rectmerge.fleet.map_sample import digest
    from rectmerge.fleet.record import FleetFile, read_inputs
    from rectmerge.fleet.saved_graph import read_graph
    from rectmerge.view.fleet_page import html

    file = FleetFile.read(path)
    graph, maps = read_graph(file, {}), read_inputs(file)
    if any(name not in maps for name in graph.names):
        raise InputError(f"{path}: does not say where the maps lie; merge again")
    if changed := [name for name, told in graph.digests.items() if digest(maps[name]) != told]:
        console.note(f"rectmerge: {path}: {', '.join(changed)} changed since the merge; merge again")
    return html(graph, maps)


def _show(page: str, path: Path, *, is_opened: bool) -> None:
    """Write a page, print its path, and open it where there is a display."""
    from rectmerge.io.atomic_file import replace_file

    replace_file(path, page.encode())
    console.tell(str(path))
    if is_opened and _has_display():
        _open(path)


def _has_display() -> bool:
    """Return whether a browser opens a window; a browser in the terminal would take the terminal over."""
    return sys.platform == "darwin" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def _open(page: Path) -> None:
    import webbrowser

    webbrowser.open(page.resolve().as_uri())
