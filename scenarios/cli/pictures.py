"""Commands of `rectbench` that draw: the demo, and the pictures of the pages on how the methods work."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.extras import SIMULATOR, require_extras
from scenarios.execution.terminal import table


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the pictures.")] = Path(
        "demo"
    ),
    force: Annotated[bool, typer.Option("--force", help="Clear an earlier demo in the folder first.")] = False,
) -> None:
    """Show the main job whole: simulate two robots, build their maps, merge, score, draw.

    Ends with status 0 when the chain ran, whether the answers were right or wrong; the table says which.
    """
    from scenarios.gallery.demo import run_demo

    require_extras(*SIMULATOR)
    shown = run_demo(output, force=force, say=console.note)
    typer.echo(table(*shown.table()))
    typer.echo(f"pictures: {output / 'demo.png'} and {len(shown.pictures) - 1} more in {output}")
    typer.echo(f"the mission's data: {output / 'mission'}")


def explain(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the pictures.")],
    force: Annotated[bool, typer.Option("--force", help="Replace earlier pictures in the folder.")] = False,
) -> None:
    """Draw what the default method does with two simulated pairs: the pictures of docs/how-it-works.md."""
    from scenarios.gallery.how_it_works import explain

    require_extras(*SIMULATOR)
    written = explain(output, force=force, say=console.note)
    typer.echo(f"written: {len(written)} pictures in {output}")


def figures(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Folder for the figures.")],
    force: Annotated[bool, typer.Option("--force", help="Replace earlier figures in the folder.")] = False,
) -> None:
    """Draw counterparts of the paper's figures 2 to 12 and Table I: those of docs/the-papers-method.md."""
    from scenarios.gallery.paper_figures import write_figures

    require_extras(*SIMULATOR)
    written = write_figures(output, force=force, say=console.note)
    typer.echo(f"written: {len(written)} files in {output}")
