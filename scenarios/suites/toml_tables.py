"""Dataclasses from TOML tables; an unknown key or a wrong value is refused with its path."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import asdict
from typing import Any, Literal, TypeVar, get_args, get_origin

import cattrs
from cattrs.gen import make_dict_structure_fn

from rectmerge.errors import InputError, ScenarioError
from scenarios.corruption import NoiseLevel
from sim.floorplans import FAMILIES, Office, WorldSpec
from sim.sensors.lidar import Lidar, find_lidar

T = TypeVar("T")


def structure(data: Any, kind: type[T], at: str = "") -> T:
    """Make a dataclass from a table.

    Parameters
    ----------
    data
        The table.
    kind
        The dataclass.
    at
        The table's own path in its file.

    Raises
    ------
    ScenarioError
        If a key or value is not allowed; one line per error, each beginning with the key's path.
    """
    try:
        return _converter().structure(data, kind)
    except (cattrs.BaseValidationError, InputError, TypeError, AttributeError) as error:
        lines = _error_lines(error, f"{at}: " if at else "")
        raise ScenarioError("\n".join(dict.fromkeys(lines))) from error


def _error_lines(error: BaseException, at: str) -> list[str]:
    """Flatten cattrs' tree of errors into lines ``path: message``."""
    if isinstance(error, cattrs.ForbiddenExtraKeysError):
        return [f"{at}unknown key {key!r}" for key in sorted(error.extra_fields)]
    if isinstance(error, BaseExceptionGroup):
        return [line for child in error.exceptions for line in _error_lines(child, _path(at, child))]
    if isinstance(error, KeyError):
        return [f"{at}missing"]
    if isinstance(error, TypeError | AttributeError):  # raised by cattrs for a number in place of a table or a list
        return [f"{at}must be a table or a list of the documented form"]
    return [f"{at}{error}"]


def _path(at: str, error: BaseException) -> str:
    """Add the step to a child error, as cattrs notes it, to a path."""
    base = at.removesuffix(": ")
    for note in getattr(error, "__notes__", ()):
        if isinstance(note, cattrs.IterableValidationNote):
            return f"{base}[{note.index}]: "
        if isinstance(note, cattrs.AttributeValidationNote):
            return f"{base}.{note.name}: " if base else f"{note.name}: "
    return at


@functools.cache
def _converter() -> cattrs.Converter:
    """Return the converter, which refuses text for numbers and unknown keys; made once, since it compiles its hooks."""
    converter = cattrs.Converter(forbid_extra_keys=True)
    converter.register_structure_hook(int, lambda value, _: _exactly(value, int, "a whole number"))
    converter.register_structure_hook(float, lambda value, _: float(_exactly(value, (int, float), "a number")))
    converter.register_structure_hook(str, lambda value, _: _exactly(value, str, "text"))
    converter.register_structure_hook(bool, lambda value, _: _exactly(value, bool, "true or false"))
    converter.register_structure_hook(NoiseLevel, lambda value, _: _exactly(value, (int, str), "a level of noise"))
    converter.register_structure_hook(float | Literal["random"], lambda value, _: value)  # MapSpec checks it
    converter.register_structure_hook_func(lambda kind: kind is WorldSpec, lambda data, _: _world(data, converter))
    converter.register_structure_hook_func(lambda kind: str(get_origin(kind)) == "typing.Literal", _one_of)
    lidar = make_dict_structure_fn(Lidar, converter, _cattrs_forbid_extra_keys=True)
    converter.register_structure_hook(Lidar, lambda value, kind: _scanner(value, lambda table: lidar(table, kind)))
    return converter


def _scanner(value: Any, read: Callable[[dict[str, Any]], Lidar]) -> Lidar:
    """Read a scanner: the name of a profile, or a table whose `profile` gives the missing fields."""
    if isinstance(value, str):
        return find_lidar(value)
    if "profile" not in value:
        return read(value)
    return read(asdict(find_lidar(value["profile"])) | {k: v for k, v in value.items() if k != "profile"})


def _world(data: dict[str, Any], converter: cattrs.Converter) -> WorldSpec:
    """Read a building's parameters; the key `family` names its class."""
    family = data.get("family", Office.family)
    if family not in tuple(FAMILIES):
        raise InputError(f"family must be one of {', '.join(FAMILIES)}, got {family!r}")
    return converter.structure({key: value for key, value in data.items() if key != "family"}, FAMILIES[family])


def _one_of(value: Any, kind: Any) -> Any:
    if value not in get_args(kind):
        raise InputError(f"must be one of {', '.join(map(repr, get_args(kind)))}, got {value!r}")
    return value


def _exactly(value: Any, kind: type | tuple[type, ...], wanted: str) -> Any:
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise InputError(f"must be {wanted}, got {value!r}")
    return value
