"""Contenders: methods under the labels that tables show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rectmerge.alignment import Method
from rectmerge.errors import InputError
from rectmerge.methods import make_method
from scenarios.suites.suite import ContenderSpec


@dataclass(frozen=True, slots=True, kw_only=True)
class Contender:
    """A method that takes part in a run.

    Parameters
    ----------
    label
        Its name in tables, unique in the run.
    method
        The method.
    knows_scale
        Whether it gets the true ratio of the maps' cells.
    """

    label: str
    method: Method
    knows_scale: bool = False


def make_contenders(
    names: Sequence[str], entries: Sequence[ContenderSpec], settings: Sequence[str] = (), *, knows_scale: bool = False
) -> list[Contender]:
    """Make contenders from names.

    Parameters
    ----------
    names
        Labels of `entries`, or registered methods.
    entries
        The contenders that a suite or the leaderboard declares.
    settings
        ``METHOD.FIELD=VALUE``; METHOD is the label or the method of one or more of the contenders.
    knows_scale
        Whether all get the true ratio of the maps' cells.

    Raises
    ------
    InputError
        If a setting has another form, or names no contender.
    MethodError
        If a method or a field does not exist, or a value does not fit.
    """
    declared = {entry.label: (entry.method, dict(entry.set)) for entry in entries}
    chosen = {name: declared.get(name, (name, {})) for name in names}
    for setting in settings:
        _apply(setting, chosen)
    return [
        Contender(label=label, method=make_method(method, **fields), knows_scale=knows_scale)
        for label, (method, fields) in chosen.items()
    ]


def _apply(setting: str, chosen: Mapping[str, tuple[str, dict[str, Any]]]) -> None:
    """Set a field of every contender whose label or method a setting names."""
    key, equals, value = setting.partition("=")
    owner, dot, field = key.partition(".")
    if not (equals and dot and owner and field):
        raise InputError(f"--set takes METHOD.FIELD=VALUE, got {setting!r}")
    owned = [fields for label, (method, fields) in chosen.items() if owner in (label, method)]
    if not owned:
        raise InputError(f"--set {setting}: no contender is called {owner!r}; there are: {', '.join(chosen)}")
    for fields in owned:
        fields[field] = value
