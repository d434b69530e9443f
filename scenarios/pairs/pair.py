"""Pairs of maps with their truth, made from mission logs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.corruption import NoiseLevel
from scenarios.pairs.map_view import MapSpec, PlacedMap, place_map
from scenarios.pairs.truth import control_point_rmse, control_points, is_bent, known_extent
from sim.missions.mission_log import MissionLog


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MapPair:
    """Two maps and the truth of their relation.

    Parameters
    ----------
    pair_id
        Unique in its suite or data set.
    a, b
        The maps as a method sees them: a hidden resolution is None.
    related
        Whether the maps show the same place at all.
    pixels
        The true pixel similarity from B to A: the least-squares fit to the control points. None when unrelated.
    control_points
        Shape (N, 4), rows (ua, va, ub, vb): the same surface points in the pixels of both maps. None when unrelated.
    residual_px
        RMSE of `pixels` on the control points, in A's pixels. None when unrelated.
    suite, place
        Suite and place of the pair; `place` is the cluster for statistics.
    overlap
        The true overlap as in DESIGN's scoring; None when unrelated.
    info
        All further columns of a row: family, variant, seed, noise, resolution_a, resolution_b, pose_source, ...
    poses
        Scanner poses that each map was built from, one per scan: (x, y, yaw), shape (S, 3) each. None without a
        mission.
    files
        Names of the maps' files in a data set, without suffix, where several pairs share a map; None names them after
        the pair.
    """

    pair_id: str
    a: OccupancyGrid
    b: OccupancyGrid
    related: bool
    pixels: Similarity | None
    control_points: NDArray[np.float64] | None
    residual_px: float | None
    suite: str
    place: str
    overlap: float | None = None
    info: Mapping[str, Any] = field(default_factory=dict)
    poses: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None
    files: tuple[str, str] | None = None


class PairSource(Protocol):
    """Source of pairs: a mission to run, or a row of a data set to read. Picklable; does no work before `pairs`."""

    @property
    def source_id(self) -> str:
        """Return a name for progress and for errors."""

    @property
    def pair_ids(self) -> tuple[str, ...]:
        """Return the ids of the pairs it yields, known before they are made."""

    def is_related(self, pair_id: str) -> bool:
        """Return whether a pair is meant to be related, which holds for failed pairs too."""

    def pairs(self) -> Iterator[MapPair]:
        """Make or read the pairs."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PairInputs:
    """Inputs of a pair: both robots' logs, cut as its maps are, and the settings of each map."""

    log: MissionLog
    spec_a: MapSpec
    spec_b: MapSpec


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MissionPairs:
    """Pairs of one mission, and the reasons of those that failed.

    Parameters
    ----------
    log
        The mission; `discarded` lists the failed tries.
    pairs
        The pairs.
    failed
        Reasons of the pairs that could not be made, by pair id.
    inputs
        Inputs by pair id; none for mirrored pairs, whose map B no robot can make.
    """

    log: MissionLog
    pairs: tuple[MapPair, ...]
    failed: Mapping[str, str]
    inputs: Mapping[str, PairInputs] = field(default_factory=dict)


def make_pair(
    log: MissionLog,
    spec_a: MapSpec,
    spec_b: MapSpec,
    seed: int,
    *,
    noise: NoiseLevel = 0,
    pair_id: str = "pair",
    suite: str = "",
    place: str = "",
) -> MapPair:
    """Make two maps from a mission, with their truth.

    Parameters
    ----------
    log
        The mission; it holds exact ranges, so one log serves every noise level.
    spec_a, spec_b
        Settings of each map.
    seed
        Seed of turns, grid phases, noise and the choice of control points. Turns and phases are the same at every noise
        level.
    noise
        Noise level, as `scenarios.corruption.noise_levels` defines them, of the scanner, the mapper and the cells.
    pair_id, suite, place
        As in `MapPair`; an empty place is named after the building.

    Returns
    -------
    MapPair
        Unrelated where the two maps show fewer than 20 common surface cells. `info` holds the true turns in degrees
        (counter-clockwise to the eye), `turn` settings, resolutions, origins in the world, noise, seeds, the robots'
        notes and the sources of their poses: `pose_source`, `ate_a_m` and `ate_b_m` (RMSE of the estimated
        positions, metres), and `bent`, whether no similarity fits the pair within 1.5 % of A's extent.
    """
    of_a, of_b, of_points = np.random.SeedSequence(seed).spawn(3)
    a = place_map(log.a, log.spec.a.lidar, spec_a, noise=noise, seed=of_a)
    b = place_map(log.b, log.spec.b.lidar, spec_b, noise=noise, seed=of_b)
    return pair_from_maps(
        a,
        b,
        control_points(log, a, b, np.random.default_rng(of_points)),
        pair_id=pair_id,
        suite=suite,
        place=place or f"{log.world.family}-{log.world.seed}",
        info=_info(log, {"a": spec_a, "b": spec_b}, {"a": a, "b": b}, seed, noise),
    )


def pair_from_maps(
    a: PlacedMap,
    b: PlacedMap,
    points: NDArray[np.float64] | None,
    *,
    pair_id: str,
    suite: str,
    place: str,
    info: Mapping[str, Any],
) -> MapPair:
    """Make a pair from two maps and their common surface points, (N, 4); without points it is unrelated.

    Computes the truth, its residual, the overlap and `bent`, and extends `info`.
    """
    pixels = residual = overlap = None
    if points is not None:
        pixels = Similarity.fit(points[:, 2:], points[:, :2])
        residual = control_point_rmse(pixels.matrix, points)
        overlap = measure_agreement(a.grid, b.grid, pixels).overlap
    return MapPair(
        pair_id=pair_id,
        a=a.grid,
        b=b.grid,
        related=points is not None,
        pixels=pixels,
        control_points=points,
        residual_px=residual,
        suite=suite,
        place=place,
        overlap=overlap,
        info={**info, "bent": residual is not None and is_bent(residual / known_extent(a.grid))},
        poses=(a.poses, b.poses),
    )


def make_unrelated_pair(
    log: MissionLog,
    spec_a: MapSpec,
    spec_b: MapSpec,
    seed: int,
    *,
    noise: NoiseLevel = 0,
    is_mirrored: bool = False,
    pair_id: str = "pair",
    suite: str = "",
    place: str = "",
) -> MapPair:
    """Make a pair that no similarity aligns.

    Parameters
    ----------
    log
        The mission, each robot in a building or part of it that the other did not visit; `log.world` is A's.
    spec_a, spec_b, seed, noise, pair_id, suite, place
        As in `make_pair`.
    is_mirrored
        Whether map B is flipped left to right; then the robots may share the place.
    """
    of_a, of_b = np.random.SeedSequence(seed).spawn(2)
    a = place_map(log.a, log.spec.a.lidar, spec_a, noise=noise, seed=of_a)
    b = place_map(log.b, log.spec.b.lidar, spec_b, noise=noise, seed=of_b)
    grid_b = OccupancyGrid(b.grid.occupancy[:, ::-1], b.grid.resolution, b.grid.origin) if is_mirrored else b.grid
    return MapPair(
        pair_id=pair_id,
        a=a.grid,
        b=grid_b,
        related=False,
        pixels=None,
        control_points=None,
        residual_px=None,
        suite=suite,
        place=place or f"{log.world.family}-{log.world.seed}",
        info={**_info(log, {"a": spec_a, "b": spec_b}, {"a": a, "b": b}, seed, noise), "bent": False},
        poses=(a.poses, b.poses),
    )


def _info(
    log: MissionLog, specs: Mapping[str, MapSpec], maps: Mapping[str, PlacedMap], seed: int, noise: NoiseLevel
) -> dict[str, Any]:
    info: dict[str, Any] = {
        "family": log.world.family,
        "world_seed": log.world.seed,
        "mission_seed": log.seed,
        "seed": seed,
        "noise": noise,
        "discarded": len(log.discarded),
        "pose_source": "/".join(dict.fromkeys(spec.poses for spec in specs.values())),
    }
    for name, robot in (("a", log.a), ("b", log.b)):
        info |= map_attributes(name, maps[name], specs[name])
        info[f"rooms_{name}"] = len(set(robot.rooms))
        info[f"note_{name}"] = robot.note
    return info


def map_attributes(name: str, placed: PlacedMap, spec: MapSpec) -> dict[str, Any]:
    """Return the columns of `info` that describe a map named "a" or "b"."""
    return {
        f"resolution_{name}": placed.resolution,
        f"origin_{name}": list(placed.origin),
        f"turn_{name}_deg": placed.turn_deg,
        f"turn_{name}": spec.turn,
        f"pose_source_{name}": spec.poses,
        f"ate_{name}_m": placed.ate_m,
    }
