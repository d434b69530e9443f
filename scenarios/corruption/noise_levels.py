"""Noise levels by name: 0 to 3, fitted to maps of robots, and `cells-1` to `cells-3`, even noise of the cells."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from scenarios.corruption.cell_noise import CellNoise
from scenarios.corruption.map_noise import MapNoise
from sim.missions.mission_log import RobotLog
from sim.sensors.lidar import Lidar

NoiseLevel = int | str
CELLS = "cells-"


class Noise(Protocol):
    """Noise of one level, of the scanner, the mapper and the cells."""

    def of_one_map(self, rng: np.random.Generator, /) -> Noise:
        """Draw the strengths of one map."""

    def read_out(self, log: RobotLog, lidar: Lidar, rng: np.random.Generator) -> NDArray[np.float64]:
        """Report the ranges of a log, shape (S, B), metres: inf where nothing is in reach, nan where lost."""

    def least_evidence(self, hit: float, miss: float) -> float:
        """Return the log-odds up to which a cell stays unknown, given those of a hit and of a miss."""

    def add(self, grid: OccupancyGrid, rng: np.random.Generator) -> OccupancyGrid:
        """Corrupt the cells of a finished map."""


# source of levels 1 and 2: the search of `rectbench fit-noise` on maps of real_places and real_lasers and 20 missions
# of `standard`, train, stopped before its end; then two faults (dense_scans, erased_legs) were added, and the best of
# about ten bundles set by hand was taken, by the same measure; of 3: twice level 2, by hand
GOOD = MapNoise(
    scanner=0.2,
    windows=0.002,
    people_per_minute=2.0,
    offset_m=0.01,
    misses_unknown=1.2,
    dense_scans=0.4,
    erased_legs=0.4,
    thick_walls=0.008,
    broken_walls=0.002,
    pinholes=0.0002,
    specks=0.08,
    clutter=4.5,
    spread=1.0,
)
POOR = MapNoise(
    scanner=0.3,
    windows=0.008,
    people_per_minute=4.0,
    offset_m=0.015,
    misses_unknown=1.2,
    dense_scans=0.15,
    erased_legs=0.3,
    thick_walls=0.02,
    broken_walls=0.01,
    pinholes=0.001,
    specks=0.18,
    clutter=12.0,
    spread=1.0,
)
BEYOND = MapNoise(
    scanner=0.6,
    windows=0.016,
    people_per_minute=8.0,
    offset_m=0.03,
    misses_unknown=1.2,
    dense_scans=0.0,
    erased_legs=0.3,
    thick_walls=0.04,
    broken_walls=0.02,
    pinholes=0.002,
    specks=0.36,
    clutter=24.0,
    spread=1.0,
)
_ALL: dict[NoiseLevel, Noise] = {0: CellNoise(0.0), 1: GOOD, 2: POOR, 3: BEYOND}
_ALL |= {f"{CELLS}{level}": CellNoise(2.0 ** (level - 1)) for level in (1, 2, 3)}
NOISE: Mapping[NoiseLevel, Noise] = MappingProxyType(_ALL)
NOISE_LEVELS: tuple[NoiseLevel, ...] = tuple(NOISE)


def find_noise(level: NoiseLevel | Noise) -> Noise:
    """Return the noise of a level; a noise is returned as it is.

    Raises
    ------
    InputError
        If there is no such level.
    """
    if not isinstance(level, int | str | float):
        return level
    if level not in NOISE:
        raise InputError(f"noise must be one of {', '.join(map(str, NOISE_LEVELS))}, got {level!r}")
    return NOISE[level]


def add_noise(grid: OccupancyGrid, level: NoiseLevel, rng: np.random.Generator) -> OccupancyGrid:
    """Corrupt the cells of a finished map by a noise level, without the scanner's and the mapper's part.

    Parameters
    ----------
    grid
        The map.
    level
        0: untouched. 1: a good real map, 2: a poor one, 3: beyond. "cells-1" to "cells-3": even noise of the cells,
        see `scenarios.corruption.cell_noise`.
    rng
        The same map, level and generator give the same cells.

    Raises
    ------
    InputError
        If there is no such level.
    """
    of_map, of_cells = (rng, rng) if isinstance(find_noise(level), CellNoise) else rng.spawn(2)
    return find_noise(level).of_one_map(of_map).add(grid, of_cells)


def in_cells(level: NoiseLevel) -> NoiseLevel:
    """Return the level of even noise of the cells in place of level 1, 2 or 3; others as they are."""
    return f"{CELLS}{level}" if level in (1, 2, 3) else level
