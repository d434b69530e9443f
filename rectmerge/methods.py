"""Registry of methods by entry points."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from typing import cast

from rectmerge.alignment import Method
from rectmerge.errors import MethodError
from rectmerge.method_fields import with_fields

GROUP = "rectmerge.methods"
DEFAULT_METHOD = "robust"


@functools.cache
def available() -> Mapping[str, EntryPoint]:
    """Return the registered methods by name, not yet imported; the installed packages are searched once."""
    return {point.name: point for point in sorted(entry_points(group=GROUP), key=lambda point: point.name)}


def make_method(name: str, **fields: object) -> Method:
    """Make a registered method with some of its fields set; a text is parsed as the field's type.

    A field of a group of fields is called ``GROUP.FIELD``.

    Raises
    ------
    MethodError
        If there is no such method or field, it is no dataclass, or a value does not fit.
    """
    points = available()
    if name not in points:
        raise MethodError(f"unknown method {name!r}; there are: {', '.join(points)}")
    try:
        cls = points[name].load()
    except (ImportError, AttributeError) as error:
        raise MethodError(f"method {name!r} cannot be loaded from {points[name].value}: {error}") from error
    if not (isinstance(cls, type) and dataclasses.is_dataclass(cls)):
        raise MethodError(f"method {name!r}: {points[name].value} is no dataclass; a method is a frozen one")
    return cast(Method, with_fields(cls, name, fields))
