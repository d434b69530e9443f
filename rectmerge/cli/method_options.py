"""Options on the method, its fields, the scale and the seed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, cast

import typer

from rectmerge.errors import InputError

if TYPE_CHECKING:
    from rectmerge.aligning import Scale
    from rectmerge.alignment import Method


def _method_names() -> list[str]:
    from rectmerge.methods import available

    return list(available())


MethodName = Annotated[
    str | None,
    typer.Option("--method", metavar="NAME", help="See `rectmerge methods`.", autocompletion=_method_names),
]
ScaleText = Annotated[
    str, typer.Option("--scale", metavar="auto|free|LO:HI|S", help="Scale to search, cells of A per cell of B.")
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Same maps and seed, same answer.")]
Fields = Annotated[list[str] | None, typer.Option("--set", metavar="METHOD.FIELD=VALUE", help="Set a method's field.")]


@dataclass(frozen=True, kw_only=True)
class MethodOptions:
    """Options on how map B is placed on map A."""

    method: MethodName = None
    scale: ScaleText = "auto"
    seed: Seed = 0
    fields: Fields = None

    def make_method(self) -> Method:
        """Return the method, with the fields that are set."""
        return choose_method(self.method, self.fields or [])

    def parse_scale(self) -> Scale:
        """Return the scale to search."""
        return parse_scale(self.scale)


def parse_scale(text: str) -> Scale:
    """Parse the value of ``--scale``.

    Raises
    ------
    InputError
        If the text is none of its forms.
    """
    if text in ("auto", "free"):
        return cast("Scale", text)
    try:
        numbers = [float(part) for part in text.split(":")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2) or not 0 < numbers[0] <= numbers[-1] < math.inf:
        raise InputError(f"--scale: {text!r} is not auto, free, LO:HI with 0 < LO <= HI, or a positive number")
    return numbers[0] if len(numbers) == 1 else (numbers[0], numbers[1])


def choose_method(name: str | None, assignments: Sequence[str]) -> Method:
    """Make the method with the fields that ``--set METHOD.FIELD=VALUE`` names.

    Raises
    ------
    InputError
        If an assignment has another form or names another method, or as in `rectmerge.methods.make_method`.
    """
    from rectmerge.methods import DEFAULT_METHOD, make_method

    name = name or DEFAULT_METHOD
    fields: dict[str, object] = {}
    for assignment in assignments:
        target, equals, value = assignment.partition("=")
        owner, dot, field = target.partition(".")
        if not (equals and dot and field):
            raise InputError(f"--set: {assignment!r} is not METHOD.FIELD=VALUE")
        if owner != name:
            wrong = f"sets a field of {owner!r}, but the method is {name!r}"
            raise InputError(f"--set: {assignment!r} {wrong}; give --method {owner}")
        fields[field] = value
    return make_method(name, **fields)
