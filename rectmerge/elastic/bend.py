"""Bend of map B onto map A: the answer of the elastic alignment, with its evidence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.elastic.lattice import Displacement
from rectmerge.elastic.uncertainty import jackknife_std
from rectmerge.elastic.warp import Warp
from rectmerge.grid import OccupancyGrid, pixels_to_map_frame
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BendEvidence:
    """Measurements behind the decision on a displacement; None where the search ended before them.

    Parameters
    ----------
    held_back_cost
        Cost of walls that the displacement was not fitted to, after over before.
    gain_t
        Mean of their gains by square of a chequerboard, over its standard error.
    walls_before, walls_after
        Distance across the wall, in cells of A, within which three in four walls lie that both maps show.
    largest_move
        Greatest displacement of B's walls, in cells of A.
    stretch
        Least and greatest stretch of the displacement, 1 being none.
    """

    held_back_cost: float | None = None
    gain_t: float | None = None
    walls_before: float | None = None
    walls_after: float | None = None
    largest_move: float | None = None
    stretch: tuple[float, float] | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "held_back_cost": self.held_back_cost,
            "t": self.gain_t,
            "walls_before": self.walls_before,
            "walls_after": self.walls_after,
            "largest_move": self.largest_move,
            "stretch": None if self.stretch is None else list(self.stretch),
        }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bend:
    """Transform from map B to map A that bends; truthy only where the walls confirm it.

    Where it is refused, it is the similarity alone.

    Parameters
    ----------
    accepted
        Whether walls that it was not fitted to meet better with it.
    reason
        One line a user can act on.
    a, b
        The two maps, for their frames.
    pixels
        The similarity from B's pixels to A's, before the displacement.
    warp
        From B's pixels to A's; None where it is refused.
    left_out
        Displacements fitted without a quarter of the walls each, for the standard deviation.
    evidence
        Measurements.
    seconds
        Wall time.
    """

    accepted: bool
    reason: str
    a: OccupancyGrid
    b: OccupancyGrid
    pixels: Similarity
    warp: Warp | None = None
    left_out: tuple[Displacement, ...] = ()
    evidence: BendEvidence = field(default_factory=BendEvidence)
    seconds: float = 0.0

    def __bool__(self) -> bool:
        return self.accepted

    @property
    def b_to_a(self) -> Similarity:
        """The similarity between the map frames, before the displacement."""
        return pixels_to_map_frame(self.pixels, self.a, self.b)

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """Take points of B's map frame, (..., 2), to A's."""
        if self.warp is None:
            return self.b_to_a.apply(points)
        return self.a.pixel_to_map(self.warp.apply(self.b.map_to_pixel(points)))

    def inverse(self) -> InverseBend:
        """Return the transform from A's map frame to B's."""
        return InverseBend(self)

    def jacobian(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the derivative of `apply` at points of B's map frame, (..., 2, 2)."""
        if self.warp is None:
            linear = self.b_to_a.matrix[:, :2]
            return np.broadcast_to(linear, (*np.shape(points)[:-1], 2, 2)).copy()
        of_a = (self.a.pixel_to_map(np.eye(2)) - self.a.pixel_to_map([0.0, 0.0])).T
        of_b = (self.b.map_to_pixel(np.eye(2)) - self.b.map_to_pixel([0.0, 0.0])).T
        jacobian: NDArray[np.float64] = of_a @ self.warp.jacobian(self.b.map_to_pixel(points)) @ of_b
        return jacobian

    def local_angle(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the turn from B's map frame to A's at points of B's, (...): radians, counter-clockwise."""
        j = self.jacobian(points)
        angle: NDArray[np.float64] = np.arctan2(j[..., 1, 0] - j[..., 0, 1], j[..., 0, 0] + j[..., 1, 1])
        return angle

    def similarity_at(self, point: ArrayLike) -> Similarity:
        """Return the similarity that is right near one point of B's map frame, (2,): its place, turn and scale."""
        scale = float(np.sqrt(np.linalg.det(self.jacobian(point))))
        turned = Similarity(scale, float(self.local_angle(point)))
        tx, ty = self.apply(point) - turned.apply(point)
        return Similarity(scale, turned.angle, float(tx), float(ty))

    def std(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the standard deviation of the displaced points of B's map frame, (...), in A's map units.

        By a jackknife over quarters of the walls; it orders errors, and tells little of their size. NaN where the
        bend is refused.
        """
        if not self.left_out:
            return np.full(np.shape(points)[:-1], np.nan)
        return jackknife_std(self.left_out, self.pixels.apply(self.b.map_to_pixel(points))) * self.a.cell_size

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether points of B's map frame, (..., 2), lie where the displacement was fitted, within its lattice.

        False everywhere where the bend is refused.
        """
        if self.warp is None:
            return np.zeros(np.shape(points)[:-1], np.bool_)
        return self.warp.contains(self.b.map_to_pixel(points))

    def as_dict(self) -> Mapping[str, Any]:
        """Return plain data for JSON: `unbent` in ``alignment.json``."""
        return {"accepted": self.accepted, "reason": self.reason, **self.evidence.as_dict()}


@dataclass(frozen=True, slots=True, eq=False)
class InverseBend:
    """Transform from map A to map B.

    Parameters
    ----------
    bend
        The transform from B to A.
    """

    bend: Bend

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """Take points of A's map frame, (..., 2), to B's."""
        bend = self.bend
        if bend.warp is None:
            return bend.b_to_a.inverse().apply(points)
        return bend.b.pixel_to_map(bend.warp.undo(bend.a.map_to_pixel(points)))
