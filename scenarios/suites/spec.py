"""Scenarios: a building, a mission, two maps, and the relation of the maps."""

from __future__ import annotations

import hmac
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from rectmerge.errors import InputError
from scenarios.corruption import NOISE_LEVELS, NoiseLevel
from scenarios.pairs.map_view import MapSpec
from sim.floorplans import Hall, Office, WorldSpec
from sim.missions.spec import MissionSpec

Split = Literal["train", "test"]
PairKind = Literal[
    "related", "other-building", "no-shared-room", "other-floor", "other-storey", "mirrored", "blank-halls"
]
MOST_SEEDS = 1_000_000
UNRELATED: tuple[str, ...] = get_args(PairKind)[1:]
OF_TWO_BUILDINGS = ("other-building", "blank-halls")
OTHER_SIZE = 1.1  # an edge of one blank hall is at least this times as long as the other's


@dataclass(frozen=True, slots=True, kw_only=True)
class Seeds:
    """Range of `count` seeds: first, first + 1, ..."""

    first: int = 0
    count: int = 1

    def __post_init__(self) -> None:
        if self.first < 0 or not 1 <= self.count <= MOST_SEEDS:
            limits = f"first >= 0 and count from 1 to {MOST_SEEDS}"
            raise InputError(f"seeds need {limits}, got {self.first} and {self.count}")

    def entropy(self, seed: int) -> int:
        """Return the number from which everything random of a seed is drawn: the seed itself."""
        return seed

    def derive(self, seed: int, key: Sequence[int], *, is_wide: bool = False) -> int:
        """Derive a seed for one purpose.

        Parameters
        ----------
        seed
            One of these seeds.
        key
            Numbers of the purpose; other numbers give another seed.
        is_wide
            Whether it has 52 bits, so that none of many meets another; else 32. JSON keeps no more than 53.
        """
        sequence = np.random.SeedSequence(self.entropy(seed), spawn_key=tuple(key))
        return int(sequence.generate_state(1, np.uint64)[0]) >> 12 if is_wide else int(sequence.generate_state(1)[0])


@dataclass(frozen=True, slots=True, kw_only=True)
class SecretSeeds(Seeds):
    """Range of seeds mixed with a secret: who does not know it cannot draw what they draw.

    Parameters
    ----------
    secret
        Hexadecimal digits.

    Notes
    -----
    The entropy of a seed is its HMAC-SHA256 under the secret (RFC 2104, FIPS 180-4), so a seed that becomes known tells
    nothing of the others; derived seeds have 52 bits, too many to try.
    """

    secret: str = field(repr=False)

    def entropy(self, seed: int) -> int:
        """Return the HMAC of a seed, 256 bits."""
        return int.from_bytes(hmac.digest(bytes.fromhex(self.secret), str(seed).encode(), "sha256"), "big")

    def derive(self, seed: int, key: Sequence[int], *, is_wide: bool = True) -> int:
        """Derive a seed for one purpose, always of 52 bits."""
        return Seeds.derive(self, seed, key, is_wide=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """One of several ways to make a pair of the same mission.

    Parameters
    ----------
    name
        Its name in ids of pairs and in their `info`.
    overlap
        Wanted overlap of the finished maps, 0.1 to 1, for which the logs are cut; None: the mission's.
    a, b
        How the maps are made; a suite takes missing keys from the scenario.
    """

    name: str
    overlap: float | None = None
    a: MapSpec = field(default_factory=MapSpec)
    b: MapSpec = field(default_factory=MapSpec)

    def __post_init__(self) -> None:
        require_name(self.name)
        if self.overlap is not None and not 0.1 <= self.overlap <= 1.0:
            raise InputError(f"overlap must be 0.1 to 1.0, got {self.overlap}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """Building, mission, two maps and noise levels of one kind of pair.

    Every seed is a building and a mission of its own, and yields one pair per variant and noise level. So splits,
    which belong to the scenario, never share a building.

    Parameters
    ----------
    name
        Determines, with the seed, everything that is random.
    seeds
        One mission each.
    split
        Whether the pairs are for choosing constants, "train", or for reporting, "test".
    kind
        "related", or how two unrelated maps come about: see `scenarios.suites.unrelated`.
    noise
        Different noise levels, 0 to 3 or "cells-1" to "cells-3".
    world, mission
        The building, and how the robots explore it.
    other
        The building of map B, for kinds of two buildings; None is `world`.
    a, b
        How the maps are made.
    variants
        Several ways to make the maps of every mission; empty for `a` and `b` alone.

    Raises
    ------
    InputError
        If a value is out of range, or values exclude each other.
    """

    name: str
    seeds: Seeds = field(default_factory=Seeds)
    split: Split = "test"
    kind: PairKind = "related"
    noise: tuple[NoiseLevel, ...] = (0,)
    world: WorldSpec = field(default_factory=Office)
    mission: MissionSpec = field(default_factory=MissionSpec)
    other: WorldSpec | None = None
    a: MapSpec = field(default_factory=MapSpec)
    b: MapSpec = field(default_factory=MapSpec)
    variants: tuple[Variant, ...] = ()

    def __post_init__(self) -> None:
        require_name(self.name)
        unknown = [level for level in self.noise if level not in NOISE_LEVELS]
        if unknown or not self.noise or len(set(self.noise)) != len(self.noise):
            raise InputError(f"noise must list different levels of {list(NOISE_LEVELS)}, got {list(self.noise)}")
        names = [variant.name for variant in self.variants]
        if len(set(names)) != len(names):
            raise InputError("variants: two have the same name")
        if self.kind in UNRELATED:
            self._check_unrelated()
        elif self.other is not None:
            raise InputError("other: is for pairs of two buildings")

    def _check_unrelated(self) -> None:
        """Refuse values that no unrelated pair can have."""
        if any(variant.overlap is not None for variant in self.variants):
            raise InputError("variants: unrelated maps have no overlap to want")
        if self.kind == "no-shared-room" and self.mission.overlap is not None:
            raise InputError("mission.overlap: maps with no shared room have none")
        if self.other is not None and self.kind not in OF_TWO_BUILDINGS:
            raise InputError(f'other: kind "{self.kind}" has one building')
        if self.other is not None and self.other.family != self.world.family:
            raise InputError(f"other: must be of the same family, {self.world.family}, got {self.other.family}")
        if self.kind == "other-storey" and not self.world.has_storeys:
            raise InputError(f"world.family: a building of family {self.world.family} has one storey only")
        if self.kind == "blank-halls":
            if not isinstance(self.world, Hall):
                raise InputError(f'world.family: must be "hall" with kind "blank-halls", got "{self.world.family}"')
            sizes = self.world.size_m, (self.other or self.world).size_m
            if max(max(p / q, q / p) for p, q in zip(*sizes, strict=True)) < OTHER_SIZE:
                raise InputError(
                    f"other.size_m: halls must differ by a tenth, got {list(sizes[0])} and {list(sizes[1])}"
                )


def require_name(name: str) -> None:
    """Refuse a name that does not go into ids."""
    if not name or not name.replace("-", "").replace("_", "").replace(".", "").isalnum():
        raise InputError(f"name must be letters, digits, - and _, got {name!r}")
