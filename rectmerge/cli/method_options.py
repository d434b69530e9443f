"""The options by which commands are told the method and the scale."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, cast

import typer

if TYPE_CHECKING:
    from rectmerge.alignment import Method
    from rectmerge.methods import Scale


def _method_names() -> list[str]:
    from rectmerge.methods import available

    return list(available())


MethodName = Annotated[
    str | None,
    typer.Option("--method", metavar="NAME", help="See `rectmerge methods`.", autocompletion=_method_names),
]
ScaleText = Annotated[
    str, typer.Option("--scale", metavar="auto|free|LO:HI|S", help="What is known of cells of A per cell of B.")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Same maps and seed, same answer.")]
Fields = Annotated[list[str] | None, typer.Option("--set", metavar="METHOD.FIELD=VALUE", help="Set a method's field.")]


def parse_scale(text: str) -> Scale:
    """Read what --scale says."""
    if text in ("auto", "free"):
        return cast("Scale", text)
    try:
        numbers = [float(part) for part in text.split(":")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2) or not 0 < numbers[0] <= numbers[-1] < math.inf:
        raise typer.BadParameter(f"{text!r} is not auto, free, LO:HI with 0 < LO <= HI, or a positive number: --scale")
    return numbers[0] if len(numbers) == 1 else (numbers[0], numbers[1])


def choose_method(name: str | None, assignments: Sequence[str]) -> Method:
    """Make the method with the fields that ``--set METHOD.FIELD=VALUE`` names."""
    from rectmerge.methods import DEFAULT_METHOD, make_method

    name = name or DEFAULT_METHOD
    fields: dict[str, object] = {}
    for assignment in assignments:
        target, equals, value = assignment.partition("=")
        owner, dot, field = target.partition(".")
        if not (equals and dot and field):
            raise typer.BadParameter(f"{assignment!r} is not METHOD.FIELD=VALUE: --set")
        if owner != name:
            raise typer.BadParameter(f"{assignment!r} sets a field of {owner!r}, but the method is {name!r}: --set")
        fields[field] = value
    return make_method(name, **fields)
