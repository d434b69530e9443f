"""Recordings of a pair's robots: poses, scans and growing maps, in each robot's own frames, over time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.grid import OccupancyGrid
from scenarios.pairs.map_view import MapSpec, recorded_data
from scenarios.pairs.pair import MapPair, PairInputs
from sim.sensors.lidar import Lidar
from sim.slam.mapping import growing_maps
from sim.slam.poses import compose_poses, relative_poses

MAP_EVERY_S = 5.0
FIRST_SCANS = 4  # with readings, before the first map: a mapper leaves cells unknown that fewer have passed


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Recording:
    """One robot of a pair; S scans of B beams.

    Parameters
    ----------
    lidar, spec
        Its scanner, and how its map is made.
    times
        Shape (S,), simulated seconds.
    ranges
        What the scanner reported, shape (S, B), metres: inf where nothing is in reach, nan where a beam was lost.
    least_evidence
        Log-odds up to which its mapper leaves a cell unknown.
    wheels
        Poses by its wheels, shape (S, 3), in a frame that begins at its first pose.
    poses
        Poses of the scanner that its map is made by, shape (S, 3), in its map frame.
    grid
        Its map when it is done, as the pair has it, cell for cell; with its resolution even where that is hidden from
        methods, and then with the map frame at its lower-left corner.
    """

    lidar: Lidar
    spec: MapSpec
    least_evidence: float
    times: NDArray[np.float64]
    ranges: NDArray[np.float64]
    wheels: NDArray[np.float64]
    poses: NDArray[np.float64]
    grid: OccupancyGrid

    @property
    def drift(self) -> NDArray[np.float64]:
        """Poses of the wheels' frame in the map frame, shape (S, 3)."""
        return compose_poses(self.poses, relative_poses(self.wheels, np.zeros(3)))

    def maps(self) -> Iterator[tuple[int, OccupancyGrid]]:
        """Yield the map as it grows, every five seconds, each with the number of its last scan; last the finished one.

        All stand on the cells of the finished map. Corruptions come with the finished map only.
        """
        resolution, corner = self.grid.cell_size, np.array(self.grid.origin)
        readings = np.cumsum(~np.isnan(self.ranges).all(axis=1))
        first = int(np.argmax(readings >= FIRST_SCANS)) + 1
        wanted = np.arange(self.times[0] + MAP_EVERY_S, self.times[-1], MAP_EVERY_S)
        counts = [
            n for n in np.unique(np.searchsorted(self.times, wanted) + 1).tolist() if first <= n < len(self.times)
        ]
        grown = growing_maps(
            relative_poses(corner, self.poses),
            self.lidar.angles,
            self.ranges,
            counts,
            resolution=resolution,
            max_range_m=self.lidar.max_range_m,
            hit=self.spec.hit,
            miss=self.spec.miss,
            least_evidence=self.least_evidence,
        )
        for count, grid in zip(counts, grown, strict=True):
            x, y, yaw = compose_poses(corner, np.array(grid.origin)).tolist()
            yield count - 1, OccupancyGrid(grid.occupancy, resolution, (x, y, yaw))
        yield len(self.times) - 1, self.grid


def record(pair: MapPair, made: PairInputs) -> tuple[Recording, Recording]:
    """Make the recordings of both robots of a pair.

    Parameters
    ----------
    pair
        A pair made from a mission, with `poses`.
    made
        What it was made from.
    """
    of_a, of_b = np.random.SeedSequence(pair.info["seed"]).spawn(2)  # as `scenarios.pairs.pair` spawns them
    return _record(pair, made, "a", of_a), _record(pair, made, "b", of_b)


def _record(pair: MapPair, made: PairInputs, name: str, seed: np.random.SeedSequence) -> Recording:
    log, lidar, spec = getattr(made.log, name), getattr(made.log.spec, name).lidar, getattr(made, f"spec_{name}")
    grid: OccupancyGrid = getattr(pair, name)
    assert pair.poses is not None
    ranges, wheels, least_evidence = recorded_data(log, lidar, spec, noise=pair.info["noise"], seed=seed)
    in_world = np.array(pair.info[f"origin_{name}"])  # where the map's corner lies, and how its rows run
    return Recording(
        lidar=lidar,
        spec=spec,
        least_evidence=least_evidence,
        times=log.times,
        ranges=ranges,
        wheels=relative_poses(wheels[0], wheels),
        poses=compose_poses(np.array(grid.origin), relative_poses(in_world, pair.poses["ab".index(name)])),
        grid=OccupancyGrid(grid.occupancy, pair.info[f"resolution_{name}"], grid.origin),
    )
