"""Noise of a robot's map: causes in the scanner, the building and the mapper, and what is drawn on the finished map."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from scenarios.corruption.clumps import (
    broken_walls,
    clutter,
    dense_scans,
    erased_legs,
    pinholes,
    speck_clumps,
    thick_walls,
)
from sim.missions.mission_log import RobotLog
from sim.sensors.disturbances import Disturbances
from sim.sensors.lidar import Lidar

MOST_SPREADS = 2.0  # a map's own strength lies within so many standard deviations; source: hand
MOST_OFFSET_M = 0.05  # of whole scans, so that walls stay where the truth has them; source: hand
MOST_MISSES = 2.0  # up to which a cell may stay unknown, so that every mission gives a map; source: hand


@dataclass(frozen=True, slots=True, kw_only=True)
class MapNoise:
    """Medians of the strengths of one noise level; every map draws its own about them.

    Parameters
    ----------
    scanner
        Factor of the scanner's own noise, dropouts and mixed pixels.
    windows, people_per_minute, offset_m
        Disturbances of the scans: see `sim.sensors.disturbances.Disturbances`.
    misses_unknown
        Rays that may pass a cell, without a hit, while the mapper leaves it unknown; as many in log-odds for hits.
    dense_scans, erased_legs
        Shares of the gaps between rays that further scans would fill, and of the legs of furniture that are not seen.
    thick_walls, broken_walls, pinholes
        Shares of the cells beside walls, of the wall cells and of the free cells: see `scenarios.corruption.clumps`.
    specks
        Per 100 free cells, drawn on top of those of the scans.
    clutter
        Patches per 10,000 free cells.
    spread
        Standard deviation of the logarithm of a map's own strength, for each strength apart.

    Raises
    ------
    InputError
        If a strength is negative.
    """

    scanner: float
    windows: float
    people_per_minute: float
    offset_m: float
    misses_unknown: float
    dense_scans: float
    erased_legs: float
    thick_walls: float
    broken_walls: float
    pinholes: float
    specks: float
    clutter: float
    spread: float

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"{field.name} must be >= 0, got {value}")

    def of_one_map(self, rng: np.random.Generator) -> MapNoise:
        """Draw the strengths of one map."""
        names = [field.name for field in fields(self) if field.name != "spread"]
        exponents = self.spread * rng.standard_normal(len(names)).clip(-MOST_SPREADS, MOST_SPREADS)
        own = {name: getattr(self, name) * math.exp(x) for name, x in zip(names, exponents.tolist(), strict=True)}
        return replace(self, **own, spread=0.0)

    def read_out(self, log: RobotLog, lidar: Lidar, rng: np.random.Generator) -> NDArray[np.float64]:
        """Report the ranges of a log, shape (S, B), metres: inf where nothing is in reach, nan where lost."""
        disturbances = Disturbances(
            windows=min(1.0, self.windows),
            people_per_minute=self.people_per_minute,
            offset_m=min(MOST_OFFSET_M, self.offset_m),
        )
        of_building, of_scanner = rng.spawn(2)
        met = disturbances.disturb(log.ranges, log.poses, lidar.angles, log.times, of_building)
        return lidar.observe(met, log.glass, of_scanner, level=self.scanner)

    def least_evidence(self, hit: float, miss: float) -> float:
        """Return the log-odds up to which a cell stays unknown, given those of a hit and of a miss."""
        return min(self.misses_unknown, MOST_MISSES) * min(hit, miss)

    def add(self, grid: OccupancyGrid, rng: np.random.Generator) -> OccupancyGrid:
        """Draw on a finished map what the scans do not bring about; the same map and generator give the same cells."""
        of_rays, of_legs, of_walls, of_gaps, of_clutter, of_specks, of_floor = rng.spawn(7)
        grid = dense_scans(grid, self.dense_scans, of_rays)
        grid = erased_legs(grid, self.erased_legs, of_legs)
        grid = thick_walls(grid, self.thick_walls, of_walls)
        grid = broken_walls(grid, self.broken_walls, of_gaps)
        grid = clutter(grid, self.clutter, of_clutter)
        grid = speck_clumps(grid, self.specks, of_specks)
        return pinholes(grid, self.pinholes, of_floor)
