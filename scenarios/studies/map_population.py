"""Populations of maps with their descriptors: those of real data sets, and those of simulated missions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.descriptors import describe_map
from rectmerge.errors import SimulationError
from rectmerge.grid import OccupancyGrid
from scenarios.corruption.noise_levels import Noise, NoiseLevel
from scenarios.dataset.reader import open_dataset
from scenarios.execution.executors import completed
from scenarios.pairs.map_view import place_map
from scenarios.suites.mission_source import MissionSource
from scenarios.suites.spec import UNRELATED
from scenarios.suites.suite import load_suite
from sim.missions.mission_log import MissionLog

SUITE = "standard"  # whose maps A, of the robots' true and own poses, are compared with real ones
REAL = ("real_places", "real_lasers")


@dataclass(frozen=True, slots=True)
class DescribedMap:
    """Descriptors of one map, by name, and what the map shows.

    Parameters
    ----------
    group
        Its place, or the family of its building: no fold parts a group.
    free_cells
        Number of its free cells.
    descriptors
        By name, those that it has.
    grid
        The map.
    """

    group: str
    free_cells: int
    descriptors: Mapping[str, float]
    grid: OccupancyGrid

    @classmethod
    def from_grid(cls, grid: OccupancyGrid, group: str) -> DescribedMap:
        """Describe a map."""
        return cls(group, int(grid.free.sum()), describe_map(grid).as_dict(), grid)


@dataclass(frozen=True, slots=True, eq=False)
class MappedMission:
    """Mission whose map A is made under any noise; its poses are estimated once.

    Parameters
    ----------
    source, log
        The mission.
    poses
        Poses of robot A's scans as the robot has them, shape (S, 3).
    """

    source: MissionSource
    log: MissionLog
    poses: NDArray[np.float64]

    def described(self, noise: NoiseLevel | Noise) -> DescribedMap:
        """Make map A under a noise, and describe it."""
        placed = place_map(
            self.log.a,
            self.log.spec.a.lidar,
            self.source.scenario.a,
            noise=noise,
            seed=np.random.SeedSequence(self.source.seed),
            scan_poses=self.poses,
        )
        return DescribedMap.from_grid(placed.grid, self.log.world.family)


def real_population(maps: Path, names: Sequence[str] = REAL) -> list[DescribedMap]:
    """Describe the first map of every pair of real data sets, each once; windows cut out of a map are left out."""
    population: dict[tuple[str, bytes], DescribedMap] = {}
    for name in names:
        for source in open_dataset(maps / name):
            for pair in source.pairs():
                key = (name, pair.a.occupancy.tobytes())
                if pair.info.get("variant") not in ("crop", "negative") and key not in population:
                    population[key] = DescribedMap.from_grid(pair.a, pair.place.split("+")[0])
    return list(population.values())


def run_missions(
    count: int,
    *,
    split: str,
    noise: NoiseLevel = 1,
    executor: Executor | None = None,
    on_done: Callable[[str], None] = lambda source_id: None,
) -> list[MappedMission]:
    """Run missions of the suite `standard`, taken evenly from those of a split that give related pairs.

    Parameters
    ----------
    count
        Number of missions; those that fail are left out.
    split
        "train" or "test".
    noise
        Level under which the poses are estimated.
    executor
        Where missions are run; None is this process.
    on_done
        Called with the name of each mission.
    """
    sources = [
        source
        for source in load_suite(SUITE).missions()
        if source.scenario.split == split and source.scenario.kind not in UNRELATED
    ]
    taken = [sources[k] for k in np.linspace(0, len(sources) - 1, min(count, len(sources))).astype(int)]
    missions = []
    for source, future in completed(executor, run_mapped, ((source, noise) for source in taken)):
        if (mission := future.result()) is not None:
            missions.append(mission)
        on_done(source[0].source_id)
    return missions


def run_mapped(task: tuple[MissionSource, NoiseLevel]) -> MappedMission | None:
    """Run one mission and estimate the poses of robot A; None where it fails."""
    source, noise = task
    try:
        log = source.mission()
        seed = np.random.SeedSequence(source.seed)
        placed = place_map(log.a, log.spec.a.lidar, source.scenario.a, noise=noise, seed=seed)
    except SimulationError:
        return None
    return MappedMission(source, log, placed.poses)


def values_of(population: Iterable[DescribedMap], name: str) -> NDArray[np.float64]:
    """Return a descriptor of those maps that have it, shape (N,)."""
    return np.array([one.descriptors[name] for one in population if name in one.descriptors])
