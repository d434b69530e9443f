"""Motions of points between the pixels of two images, and maps with the motion of their points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

Points = NDArray[np.float64]
UNDO_STEPS = 20  # each leaves at most a fifth of the error


class Motion(Protocol):
    """Motion from the pixels of one image to those of another; a `Similarity` is one."""

    def apply(self, points: ArrayLike) -> Points:
        """Move points, shape (..., 2)."""


@dataclass(frozen=True, slots=True, eq=False)
class CorruptedMap:
    """Corrupted map and the motion of its points.

    Parameters
    ----------
    grid
        The corrupted map. Its map frame is that of the original map, unless the image was turned.
    motions
        Motions of the points, in order.
    """

    grid: OccupancyGrid
    motions: tuple[Motion, ...] = ()

    def map_points(self, points: ArrayLike) -> Points:
        """Take pixels (u, v) of the old image, shape (..., 2), to pixels of the new one."""
        at = np.asarray(points, dtype=np.float64)
        for motion in self.motions:
            at = motion.apply(at)
        return at

    def then(self, later: CorruptedMap) -> CorruptedMap:
        """Append a corruption of this map."""
        return CorruptedMap(later.grid, self.motions + later.motions)


@dataclass(frozen=True, slots=True, eq=False)
class Waves:
    """Displacement by two crossing waves: a point p of the *new* image was at ``p + sideways sin(turns . p + phases)``.

    Parameters
    ----------
    turns
        Shape (2, 2), a row per wave: radians per pixel along u and v.
    phases
        Shape (2,), radians.
    sideways
        Shape (2, 2), a row per wave: its displacement in pixels, at right angles to its direction.
    """

    turns: Points
    phases: Points
    sideways: Points

    def undo(self, points: ArrayLike) -> Points:
        """Take pixels of the new image to those of the old one: the index map."""
        at = np.asarray(points, dtype=np.float64)
        return at + np.sin(at @ self.turns.T + self.phases) @ self.sideways

    def apply(self, points: ArrayLike) -> Points:
        """Take pixels of the old image to those of the new one, by a fixed point."""
        start = np.asarray(points, dtype=np.float64)
        at = start
        for _ in range(UNDO_STEPS):
            at = at - (self.undo(at) - start)
        return at


@dataclass(frozen=True, slots=True, eq=False)
class Kink:
    """Turn of everything beyond a line about a point on it, as when SLAM's heading slips once.

    Parameters
    ----------
    about
        The point, shape (2,), pixels.
    beyond
        Unit vector (2,) across the line: a point p turns where ``beyond . (p - about) > 0``.
    turn
        The turn.
    """

    about: Points
    beyond: Points
    turn: Similarity

    def is_beyond(self, points: Points) -> NDArray[np.bool_]:
        """Return whether points, shape (..., 2), of the old image turn."""
        turns: NDArray[np.bool_] = (points - self.about) @ self.beyond > 0
        return turns

    def apply(self, points: ArrayLike) -> Points:
        """Take pixels of the old image to those of the new one."""
        at = np.asarray(points, dtype=np.float64)
        return np.where(self.is_beyond(at)[..., None], self.turn.apply(at), at)


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Stretch along one direction, about a point.

    Parameters
    ----------
    about
        The point, shape (2,), pixels.
    matrix
        Shape (2, 2): takes old offsets from the point, as columns, to new ones.
    """

    about: Points
    matrix: Points

    def undo(self, points: ArrayLike) -> Points:
        """Take pixels of the new image to those of the old one: the index map."""
        at = np.asarray(points, dtype=np.float64)
        return self.about + (at - self.about) @ np.linalg.inv(self.matrix).T

    def apply(self, points: ArrayLike) -> Points:
        """Take pixels of the old image to those of the new one."""
        at = np.asarray(points, dtype=np.float64)
        return self.about + (at - self.about) @ self.matrix.T
