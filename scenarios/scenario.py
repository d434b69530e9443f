"""What is evaluated: suites of scenarios, read from TOML; an unknown key is refused with its path."""

from __future__ import annotations

import tomllib
import zlib
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import cattrs
import numpy as np
from cattrs.gen import make_dict_structure_fn

from rectmerge.errors import InputError, ScenarioError, SimulationError
from scenarios.corruption import NOISE_LEVELS
from scenarios.pairs import MapPair, make_pair
from scenarios.placement import MapSpec
from sim.floorplans import FAMILIES, Office, WorldSpec, make_world
from sim.lidar import Lidar, lidar_named
from sim.mission import MissionLog, MissionSpec, cut_to_overlap, run_mission

SUITES = Path(__file__).parent / "suites"
OVERLAP_WITHIN = 0.05  # of a wanted overlap
CUTS = 4  # of a log, at the most, until its finished maps have the wanted overlap


@dataclass(frozen=True, slots=True, kw_only=True)
class Contender:
    """A method as a suite runs it: a label for tables, the registered name, and the fields it sets."""

    label: str
    method: str
    set: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class Seeds:
    """The seeds first, first + 1, ...: `count` of them."""

    first: int = 0
    count: int = 1

    def __post_init__(self) -> None:
        if self.first < 0 or self.count < 1:
            raise InputError(f"seeds need first >= 0 and count >= 1, got {self.first} and {self.count}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenario:
    """One kind of pair: a kind of building, how it is explored, how the two maps are made, and at which noise.

    Every seed is a building and a mission of its own, and yields one pair per noise level.
    """

    name: str
    seeds: Seeds = field(default_factory=Seeds)
    noise: tuple[int, ...] = (0,)
    world: WorldSpec = field(default_factory=Office)
    mission: MissionSpec = field(default_factory=MissionSpec)
    a: MapSpec = field(default_factory=MapSpec)
    b: MapSpec = field(default_factory=MapSpec)

    def __post_init__(self) -> None:
        if not self.name or not self.name.replace("-", "").replace("_", "").isalnum():
            raise InputError(f"name must be letters, digits, - and _, got {self.name!r}")
        unknown = [level for level in self.noise if level not in NOISE_LEVELS]
        if unknown or not self.noise or len(set(self.noise)) != len(self.noise):
            raise InputError(f"noise must list different levels of {list(NOISE_LEVELS)}, got {list(self.noise)}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Suite:
    """What a suite file says; `name` is the file's."""

    name: str
    title: str
    description: str = ""
    methods: tuple[Contender, ...] = ()
    scenarios: tuple[Scenario, ...] = ()

    def sources(self) -> list[MissionSource]:
        """Return one source of pairs per mission: each scenario's seeds in order."""
        return [
            MissionSource(self.name, scenario, seed)
            for scenario in self.scenarios
            for seed in range(scenario.seeds.first, scenario.seeds.first + scenario.seeds.count)
        ]


@dataclass(frozen=True, slots=True)
class MissionSource:
    """One mission to run and the pairs made from it: a `PairSource`, picklable and cheap until asked."""

    suite: str
    scenario: Scenario
    seed: int

    @property
    def source_id(self) -> str:
        """The scenario and the seed."""
        return f"{self.scenario.name}-{self.seed:04d}"

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """One id per noise level."""
        return tuple(f"{self.source_id}-n{noise}" for noise in self.scenario.noise)

    def mission(self) -> MissionLog:
        """Make the building and run the mission."""
        world = make_world(self.scenario.world, self._seed("world"))
        return run_mission(world, self.scenario.mission, self._seed("mission"))

    def pairs_of(self, log: MissionLog) -> Iterator[MapPair]:
        """Make the pairs of a mission that has been run.

        Noise and wrong poses change what a map shows: where a wanted overlap is missed by more than 0.05, the logs are
        cut anew for a little more or less.

        Raises
        ------
        SimulationError
            If no cut gives finished maps of the wanted overlap; the message says what they have.
        """
        for noise, pair_id in zip(self.scenario.noise, self.pair_ids, strict=True):
            pair = self._pair(log, noise, pair_id)
            wanted = self.scenario.mission.overlap
            yield pair if wanted is None or log.whole is None else self._recut(log.whole, wanted, pair, noise)

    def _recut(self, whole: MissionLog, wanted: float, pair: MapPair, noise: int) -> MapPair:
        aim = wanted
        for _ in range(CUTS):
            if _is_met(pair, wanted):
                return pair
            aim = min(1.0, max(0.1, aim + wanted - (pair.overlap or 0.0)))
            try:
                pair = self._pair(cut_to_overlap(whole, aim), noise, pair.pair_id)
            except SimulationError:  # the logs hold no such cut
                break
        shown = "too little in common" if pair.overlap is None else f"an overlap of {pair.overlap:.2f}"
        if not _is_met(pair, wanted):
            raise SimulationError(f"{pair.pair_id}: the finished maps have {shown}, wanted was {wanted:.2f}")
        return pair

    def _pair(self, log: MissionLog, noise: int, pair_id: str) -> MapPair:
        specs, place = (self.scenario.a, self.scenario.b), f"{self.suite}/{self.source_id}"
        return make_pair(log, *specs, self._seed("pair"), noise=noise, pair_id=pair_id, suite=self.suite, place=place)

    def pairs(self) -> Iterator[MapPair]:
        """Run the mission and make its pairs."""
        return self.pairs_of(self.mission())

    def _seed(self, purpose: Literal["world", "mission", "pair"]) -> int:
        """Derive a seed that scenarios and purposes do not share."""
        key = tuple(zlib.crc32(text.encode()) for text in (self.scenario.name, purpose))
        return int(np.random.SeedSequence(self.seed, spawn_key=key).generate_state(1)[0])


def _is_met(pair: MapPair, wanted: float) -> bool:
    return pair.overlap is not None and abs(pair.overlap - wanted) <= OVERLAP_WITHIN


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
    return _structure(data, path)


def _structure(data: dict[str, Any], path: Path) -> Suite:
    if "name" in data:
        raise ScenarioError(f"{path.name}: unknown key 'name'")
    try:
        suite = _converter().structure({**data, "name": path.stem}, Suite)
    except cattrs.BaseValidationError as error:
        raise ScenarioError("; ".join(f"{path.name}: {line}" for line in _complaints(error, ""))) from error
    if not suite.scenarios:
        raise ScenarioError(f"{path.name}: scenarios: there are none, so there is nothing to run")
    names = [scenario.name for scenario in suite.scenarios]
    if len(set(names)) != len(names):
        raise ScenarioError(f"{path.name}: scenarios: two have the same name")
    return suite


def _complaints(error: BaseException, at: str) -> list[str]:
    """Flatten cattrs' tree of errors into lines ``path: complaint``."""
    if isinstance(error, cattrs.ForbiddenExtraKeysError):
        return [f"{at}unknown key {key!r}" for key in sorted(error.extra_fields)]
    if isinstance(error, BaseExceptionGroup):
        return [line for child in error.exceptions for line in _complaints(child, _path(at, child))]
    if isinstance(error, KeyError):
        return [f"{at}missing"]
    if isinstance(error, TypeError | AttributeError):  # how cattrs meets a number where a table or a list should be
        return [f"{at}must be a table or a list of the documented form"]
    return [f"{at}{error}"]


def _path(at: str, error: BaseException) -> str:
    """Add the step to a child, which cattrs leaves in its notes."""
    base = at.removesuffix(": ")
    for note in getattr(error, "__notes__", ()):
        if isinstance(note, cattrs.IterableValidationNote):
            return f"{base}[{note.index}]: "
        if isinstance(note, cattrs.AttributeValidationNote):
            return f"{base}.{note.name}: " if base else f"{note.name}: "
    return at


def _converter() -> cattrs.Converter:
    """A converter that takes no text for a number and no unknown key."""
    converter = cattrs.Converter(forbid_extra_keys=True)
    converter.register_structure_hook(int, lambda value, _: _exactly(value, int, "a whole number"))
    converter.register_structure_hook(float, lambda value, _: float(_exactly(value, (int, float), "a number")))
    converter.register_structure_hook(str, lambda value, _: _exactly(value, str, "text"))
    converter.register_structure_hook(bool, lambda value, _: _exactly(value, bool, "true or false"))
    converter.register_structure_hook(float | Literal["random"], lambda value, _: value)  # MapSpec checks it
    converter.register_structure_hook_func(lambda kind: kind is WorldSpec, lambda data, _: _world(data, converter))
    converter.register_structure_hook_func(lambda kind: str(get_origin(kind)) == "typing.Literal", _one_of)
    lidar = make_dict_structure_fn(Lidar, converter, _cattrs_forbid_extra_keys=True)
    converter.register_structure_hook(Lidar, lambda value, kind: _scanner(value, lambda table: lidar(table, kind)))
    return converter


def _scanner(value: Any, read: Callable[[dict[str, Any]], Lidar]) -> Lidar:
    """A scanner by the name of its profile, or a table, whose `profile` stands for the fields it leaves out."""
    if isinstance(value, str):
        return lidar_named(value)
    if "profile" not in value:
        return read(value)
    return read(asdict(lidar_named(value["profile"])) | {k: v for k, v in value.items() if k != "profile"})


def _world(data: dict[str, Any], converter: cattrs.Converter) -> WorldSpec:
    """Read a building's knobs; the key `family` says which there are."""
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
