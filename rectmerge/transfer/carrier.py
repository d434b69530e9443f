"""Placement of map B as files of points need it: places, headings and standard deviations, bent or not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge.elastic.transform import BentTransform
from rectmerge.errors import InputError
from rectmerge.similarity import Similarity

STD_NAME = "bend_std"  # of the column, or property of a Point, with the standard deviation
DECIMALS = 9


@dataclass(slots=True, eq=False)
class Carrier:
    """Transform that carries places and headings of map B to A's map frame, and counts what lies outside its bend.

    Parameters
    ----------
    b_to_a
        The placement; it may bend.
    outside
        Number of places so far for which the bend was not fitted: they lie beyond its lattice.
    """

    b_to_a: Similarity | BentTransform
    outside: int = 0

    @property
    def is_bent(self) -> bool:
        """Whether the placement bends, so that places have a standard deviation."""
        return isinstance(self.b_to_a, BentTransform)

    def carry(self, points: ArrayLike) -> NDArray[np.float64]:
        """Carry points, shape (N, 2), to A's map frame.

        Raises
        ------
        InputError
            If a result is not finite.
        """
        places = np.asarray(points, np.float64).reshape(-1, 2)
        with np.errstate(over="ignore", invalid="ignore"):
            carried = self.b_to_a.apply(places).round(DECIMALS)
        if not np.isfinite(carried).all():
            raise InputError("a coordinate is not a finite number, or too large to be carried")
        if isinstance(self.b_to_a, BentTransform):
            self.outside += int(np.count_nonzero(~self.b_to_a.contains(places)))
        return carried

    def turn_at(self, place: Sequence[float]) -> float:
        """Return the turn at a place of B, (2,), radians counter-clockwise."""
        if isinstance(self.b_to_a, BentTransform):
            return float(self.b_to_a.local_angle(place))
        return self.b_to_a.angle

    def std_at(self, place: Sequence[float]) -> float | None:
        """Return the standard deviation at a place of B, (2,), in A's map units; None outside the bend, or without."""
        if not isinstance(self.b_to_a, BentTransform) or not self.b_to_a.contains(place):
            return None
        return round(float(self.b_to_a.std(place)), DECIMALS)
