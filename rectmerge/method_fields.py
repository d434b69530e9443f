"""Fields of methods: set by their dotted names, from values or from text, and listed with their defaults."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal, get_args, get_origin, get_type_hints

import cattrs

from rectmerge.errors import InputError, MethodError


def with_fields(cls: type, name: str, fields: Mapping[str, object]) -> object:
    """Make an object of a dataclass, with some of its fields set; a text value is read as the field's type.

    Parameters
    ----------
    cls
        The dataclass. A field whose default is a dataclass is a group.
    name
        Name of the method, for messages.
    fields
        Values by name. The name of a field of a group is ``GROUP.FIELD``; a group also takes a mapping.

    Raises
    ------
    MethodError
        If there is no such field, or a value does not fit.
    """
    return _replaced(cls, None, name, _nested(fields))


def default_fields(cls: type) -> dict[str, Any]:
    """Return the defaults of a dataclass's fields, those of a group as a mapping; a field without default is None."""
    return {name: _plain(_default(field)) for name, field in _fields(cls).items() if name != "name"}


def field_values(method: Any) -> dict[str, Any]:
    """Return the values of a method's fields, those of a group as a mapping."""
    names = [field.name for field in dataclasses.fields(method) if field.name != "name"]
    return {name: _plain(getattr(method, name)) for name in names}


def flat_fields(fields: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested fields by their dotted names."""
    flat: dict[str, Any] = {}
    for name, value in fields.items():
        flat |= flat_fields(value, f"{prefix}{name}.") if isinstance(value, Mapping) else {f"{prefix}{name}": value}
    return flat


def to_text(value: object) -> str:
    """Write a value as it is typed on the command line."""
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _replaced(cls: type, default: Any, path: str, nested: Mapping[str, object]) -> object:
    """Make an object of a class, or a copy of a default, with some of its fields set."""
    known = _fields(cls)
    values: dict[str, object] = {}
    for key, value in nested.items():
        if key not in known:
            owner = f"method {path!r}" if default is None else f"group {path!r}"
            raise MethodError(f"{owner} has no field {key!r}; it has: {', '.join(known)}")
        group = getattr(default, key, _default(known[key]))
        values[key] = _value(cls, key, group, f"{path}.{key}", value)
    try:
        return cls(**values) if default is None else dataclasses.replace(default, **values)
    except InputError as error:
        raise MethodError(f"{path}: {error}") from error


def _value(cls: type, key: str, group: Any, path: str, value: object) -> object:
    if dataclasses.is_dataclass(group) and not isinstance(group, type):
        if isinstance(value, type(group)):
            return value
        if not isinstance(value, Mapping):
            raise MethodError(f"{path} is a group of fields; it has: {', '.join(_fields(type(group)))}")
        return _replaced(type(group), group, path, value)
    try:
        return _converter().structure(value, get_type_hints(cls)[key])
    except (ValueError, TypeError) as error:
        kind = get_type_hints(cls)[key]
        numbers = {int: "a whole number", float: "a number"}
        reason = f"must be {numbers[kind]}, got {value!r}" if kind in numbers else str(error)
        raise MethodError(f"{path}={to_text(value)}: {reason}") from error


def _nested(fields: Mapping[str, object]) -> dict[str, Any]:
    """Turn dotted names into nested mappings; a later value of the same field replaces an earlier one."""
    nested: dict[str, Any] = {}
    for key, value in flat_fields(fields).items():
        *groups, name = key.split(".")
        into = nested
        for group in groups:
            if not isinstance(into.get(group), dict):
                into[group] = {}
            into = into[group]
        into[name] = value
    return nested


def _fields(cls: type) -> dict[str, dataclasses.Field[Any]]:
    return {field.name: field for field in dataclasses.fields(cls) if field.init}


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default is not dataclasses.MISSING:
        return field.default
    return None if field.default_factory is dataclasses.MISSING else field.default_factory()


def _plain(value: Any) -> Any:
    return dataclasses.asdict(value) if dataclasses.is_dataclass(value) and not isinstance(value, type) else value


def _converter() -> cattrs.Converter:
    converter = cattrs.Converter()
    converter.register_structure_hook(bool, _read_bool)
    converter.register_structure_hook_func(_is_choice, _read_choice)
    converter.register_structure_hook_func(_is_tuple, _read_tuple)
    return converter


def _is_choice(kind: object) -> bool:
    origin: object = get_origin(kind)
    return origin is Literal


def _is_tuple(kind: object) -> bool:
    origin: object = get_origin(kind)
    return origin is tuple


def _read_choice(value: object, kind: object) -> object:
    if value not in get_args(kind):
        raise ValueError(f"must be one of {', '.join(map(str, get_args(kind)))}, got {value!r}")
    return value


def _read_tuple(value: Any, kind: object) -> object:
    """Read numbers between commas as people type them."""
    items = value.split(",") if isinstance(value, str) else list(value)
    kinds = get_args(kind)
    if kinds[1:] == (...,):
        kinds = kinds[:1] * len(items)
    if len(items) != len(kinds):
        raise ValueError(f"must be {len(kinds)} values, got {len(items)}")
    return tuple(_converter().structure(item, each) for item, each in zip(items, kinds, strict=True))


def _read_bool(value: object, _: type) -> bool:
    """Read a boolean as people type it; a bare cast would take every text for True."""
    if isinstance(value, bool):
        return value
    words = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
    if str(value).lower() not in words:
        raise ValueError(f"must be true or false, got {value!r}")
    return words[str(value).lower()]
