"""Declaration of parameters: unit, source and bounds of each, and the check of their values."""

from __future__ import annotations

import dataclasses
import math
from typing import TypeVar

from rectmerge.errors import InputError

T = TypeVar("T")
HAND = "hand, no data"
CALIBRATED = "rectbench calibrate on train of trust and standard, real_places, real_lasers, real_maps"
LAYOUT = "hand, no data; trades time for exactness"


def param(
    value: T,
    unit: str,
    source: str,
    *,
    least: float | None = None,
    most: float | None = None,
    length: int | None = None,
) -> T:
    """Declare a parameter; counts are at least 1 and other numbers above 0, unless `least` says otherwise.

    Shares and probabilities are at most 1; `most` bounds a size that could exhaust the memory. `length` is the number
    of values where it cannot be another.
    """
    if most is None:
        most = 1.0 if unit.startswith(("share", "probability")) else math.inf
    metadata = {"unit": unit, "source": source, "least": least, "most": most, "length": length}
    field: T = dataclasses.field(default=value, metadata=metadata)
    return field


def ablation(row: str) -> str:
    """Name a row of the ablation as the source of a switch."""
    return f"results/robust/README.md, ablation row {row!r}"


class Group:
    """Base of the groups: a number that is not finite or out of its bounds is an `InputError`."""

    __slots__ = ()

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):  # type: ignore[arg-type] # the groups are dataclasses
            value, least = getattr(self, field.name), field.metadata.get("least")
            if isinstance(value, list):  # as JSON has them; parameters are compared and kept as keys
                object.__setattr__(self, field.name, value := tuple(value))
            if isinstance(value, bool) or not isinstance(value, int | float | tuple):
                continue
            numbers = value if isinstance(value, tuple) else (value,)
            if len(numbers) != (field.metadata.get("length") or len(numbers)):
                raise InputError(f"{field.name} must be {field.metadata['length']} values, got {len(numbers)}")
            most = field.metadata.get("most", math.inf)
            for number in numbers:
                if number > most:
                    raise InputError(f"{field.name} must be at most {most:.15g}, got {value}")
                if least is None and isinstance(number, int) and number < 1:
                    raise InputError(f"{field.name} must be >= 1, got {value}")
                if not math.isfinite(number) or (number <= 0 if least is None else number < least):
                    bound = "> 0" if least is None else f">= {least:g}"
                    raise InputError(f"{field.name} must be finite and {bound}, got {value}")
