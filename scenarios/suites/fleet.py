"""Fleets: maps of a building by the robots of several missions, maps of a sibling building mixed in, and all pairs."""

from __future__ import annotations

import itertools
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError, SimulationError
from scenarios.corruption import NOISE_LEVELS, NoiseLevel
from scenarios.pairs.map_view import MapSpec, place_map
from scenarios.pairs.pair import MapPair, map_attributes, pair_from_maps
from scenarios.pairs.truth import ScannedSurface, common_points, is_on_wall
from scenarios.suites.spec import Seeds, Split, require_name
from sim.floorplans import Office, WorldSpec, make_world
from sim.missions.mission import MOST_ROBOTS, run_fleet
from sim.missions.mission_log import FEWEST_SCANS, RobotLog
from sim.missions.spec import MissionSpec
from sim.sensors.lidar import Lidar
from sim.world import World

HOME, SIBLING = "home", "sibling"
MAX_MISSIONS = 12  # in a building, failed ones included
MOST_MAPS = 100


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetScenario:
    """Building, missions and maps of one kind of fleet; every seed is a fleet in buildings of its own.

    Parameters
    ----------
    name, seeds, split
        As of a `Scenario`.
    noise
        Noise level of all maps.
    world
        Parameters of both buildings, which have different seeds.
    mission
        Settings of the missions; robots 0, 2, 4 ... are like its `a`, the others like its `b`.
    robots
        Robots that drive in one mission, 2 to 8.
    maps, siblings
        Maps of the building, 3 at least, and of its sibling; of as many missions as that takes.
    stretch
        Least and largest share of its drive that a robot maps: a random stretch of it.
    resolution
        Smallest and largest cells, metres; each map's are drawn between, halves as likely as doubles.
    map
        Further settings of every map; its resolution is not used.
    is_growing
        Whether the maps come one after the other, in the order of their names.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    name: str
    seeds: Seeds = field(default_factory=Seeds)
    split: Split = "test"
    noise: NoiseLevel = 1
    world: WorldSpec = field(default_factory=Office)
    mission: MissionSpec = field(default_factory=MissionSpec)
    robots: int = 4
    maps: int = 8
    siblings: int = 0
    stretch: tuple[float, float] = (0.25, 0.6)
    resolution: tuple[float, float] = (0.045, 0.09)
    map: MapSpec = field(default_factory=lambda: MapSpec(turn_deg="random"))
    is_growing: bool = False

    def __post_init__(self) -> None:
        require_name(self.name)
        if self.noise not in NOISE_LEVELS:
            raise InputError(f"noise must be one of {list(NOISE_LEVELS)}, got {self.noise!r}")
        if not 2 <= self.robots <= MOST_ROBOTS:
            raise InputError(f"robots must be 2 to {MOST_ROBOTS}, got {self.robots}")
        if not 3 <= self.maps <= MOST_MAPS or not 0 <= self.siblings <= MOST_MAPS:
            limits = f"3 to {MOST_MAPS} maps and 0 to {MOST_MAPS} siblings"
            raise InputError(f"a fleet has {limits}, got {self.maps} and {self.siblings}")
        for name, (low, high), (least, most) in (
            ("stretch", self.stretch, (0.05, 1.0)),
            ("resolution", self.resolution, (0.005, 1.0)),
        ):
            if not least <= low <= high <= most:
                raise InputError(f"{name} must be two ascending numbers within {least} to {most}, got {low} and {high}")
        if self.mission.overlap is not None:
            raise InputError("mission.overlap: maps of a fleet have what overlap they have")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FleetMap:
    """Map of a fleet with what its robot scanned, in which building.

    Parameters
    ----------
    name
        In the fleet.
    place
        "home" or "sibling".
    world
        The building.
    lidar
        The robot's scanner.
    spec
        Settings of the map.
    surface
        What the robot scanned, and the map.
    """

    name: str
    place: str
    world: World
    lidar: Lidar
    spec: MapSpec
    surface: ScannedSurface


@dataclass(frozen=True, slots=True)
class FleetSource:
    """One fleet, a source of all pairs of its maps; picklable, and cheap until `pairs` is called.

    Parameters
    ----------
    suite, scenario, seed
        Suite's name, scenario and seed of the fleet.
    version
        The suite's: rows of another version are other rows.
    """

    suite: str
    scenario: FleetScenario
    seed: int
    version: int = 1

    @property
    def source_id(self) -> str:
        """Name of the scenario, and the seed."""
        return f"{self.scenario.name}-{self.seed:04d}"

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """One id for every two maps."""
        return tuple(self._pair_id(i, j) for i, j in self._index_pairs())

    def is_related(self, pair_id: str) -> bool:
        """Return whether the maps of a pair are of one building; too little in common makes them unrelated still."""
        _, i, j = pair_id.rsplit("-", 2)
        return (int(i) < self.scenario.maps) == (int(j) < self.scenario.maps)

    def maps(self) -> list[FleetMap]:
        """Run the missions and make the maps, those of the sibling building last.

        Raises
        ------
        SimulationError
            If not enough missions succeed.
        """
        made: list[FleetMap] = []
        for place, count in ((HOME, self.scenario.maps), (SIBLING, self.scenario.siblings)):
            world = make_world(self.scenario.world, self._seed(place)) if count else None
            drives = self._drives(world, place, count) if world else ()
            for log, robot in itertools.islice(drives, count):
                assert world is not None
                made.append(self._map(len(made), place, world, log, robot))
        return made

    def pairs(self) -> Iterator[MapPair]:
        """Make the maps and yield every pair of them; raises as `maps` does."""
        maps = self.maps()
        for i, j in self._index_pairs():
            yield self._pair(i, j, maps[i], maps[j])

    def _index_pairs(self) -> Iterator[tuple[int, int]]:
        return itertools.combinations(range(self.scenario.maps + self.scenario.siblings), 2)

    def _pair_id(self, i: int, j: int) -> str:
        return f"{self.source_id}-{i:02d}-{j:02d}"

    def _drives(self, world: World, place: str, count: int) -> Iterator[tuple[RobotLog, int]]:
        """Yield `count` robots' logs of missions in a building, with the robots' numbers."""
        left, failures = count, list[str]()
        for mission in range(MAX_MISSIONS):
            robots = min(self.scenario.robots, max(2, left))
            try:
                logs = run_fleet(world, self.scenario.mission, robots, self._seed(f"{place} mission {mission}"))
            except SimulationError as error:
                failures.append(str(error))
                continue
            yield from ((log, number) for number, log in enumerate(logs))
            left -= len(logs)
            if left <= 0:
                return
        reason = failures[-1] if failures else "one makes few maps"
        raise SimulationError(f"{MAX_MISSIONS} missions do not make {count} maps: {reason}")

    def _map(self, index: int, place: str, world: World, log: RobotLog, robot: int) -> FleetMap:
        """Map a random stretch of a drive, in cells of a random size."""
        scenario, rng = self.scenario, np.random.default_rng(self._seed(f"map {index}"))
        lidar = (scenario.mission.a, scenario.mission.b)[robot % 2].lidar
        part = _stretch(log, float(rng.uniform(*scenario.stretch)), float(rng.random()))
        resolution = float(np.exp(rng.uniform(*np.log(scenario.resolution))))
        spec = replace(scenario.map, resolution=resolution)
        seed = np.random.SeedSequence(self._seed(f"view {index}"))
        placed = place_map(part, lidar, spec, noise=scenario.noise, seed=seed)
        return FleetMap(
            name=f"{place}-{index:02d}",
            place=place,
            world=world,
            lidar=lidar,
            spec=spec,
            surface=ScannedSurface.from_log(part, lidar, placed),
        )

    def _pair(self, i: int, j: int, a: FleetMap, b: FleetMap) -> MapPair:
        rng, points = np.random.default_rng(self._seed(f"points {i} {j}")), None
        if a.place == b.place:

            def is_wall(at: NDArray[np.float64]) -> NDArray[np.bool_]:
                return is_on_wall(a.world, at, a.lidar.height_m) & is_on_wall(a.world, at, b.lidar.height_m)

            points = common_points(a.surface, b.surface, rng, is_surface=is_wall)
        placed = a.surface.placed, b.surface.placed
        info = {
            "fleet": self.source_id,
            "map_a": a.name,
            "map_b": b.name,
            "place_a": a.place,
            "place_b": b.place,
            "is_growing": self.scenario.is_growing,
            "split": self.scenario.split,
            "family": a.world.family,
            "noise": self.scenario.noise,
            "suite_version": self.version,
            "pose_source": self.scenario.map.poses,
            **map_attributes("a", placed[0], a.spec),
            **map_attributes("b", placed[1], b.spec),
        }
        pair = pair_from_maps(
            *placed,
            points,
            pair_id=self._pair_id(i, j),
            suite=self.suite,
            place=f"{self.suite}/{self.source_id}",
            info=info,
        )
        return replace(pair, files=(f"{self.source_id}_{i:02d}", f"{self.source_id}_{j:02d}"))

    def _seed(self, purpose: str) -> int:
        """Derive a seed that fleets and purposes do not share."""
        key = tuple(zlib.crc32(text.encode()) for text in (self.scenario.name, purpose))
        return self.scenario.seeds.derive(self.seed, key)


def _stretch(log: RobotLog, share: float, start: float) -> RobotLog:
    """Return a stretch of a drive: a share of its scans, that begins at a share of what is left."""
    scans = len(log.times)
    count = min(scans, max(FEWEST_SCANS, round(share * scans)))
    first = int(start * (scans - count + 1))
    part = slice(first, first + count)
    return replace(
        log,
        times=log.times[part],
        poses=log.poses[part],
        odometry=log.odometry[part],
        ranges=log.ranges[part],
        glass=None if log.glass is None else log.glass[part],
        rooms=(),
        entered=(),
    )
