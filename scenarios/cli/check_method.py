"""Command `rectbench check-method`, which names the faults of a method for its author."""

from __future__ import annotations

from typing import Annotated

import typer

from rectmerge.cli import console
from rectmerge.errors import InputError
from scenarios.execution.terminal import progress


def check_method(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="A registered method.")] = None,
    method_command: Annotated[
        str | None, typer.Option(metavar="[NAME=]'PROG {a} {b}'", help="A program of any language as a method.")
    ] = None,
) -> None:
    """Put a method to six easy pairs of maps, twice each, and name what is wrong with it.

    Where its answers are wrong, the usual mistakes are undone one by one (an inverse matrix, v upwards, rows for
    columns, half a pixel, degrees, metres, ...), and the one that makes them right is named. Ends with status 1 if
    anything is wrong.
    """
    from rectmerge.methods import make_method
    from scenarios.bench.check_method import check_method as check
    from scenarios.bench.external_program import Program
    from scenarios.pairs.drawn_pairs import VIEWS

    if (name is None) == (method_command is None):
        raise InputError("name a registered method, or give a program by --method-command")
    method = make_method(name) if name is not None else Program.parse(method_command or "")
    with progress(len(VIEWS)) as advance:
        checked = check(name or "command", method, on_answer=lambda pair: advance(1, pair))
    console.tell(checked.as_text())
    raise typer.Exit(console.NO if checked.complaints else console.YES)
