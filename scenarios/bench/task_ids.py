"""Ids of tasks: hashes of all that determines a row, apart from the code and the limits."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from scenarios.bench.contenders import Contender
from scenarios.dataset.reader import RowSource
from scenarios.pairs.pair import PairSource

TaskKey = tuple[str, str]  # a pair's id and a contender's label
ID_DIGITS = 16  # of the hash, hexadecimal: two of two million tasks share an id with probability 1e-7


def task_ids(source: PairSource, contenders: Sequence[Contender], *, seed: int) -> dict[TaskKey, str]:
    """Return the id of each of a source's tasks.

    A task is determined by what defines the source (for a suite the scenario as it was resolved and its seed, for a
    row of a data set the row and the sizes of its files), the pair, the contender's label, method and fields, and the
    seed of its answer.
    """
    defined = definition(source)
    methods = {contender.label: definition(contender) for contender in contenders}
    return {
        (pair_id, label): _hashed([defined, pair_id, method, seed])[:ID_DIGITS]
        for pair_id in source.pair_ids
        for label, method in methods.items()
    }


def run_id(sources: Iterable[PairSource], contenders: Sequence[Contender], *, suite: str, seed: int) -> tuple[str, int]:
    """Return the id of a run, a hash of all of its tasks in their order, and the number of its pairs."""
    whole = hashlib.sha256(_hashed([suite, seed, [definition(contender) for contender in contenders]]).encode())
    pairs = 0
    for source in sources:
        whole.update(definition(source).encode())
        pairs += len(source.pair_ids)
    return whole.hexdigest()[:ID_DIGITS], pairs


def definition(value: object) -> str:
    """Return a hash of an object's content: the same in every process and wherever its files lie."""
    return _hashed(_content(value))


def _hashed(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _content(value: Any) -> Any:
    if value is None or isinstance(value, str | int | float):
        return value
    if isinstance(value, np.ndarray):
        return [value.shape, value.dtype.str, hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()]
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {str(key): _content(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_content(inner) for inner in value]
    if isinstance(value, Path):
        return None  # a data set may be moved; its rows say what it holds
    if isinstance(value, RowSource):
        row = value.row()
        return [_content(row), *((row.folder / name).stat().st_size for name in (row.map_a, row.map_b))]
    if dataclasses.is_dataclass(value):
        fields = {field.name: _content(getattr(value, field.name)) for field in dataclasses.fields(value)}
        return [type(value).__qualname__, fields]
    return [type(value).__qualname__, {key: _content(inner) for key, inner in sorted(vars(value).items())}]
