"""What is evaluated: suites of scenarios, read from TOML; an unknown key is refused with its path."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError, ScenarioError
from scenarios.drawing import corners, drawn, has_draws, is_draw
from scenarios.missionsource import MissionSource
from scenarios.placement import MapSpec
from scenarios.scenariospec import Scenario, Seeds
from scenarios.structuring import structured

__all__ = ["Contender", "Draft", "MissionSource", "Scenario", "Seeds", "Suite", "load_suite", "suite_names"]

SUITES = Path(__file__).parent / "suites"
LEAST_RATIO = 0.1  # cells of A per cell of B
GOLDEN = 0.6180339887498949  # its multiples, modulo 1, lie evenly however many there are
ROUNDS_PER_SEED = 10_000  # a suite is enlarged so many times, at the most, before it runs into its next seed


@dataclass(frozen=True, slots=True, kw_only=True)
class Contender:
    """A method as a suite runs it: a label for tables, the registered name, and the fields it sets."""

    label: str
    method: str
    set: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Draft:
    """A scenario as a suite has it, with what it leaves open: `scenarios.drawing` says how.

    Parameters
    ----------
    name, seeds
        The scenario's.
    table
        What the suite says of it.
    at
        Its path in the file.
    is_fixed
        Whether it leaves nothing open: all seeds share one scenario.
    """

    name: str
    seeds: Seeds
    table: Mapping[str, Any]
    at: str
    is_fixed: bool

    def scenario(self, seed: int) -> Scenario:
        """Settle what the table leaves open for a seed.

        Raises
        ------
        ScenarioError
            If what was drawn excludes each other.
        """
        if self.is_fixed:
            return self._settled(self.table)
        table = drawn(self.table, name=self.name, seed=seed, first=self.seeds.first)
        return self._settled({**table, "seeds": {"first": seed, "count": 1}})

    def check(self) -> None:
        """Refuse what no seed could settle: a bad range, and a lowest, highest or other choice that is not allowed."""
        try:
            for table in corners(self.table):
                self._settled(table)
        except ScenarioError:  # whose path is whole
            raise
        except InputError as error:
            raise ScenarioError(f"{self.at}.{error}") from error

    def _settled(self, table: Mapping[str, Any]) -> Scenario:
        """Make the scenario of a table without draws, where variants say only what is different."""
        whole, variants = _with_ratio(table, self.at), table.get("variants", ())
        if isinstance(variants, list) and all(isinstance(variant, dict) for variant in variants):
            maps = {key: table[key] for key in ("a", "b", "ratio") if key in table}
            ways = [
                _with_ratio(_merged(maps, variant), f"{self.at}.variants[{k}]") for k, variant in enumerate(variants)
            ]
            whole |= {"variants": ways} if ways else {}
        return structured(whole, Scenario, self.at)


@dataclass(frozen=True, slots=True, kw_only=True)
class Suite:
    """What a suite file says; `name` is the file's."""

    name: str
    title: str
    description: str = ""
    methods: tuple[Contender, ...] = ()
    drafts: tuple[Draft, ...] = ()

    @property
    def scenarios(self) -> tuple[Scenario, ...]:
        """Every scenario with all of its seeds, or one per seed where it leaves something open."""
        first = [[draft.seeds.first] if draft.is_fixed else _seeds(draft, 0) for draft in self.drafts]
        return tuple(draft.scenario(k) for draft, seeds in zip(self.drafts, first, strict=True) for k in seeds)

    def sources(self, *, pairs: int | None = None, seed: int = 0) -> list[MissionSource]:
        """Return one source of pairs per mission: each scenario's seeds in order.

        Parameters
        ----------
        pairs
            How many pairs, about: as few missions as give so many at least. Fewer than the suite has are spread over
            its scenarios; more are the suite again and again, each time with its next seeds.
        seed
            0 is the suite as it is written; another, the same with other buildings.
        """
        first = seed * ROUNDS_PER_SEED
        sources = self._round(first)
        if pairs is None:
            return sources
        each = sum(len(source.pair_ids) for source in sources)
        whole, rest = divmod(pairs, each)
        sources = [source for k in range(whole) for source in self._round(first + k)]
        return sources + _spread(self._round(first + whole), rest)

    def _round(self, number: int) -> list[MissionSource]:
        return [
            MissionSource(self.name, draft.scenario(seed), seed)
            for draft in self.drafts
            for seed in _seeds(draft, number)
        ]


def _seeds(draft: Draft, number: int) -> range:
    first = draft.seeds.first + number * draft.seeds.count
    return range(first, first + draft.seeds.count)


def _spread(sources: list[MissionSource], pairs: int) -> list[MissionSource]:
    """Choose sources from all over a list until they have so many pairs, and keep their order."""
    order = sorted(range(len(sources)), key=lambda k: (k * GOLDEN) % 1.0)
    chosen = []
    for k in order:
        if pairs <= 0:
            break
        chosen.append(k)
        pairs -= len(sources[k].pair_ids)
    return [sources[k] for k in sorted(chosen)]


def suite_names() -> tuple[str, ...]:
    """Return the names of the suites that come with the package."""
    return tuple(sorted(path.stem for path in SUITES.glob("*.toml")))


def load_suite(name_or_path: str | Path) -> Suite:
    """Read a suite by its name or from a file.

    Raises
    ------
    ScenarioError
        If there is no such suite, the file is not TOML, or a key or value is not allowed; the message names the file
        and the path of the key.
    """
    path = Path(name_or_path)
    if path.suffix != ".toml" and str(name_or_path) in suite_names():
        path = SUITES / f"{name_or_path}.toml"
    if path.suffix != ".toml":
        raise ScenarioError(
            f"no suite {str(name_or_path)!r}; there are: {', '.join(suite_names())}, or name a .toml file"
        )
    try:
        with path.open("rb") as file:
            data = tomllib.load(file)
    except OSError as error:
        raise ScenarioError(f"{path.name}: cannot be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ScenarioError(f"{path.name}: not TOML: {error}") from error
    try:
        return _suite(data, path.stem)
    except ScenarioError as error:
        raise ScenarioError("; ".join(f"{path.name}: {line}" for line in str(error).splitlines())) from error


def _suite(data: dict[str, Any], name: str) -> Suite:
    """Make a suite of its file's content; each scenario is laid over the table `base`."""
    base, tables = data.pop("base", {}), data.pop("scenarios", [])
    if unknown := sorted(data.keys() & {"name", "drafts"}):
        raise ScenarioError(f"unknown key {unknown[0]!r}")
    if not isinstance(base, dict):
        raise ScenarioError("base: must be a table")
    if not isinstance(tables, list) or not tables:
        raise ScenarioError("scenarios: there are none, so there is nothing to run")
    suite = structured({**data, "name": name}, Suite)
    drafts = [_draft(base, table, f"scenarios[{k}]") for k, table in enumerate(tables)]
    names = [draft.name for draft in drafts]
    if len(set(names)) != len(names):
        raise ScenarioError("scenarios: two have the same name")
    for draft in drafts:
        draft.check()
    return replace(suite, drafts=tuple(drafts))


def _draft(base: dict[str, Any], table: Any, at: str) -> Draft:
    if not isinstance(table, dict):
        raise ScenarioError(f"{at}: must be a table")
    whole = _merged(base, table)
    name = structured(whole.get("name", ""), str, f"{at}.name")
    seeds = structured(whole.get("seeds", {}), Seeds, f"{at}.seeds")
    if whole.get("kind") == "other-building" and "other" not in whole:
        whole["other"] = whole.get("world", {})  # where it leaves something open, drawn apart
    return Draft(name=name, seeds=seeds, table=whole, at=at, is_fixed=not has_draws(whole))


def _with_ratio(table: Mapping[str, Any], at: str) -> dict[str, Any]:
    """Turn the wish for a ratio, cells of A per cell of B, into B's resolution."""
    whole = dict(table)
    if "ratio" not in whole:
        return whole
    ratio = structured(whole.pop("ratio"), float, f"{at}.ratio")
    a, b = whole.get("a", {}), whole.get("b", {})
    if not LEAST_RATIO <= ratio <= 1 / LEAST_RATIO:
        raise ScenarioError(f"{at}.ratio: must be {LEAST_RATIO} to {1 / LEAST_RATIO:g}, got {ratio}")
    if not isinstance(a, dict) or not isinstance(b, dict):
        return whole  # which is refused as it is
    if "resolution" in b:
        raise ScenarioError(f"{at}.b.resolution: excludes ratio, which sets it")
    resolution = structured(a.get("resolution", MapSpec().resolution), float, f"{at}.a.resolution")
    return {**whole, "b": {**b, "resolution": ratio * resolution}}


def _merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Lay a table over another, key by key; a draw is one value."""
    both = dict(base)
    for key, value in over.items():
        under = base.get(key)
        if isinstance(under, dict) and isinstance(value, dict) and not is_draw(under) and not is_draw(value):
            value = _merged(under, value)
        both[key] = value
    return both
