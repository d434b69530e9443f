"""Entrants of the leaderboard: each method with its authors' parameters, and tuned."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError
from scenarios.suites.random_values import sample_values
from scenarios.suites.suite import ContenderSpec
from scenarios.suites.toml_tables import structure

ENTRANTS, TUNED = (Path(__file__).parent / name for name in ("entrants.toml", "tuned.toml"))
EVERYBODY = "everybody"  # a name that stands for all of them


@dataclass(frozen=True, slots=True, kw_only=True)
class Entrant(ContenderSpec):
    """A method with its authors' parameters, and the space in which it is tuned.

    Parameters
    ----------
    label, method, set
        As of every contender.
    space
        Values left open, in the forms of `scenarios.suites.random_values`; empty where there is nothing to tune.
    """

    space: dict[str, Any] = field(default_factory=dict)

    def configurations(self, budget: int, *, seed: int = 0) -> list[ContenderSpec]:
        """Return the authors' parameters and as many more, drawn from the space, as the budget has left."""
        others = [sample_values(self.space, name=self.label, seed=seed + k, first=seed) for k in range(1, budget)]
        fields = [self.set, *({**self.set, **other} for other in others)]
        return [
            ContenderSpec(label=f"{self.label}-{k}", method=self.method, set=values) for k, values in enumerate(fields)
        ]


def entrants() -> list[Entrant]:
    """Return the methods of the leaderboard with their authors' parameters."""
    table = tomllib.loads(ENTRANTS.read_text(encoding="utf-8"))
    return structure(table["entrants"], list[Entrant], "entrants")


def tuned() -> list[ContenderSpec]:
    """Return the same methods as ``rectbench tune`` left them."""
    table = tomllib.loads(TUNED.read_text(encoding="utf-8"))
    return structure(table["contenders"], list[ContenderSpec], "contenders")


def contenders() -> list[ContenderSpec]:
    """Return all that take part: every method by its authors' parameters, and tuned."""
    return [
        *(ContenderSpec(label=entrant.label, method=entrant.method, set=entrant.set) for entrant in entrants()),
        *tuned(),
    ]


def entrants_named(labels: Sequence[str]) -> list[Entrant]:
    """Return the entrants that have something to tune, or those with some labels.

    Raises
    ------
    InputError
        If there is no such entrant, or nothing of it to tune.
    """
    tunable = {entrant.label: entrant for entrant in entrants() if entrant.space}
    for label in labels:
        if label not in tunable:
            raise InputError(f"{label!r} cannot be tuned; these can: {', '.join(tunable)}")
    return [tunable[label] for label in labels or tunable]
