"""Bend of map B onto map A: the answer of the elastic alignment, with its evidence."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.analysis.double_walls import double_wall_share
from rectmerge.elastic.straightening import straighten
from rectmerge.elastic.transform import BentTransform, InverseTransform
from rectmerge.elastic.warp import Warp
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BendEvidence:
    """Measurements behind the decision on a displacement; None where the search ended before them.

    Parameters
    ----------
    held_back_cost
        Cost of walls that the displacement was not fitted to, after over before.
    gain_t
        Mean of their gains by square, over its standard error.
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
    pixels, b_to_a
        The similarity from B to A before the displacement, between pixels and between map frames.
    warp
        From B's pixels to A's; None where it is refused.
    transform
        The same between the map frames; None where it is refused.
    evidence
        Measurements.
    seconds
        Wall time.
    """

    accepted: bool
    reason: str
    pixels: Similarity
    b_to_a: Similarity
    warp: Warp | None = None
    transform: BentTransform | None = None
    evidence: BendEvidence = field(default_factory=BendEvidence)
    seconds: float = 0.0

    def __bool__(self) -> bool:
        return self.accepted

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """Take points of B's map frame, (..., 2), to A's."""
        return (self.transform or self.b_to_a).apply(points)

    def inverse(self) -> InverseTransform | Similarity:
        """Return the transform from A's map frame to B's, which has `apply`."""
        return (self.transform or self.b_to_a).inverse()

    def jacobian(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the derivative of `apply` at points of B's map frame, (..., 2, 2)."""
        if self.transform is None:
            return np.broadcast_to(self.b_to_a.matrix[:, :2], (*np.shape(points)[:-1], 2, 2)).copy()
        return self.transform.jacobian(points)

    def local_angle(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the turn from B's map frame to A's at points of B's, (...): radians, counter-clockwise."""
        if self.transform is None:
            return np.full(np.shape(points)[:-1], self.b_to_a.angle)
        return self.transform.local_angle(points)

    def similarity_at(self, point: ArrayLike) -> Similarity:
        """Return the similarity that is right near one point of B's map frame, (2,): its place, turn and scale."""
        return self.b_to_a if self.transform is None else self.transform.similarity_at(point)

    def std(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the standard deviation of the displaced points of B's map frame, (...), in A's map units.

        By a jackknife over quarters of the walls; it orders errors, and tells little of their size. NaN where the
        bend is refused.
        """
        return np.full(np.shape(points)[:-1], np.nan) if self.transform is None else self.transform.std(points)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether points of B's map frame, (..., 2), lie where the displacement was fitted, within its lattice.

        False everywhere where the bend is refused.
        """
        if self.transform is None:
            return np.zeros(np.shape(points)[:-1], np.bool_)
        return self.transform.contains(points)

    def straighten(self, b: OccupancyGrid) -> OccupancyGrid:
        """Redraw map B so that `b_to_a` alone lays it on A: the map to give to `compose` in its place.

        Where the bend is refused, it is B itself. See `rectmerge.elastic.straightening.straighten`.
        """
        return b if self.warp is None else straighten(b, self.warp)

    def double_walls(self, a: OccupancyGrid, b: OccupancyGrid) -> tuple[float | None, float | None]:
        """Measure the share of the common walls that the merged map shows twice, before B is bent and after.

        The maps are those that were given to `unbend`; see `rectmerge.analysis.double_walls.double_wall_share`.
        """
        before = double_wall_share(a, b, self.pixels)
        if self.warp is None:
            return before, before
        straight = self.straighten(b)
        return before, double_wall_share(a, straight, map_frame_to_pixels(self.b_to_a, a, straight))

    def as_dict(self) -> Mapping[str, Any]:
        """Return plain data for JSON: `unbent` in ``alignment.json``."""
        return {"accepted": self.accepted, "reason": self.reason, **self.evidence.as_dict()}
