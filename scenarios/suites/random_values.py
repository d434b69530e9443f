"""Random values in suites: ranges and choices in TOML, drawn for every seed.

A table of one of these forms may stand for any value of a scenario, in lists and in other choices too:

    { from = 0.15, to = 1.0 }               any number between; a whole number where both ends are
    { from = 0.6, to = 1.6, log = true }    the same, but halves are as likely as doubles
    { any_of = ["truth", "slam"] }          one of the values
    { in_turn = ["office", "loop"] }        one after the other, seed by seed
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from rectmerge.errors import InputError

RANGE, CHOICES = {"from", "to", "log"}, ("any_of", "in_turn")
Choose = Callable[[str, Mapping[str, Any]], Any]  # path and table of a random value


def is_random(value: object) -> bool:
    """Return whether a value of a suite is a random one."""
    return isinstance(value, Mapping) and bool(value.keys() & {"from", "to", *CHOICES})


def has_random_values(value: object) -> bool:
    """Return whether a table holds random values."""
    parts = value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ()
    return is_random(value) or any(has_random_values(part) for part in parts)


def sample_values(value: Any, *, name: str, seed: int, first: int = 0, entropy: int | None = None) -> Any:
    """Draw all random values of a table.

    Parameters
    ----------
    value
        A table as it was read.
    name
        Name of the table's owner. Name, key and seed determine the random stream of a value, so that a change of one
        value changes no other.
    seed, first
        The seed, and the scenario's first, at which `in_turn` begins.
    entropy
        The number to draw from in place of the seed; None is the seed.

    Raises
    ------
    InputError
        If a random value has none of the forms; the message begins with its path.
    """

    def choose(path: str, draw: Mapping[str, Any]) -> Any:
        key = zlib.crc32(name.encode()), zlib.crc32(path.encode())
        if "in_turn" in draw:
            return draw["in_turn"][(seed - first) % len(draw["in_turn"])]
        (word,) = np.random.SeedSequence(seed if entropy is None else entropy, spawn_key=key).generate_state(1)
        share = int(word) / 2**32
        return draw["any_of"][int(share * len(draw["any_of"]))] if "any_of" in draw else _between(draw, share)

    return _filled(value, "", choose)


def extreme_values(value: Any) -> Iterator[Any]:
    """Yield the extreme cases of a table: all lowest values, all highest, and every choice."""
    widest = 0

    def choose(path: str, draw: Mapping[str, Any]) -> Any:
        nonlocal widest
        choices = next((draw[key] for key in CHOICES if key in draw), None)
        if choices is None:
            choices = (draw["from"], draw["to"])
        widest = max(widest, len(choices))
        return choices[corner % len(choices)]

    corner = 0
    while corner == 0 or corner < widest:
        yield _filled(value, "", choose)
        corner += 1


def _between(draw: Mapping[str, Any], share: float) -> float | int:
    low, high = draw["from"], draw["to"]
    is_whole = isinstance(low, int) and isinstance(high, int)
    if draw.get("log"):
        value = math.exp(math.log(low) + share * (math.log(high) - math.log(low)))
        return round(value) if is_whole else value
    if is_whole:
        return int(low + int(share * (high - low + 1)))
    return float(low + share * (high - low))


def _filled(value: Any, path: str, choose: Choose) -> Any:
    """Replace random values by chosen ones, which may hold random values themselves."""
    if is_random(value):
        _check(value, path)
        return _filled(choose(path, value), path, choose)
    if isinstance(value, Mapping):
        return {key: _filled(item, f"{path}.{key}" if path else key, choose) for key, item in value.items()}
    if isinstance(value, list):
        return [_filled(item, f"{path}[{k}]", choose) for k, item in enumerate(value)]
    return value


def _check(draw: Mapping[str, Any], path: str) -> None:
    """Refuse a random value of none of the forms."""
    for form in CHOICES:
        if form in draw:
            _refuse_others(draw, {form}, path)
            if not isinstance(draw[form], list) or not draw[form]:
                raise InputError(f"{path}.{form}: must list the choices, got {draw[form]!r}")
            return
    _refuse_others(draw, RANGE, path)
    for end in ("from", "to"):
        if end not in draw:
            raise InputError(f"{path}.{end}: missing")
        if not isinstance(draw[end], int | float) or isinstance(draw[end], bool) or not math.isfinite(draw[end]):
            raise InputError(f"{path}.{end}: must be a number, got {draw[end]!r}")
    if not isinstance(draw.get("log", False), bool):
        raise InputError(f"{path}.log: must be true or false, got {draw['log']!r}")
    if not draw["from"] < draw["to"]:
        raise InputError(f"{path}: from must be less than to, got {draw['from']} and {draw['to']}")
    if draw.get("log") and draw["from"] <= 0:
        raise InputError(f"{path}: from must be > 0 with log = true, got {draw['from']}")


def _refuse_others(draw: Mapping[str, Any], known: set[str], path: str) -> None:
    if unknown := sorted(draw.keys() - known):
        raise InputError(f"{path}: unknown key {unknown[0]!r} with {', '.join(sorted(draw.keys() & known))}")
