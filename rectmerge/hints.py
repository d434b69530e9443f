"""Hints about a placement, a guess to search near or a placement by hand to be judged, and methods that take them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from rectmerge.alignment import Alignment, Method
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True)
class Guess:
    """Approximate placement of map B on map A.

    Parameters
    ----------
    x, y, yaw
        Origin of B's map frame in A's, and B's yaw there: map units of A, and radians.
    """

    x: float
    y: float
    yaw: float

    def pixels(self, a: OccupancyGrid, b: OccupancyGrid, scale: float) -> Similarity:
        """Return the guess between pixels, for a scale in cells of A per cell of B."""
        in_map_units = scale * a.cell_size / b.cell_size
        return map_frame_to_pixels(Similarity(in_map_units, self.yaw, self.x, self.y), a, b)


@dataclass(frozen=True, slots=True)
class ByHand:
    """Placement by hand, to be judged like any other.

    Parameters
    ----------
    pixels
        From B's pixels to A's.
    """

    pixels: Similarity


Hint = Guess | ByHand


@runtime_checkable
class TakesHints(Method, Protocol):
    """Method that can take a hint about the placement: an optional capability."""

    def align_by(
        self,
        hint: Hint | None,
        a: OccupancyGrid,
        b: OccupancyGrid,
        *,
        scale: tuple[float, float],
        rng: np.random.Generator,
    ) -> Alignment:
        """Place B on A as `align` does, with a hint."""
