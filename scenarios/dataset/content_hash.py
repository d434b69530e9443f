"""Hash of an object's content, for ids of tasks and data sets."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from scenarios.dataset.reader import RowSource


def content_hash(value: object) -> str:
    """Return the SHA-256 of an object's content, hexadecimal.

    It is the same in every process, wherever files lie and whatever classes are called. A path counts as nothing, since
    a data set may be moved; a row of a data set counts as the row and the sizes of its maps.

    Examples
    --------
    >>> content_hash({"b": (1, 2), "a": None}) == content_hash({"a": None, "b": [1, 2]})
    True
    """
    return hashlib.sha256(json.dumps(_content(value), sort_keys=True).encode()).hexdigest()


def _content(value: Any) -> Any:
    """Reduce an object to plain data."""
    if value is None or isinstance(value, str | int | float):
        return value
    if isinstance(value, np.ndarray):
        return [value.shape, value.dtype.str, hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()]
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {str(key): _content(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_content(item) for item in value]
    if isinstance(value, Path):
        return None
    if isinstance(value, RowSource):
        row = value.row()
        return [_fields(row), *((row.folder / name).stat().st_size for name in (row.map_a, row.map_b))]
    return _fields(value)


def _fields(value: Any) -> dict[str, Any]:
    """Return the fields of an object as plain data, and its `name`, which methods may keep as a class variable."""
    is_dataclass = dataclasses.is_dataclass(value)
    names = [field.name for field in dataclasses.fields(value)] if is_dataclass else sorted(vars(value))
    return {name: _content(getattr(value, name, None)) for name in ("name", *names)}
