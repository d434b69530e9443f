"""Ray casting without the physics engine: compiled, in the plane of the scanner."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from sim._kernels import casting
from sim.sensors.lidar import RayHits
from sim.world import Prism, World

ROBOT_PARTS = ((0.05, 0.17, 0.17), (0.17, 0.65, 0.1))  # bottom, top and radius of body and mast, as in robot.urdf
BUCKET_M, MOST_BUCKETS = 0.4, 1_000_000


class Caster:
    """Ray caster over the section of a world at the height of a scanner.

    Parameters
    ----------
    world
        World of one visit: `World.at_visit`. Objects of single visits are refused.
    height_m
        Height of the scanner above the floor.

    Raises
    ------
    InputError
        If the world still holds objects of single visits.

    Notes
    -----
    Prisms that reach from below to above the plane, each with all its edges: rays that start inside one meet it from
    within, as in `Physics.cast`. Robots are upright; the engine's lean by half a degree when they drive.
    """

    def __init__(self, world: World, height_m: float) -> None:
        if any(world.visits):
            raise InputError("a caster needs the world of one visit, world.at_visit(0) or world.at_visit(1)")
        self._radius = max((r for bottom, top, r in ROBOT_PARTS if bottom <= height_m < top), default=0.0)
        self._solid = _Edges(world.walls + world.furniture, height_m)
        self._glass = _Edges(world.glass, height_m)

    def cast(
        self,
        pose: NDArray[np.float64],
        angles: NDArray[np.float64],
        max_range_m: float,
        others: NDArray[np.float64],
    ) -> RayHits:
        """Cast rays from a pose.

        Parameters
        ----------
        pose
            (x, y, yaw).
        angles
            Shape (N,), radians from the heading.
        max_range_m
            Length of the rays.
        others
            Poses of the other robots, shape (K, 3); those the pose lies inside are not met.

        Returns
        -------
        Reading
            As from `Physics.cast`.
        """
        heading = pose[2] + angles
        along = np.stack([np.cos(heading), np.sin(heading)], axis=-1)  # (N, 2)
        ranges = self._solid.meet(pose, along, np.full(len(angles), max_range_m))
        if len(others):
            casting.meet_circles(pose[0], pose[1], along, others[:, :2], self._radius, ranges)
            ranges[ranges >= max_range_m] = np.inf
        return RayHits(ranges, self._glass.meet(pose, along, np.minimum(ranges, max_range_m)))


class _Edges:
    """Edges of the outlines of prisms at a height, sorted into square buckets."""

    def __init__(self, prisms: Sequence[Prism], height_m: float) -> None:
        cut = [p.outline for p in prisms if p.bottom <= height_m < p.top]
        self._is_empty = not cut
        if self._is_empty:
            return
        starts = np.concatenate(cut)
        extents = np.concatenate([np.roll(outline, -1, axis=0) - outline for outline in cut])
        self._low = starts.min(axis=0)
        width, height = starts.max(axis=0) - self._low
        self._bucket = max(BUCKET_M, math.sqrt(width * height / MOST_BUCKETS))
        self._cols, self._rows = (math.floor(side / self._bucket) + 1 for side in (width, height))
        edges = np.concatenate([starts - self._low, extents], axis=1) / self._bucket  # (M, 4)
        self._first, self._held = casting.fill_buckets(edges, self._rows, self._cols)

    def meet(
        self, pose: NDArray[np.float64], along: NDArray[np.float64], reach: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the distances of rays to the nearest edge, metres; inf where there is none within reach."""
        if self._is_empty:
            return np.full(len(along), np.inf)
        x, y = (pose[:2] - self._low) / self._bucket
        ends = reach / self._bucket
        return casting.cast(x, y, along, ends, self._first, self._held, self._rows, self._cols) * self._bucket
