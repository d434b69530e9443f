"""Suites of scenarios, read from TOML; an unknown key is refused with its path."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from rectmerge.errors import InputError, ScenarioError
from scenarios.corruption.noise_levels import in_cells
from scenarios.pairs.map_view import MapSpec
from scenarios.suites.fleet import FleetScenario, FleetSource
from scenarios.suites.mission_source import MissionSource
from scenarios.suites.random_values import extreme_values, has_random_values, is_random, sample_values
from scenarios.suites.spec import Scenario, Seeds
from scenarios.suites.toml_tables import structure

__all__ = ["ContenderSpec", "ScenarioTemplate", "Suite", "load_suite", "suite_names", "with_cell_noise"]

SUITES = Path(__file__).parent
LEAST_RATIO = 0.1  # cells of A per cell of B


@dataclass(frozen=True, slots=True, kw_only=True)
class ContenderSpec:
    """Contender as a suite declares it: its label, the name of its method, and fields to set."""

    label: str
    method: str
    set: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class ScenarioTemplate:
    """Scenario with values left open, in the forms of `scenarios.suites.random_values`.

    Parameters
    ----------
    name, seeds
        The scenario's.
    table
        Its table in the suite.
    at
        Its path in the file.
    is_fixed
        Whether no value is left open, so that all seeds share one scenario.
    """

    name: str
    seeds: Seeds
    table: Mapping[str, Any]
    at: str
    is_fixed: bool

    def by_seed(self) -> dict[int, Scenario | FleetScenario]:
        """Return the scenario of every seed.

        Raises
        ------
        ScenarioError
            If the values drawn for a seed exclude each other.
        """
        seeds = range(self.seeds.first, self.seeds.first + self.seeds.count)
        if self.is_fixed:
            return dict.fromkeys(seeds, self._settled(self.table, self.seeds))
        return {seed: self._settled(self._drawn(seed), replace(self.seeds, first=seed, count=1)) for seed in seeds}

    def _drawn(self, seed: int) -> dict[str, Any]:
        first, entropy = self.seeds.first, self.seeds.entropy(seed)
        table: dict[str, Any] = sample_values(self.table, name=self.name, seed=seed, first=first, entropy=entropy)
        return table

    def check(self) -> None:
        """Refuse ranges of a wrong form, and values that no scenario allows: the ends of ranges, and all choices."""
        try:
            for table in extreme_values(self.table):
                self._settled(table, self.seeds)
        except ScenarioError:  # its path is complete
            raise
        except InputError as error:
            raise ScenarioError(f"{self.at}.{error}") from error

    def _settled(self, table: Mapping[str, Any], seeds: Seeds) -> Scenario | FleetScenario:
        """Make the scenario of a table without open values, each variant laid over the scenario's own maps.

        The key `maps` makes it one of fleets.
        """
        if "maps" in table:
            return replace(structure(table, FleetScenario, self.at), seeds=seeds)
        whole, variants = _with_ratio(table, self.at), table.get("variants", ())
        if isinstance(variants, list) and all(isinstance(variant, dict) for variant in variants):
            maps = {key: table[key] for key in ("a", "b", "ratio") if key in table}
            ways = [
                _with_ratio(_merged(maps, variant), f"{self.at}.variants[{k}]") for k, variant in enumerate(variants)
            ]
            whole |= {"variants": ways} if ways else {}
        return replace(structure(whole, Scenario, self.at), seeds=seeds)


@dataclass(frozen=True, slots=True, kw_only=True)
class Suite:
    """Scenarios and contenders of a suite file, whose name it has.

    Parameters
    ----------
    name, title, description
        Of the suite.
    version
        Counts changes of what the suite's levels of noise mean; figures of two versions do not compare.
    cell_noise
        Whether levels 1 to 3 are "cells-1" to "cells-3", as in version 1 of all suites.
    methods, templates
        Contenders, and scenarios.
    """

    name: str
    title: str
    description: str = ""
    version: int = 1
    cell_noise: bool = False
    methods: tuple[ContenderSpec, ...] = ()
    templates: tuple[ScenarioTemplate, ...] = ()

    @property
    def scenarios(self) -> tuple[Scenario, ...]:
        """Every scenario of pairs with all of its seeds, or one per seed where it leaves values open.

        Raises
        ------
        ScenarioError
            If the values drawn for a seed exclude each other.
        """
        return tuple(
            scenario
            for template in self.templates
            for scenario in dict.fromkeys(self._settled(template).values())
            if isinstance(scenario, Scenario)
        )

    def missions(self) -> list[MissionSource]:
        """Return the sources that are missions of two robots, in order; raises as `scenarios` does."""
        return [source for source in self.sources() if isinstance(source, MissionSource)]

    def sources(self) -> list[MissionSource | FleetSource]:
        """Return one source of pairs per mission or fleet: each scenario's seeds in order; raises as `scenarios`."""
        return [
            MissionSource(self.name, scenario, seed, version=self.version)
            if isinstance(scenario, Scenario)
            else FleetSource(self.name, scenario, seed, version=self.version)
            for template in self.templates
            for seed, scenario in self._settled(template).items()
        ]

    def _settled(self, template: ScenarioTemplate) -> dict[int, Scenario | FleetScenario]:
        """Return the scenario of each seed."""
        try:
            scenarios = template.by_seed()
        except ScenarioError as error:
            raise _in_file(error, f"{self.name}.toml") from error
        if not self.cell_noise:
            return scenarios
        return {seed: _in_cells(scenario) for seed, scenario in scenarios.items()}


def _in_cells(scenario: Scenario | FleetScenario) -> Scenario | FleetScenario:
    """Return a scenario with even noise of the cells in place of levels 1 to 3."""
    if isinstance(scenario, Scenario):
        return replace(scenario, noise=tuple(map(in_cells, scenario.noise)))
    return replace(scenario, noise=in_cells(scenario.noise))


def with_cell_noise(suite: Suite) -> Suite:
    """Return a suite whose levels of noise are even noise of the cells: its version 1."""
    return replace(suite, version=1, cell_noise=True)


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
    except RecursionError:
        raise ScenarioError(f"{path.name}: its lists or tables are nested too deep") from None
    try:
        return _suite(data, path.stem)
    except ScenarioError as error:
        raise _in_file(error, path.name) from error


def _in_file(error: ScenarioError, file: str) -> ScenarioError:
    """Name the file in every line of an error."""
    return ScenarioError("; ".join(f"{file}: {line}" for line in str(error).splitlines()))


def _suite(data: dict[str, Any], name: str) -> Suite:
    """Make a suite from its file's content, each scenario laid over the table `base`."""
    base, tables = data.pop("base", {}), data.pop("scenarios", [])
    if unknown := sorted(data.keys() & {"name", "templates"}):
        raise ScenarioError(f"unknown key {unknown[0]!r}")
    if not isinstance(base, dict):
        raise ScenarioError("base: must be a table")
    if not isinstance(tables, list) or not tables:
        raise ScenarioError("scenarios: there are none, so there is nothing to run")
    suite = structure({**data, "name": name}, Suite)
    templates = [_template(base, table, f"scenarios[{k}]") for k, table in enumerate(tables)]
    names = [template.name for template in templates]
    if len(set(names)) != len(names):
        raise ScenarioError("scenarios: two have the same name")
    for template in templates:
        template.check()
    return replace(suite, templates=tuple(templates))


def _template(base: dict[str, Any], table: Any, at: str) -> ScenarioTemplate:
    if not isinstance(table, dict):
        raise ScenarioError(f"{at}: must be a table")
    whole = _merged(base, table)
    name = structure(whole.get("name", ""), str, f"{at}.name")
    seeds = structure(whole.get("seeds", {}), Seeds, f"{at}.seeds")
    if whole.get("kind") == "other-building" and "other" not in whole:
        whole["other"] = whole.get("world", {})  # its open values are drawn apart from the world's
    return ScenarioTemplate(name=name, seeds=seeds, table=whole, at=at, is_fixed=not has_random_values(whole))


def _with_ratio(table: Mapping[str, Any], at: str) -> dict[str, Any]:
    """Replace the key `ratio`, cells of A per cell of B, by B's resolution."""
    whole = dict(table)
    if "ratio" not in whole:
        return whole
    ratio = structure(whole.pop("ratio"), float, f"{at}.ratio")
    a, b = whole.get("a", {}), whole.get("b", {})
    if not LEAST_RATIO <= ratio <= 1 / LEAST_RATIO:
        raise ScenarioError(f"{at}.ratio: must be {LEAST_RATIO} to {1 / LEAST_RATIO:g}, got {ratio}")
    if not isinstance(a, dict) or not isinstance(b, dict):
        return whole  # refused later
    if "resolution" in b:
        raise ScenarioError(f"{at}.b.resolution: excludes ratio, which sets it")
    resolution = structure(a.get("resolution", MapSpec().resolution), float, f"{at}.a.resolution")
    return {**whole, "b": {**b, "resolution": ratio * resolution}}


def _merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Lay a table over another, key by key; an open value is replaced whole."""
    both = dict(base)
    for key, value in over.items():
        under = base.get(key)
        if isinstance(under, dict) and isinstance(value, dict) and not is_random(under) and not is_random(value):
            value = _merged(under, value)
        both[key] = value
    return both
