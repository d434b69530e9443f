"""Known scale: what the resolutions of two maps say about the scale of a placement."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.robust.params import ScaleParams


@dataclass(frozen=True, slots=True)
class KnownScale:
    """Scale that the resolutions say, and what a placement's own scale adds to its log-odds.

    A search at one scale meets far fewer wrong placements than one at all scales, so what it finds is likelier right.

    Parameters
    ----------
    expected
        The known scale, between working grids.
    params
        Parameters of the scale.
    """

    expected: float
    params: ScaleParams

    @classmethod
    def within(cls, bounds: tuple[float, float], params: ScaleParams) -> KnownScale | None:
        """Return the scale in the middle of narrow bounds of a search; None where they are wide."""
        if math.log(bounds[1] / bounds[0]) > params.known_range:
            return None
        return cls(math.sqrt(bounds[0] * bounds[1]), params)

    def off(self, placements: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the logarithm of the scale of N placements, shape (N, 4), less that of the known one, shape (N,)."""
        off: NDArray[np.float64] = np.log(np.hypot(placements[:, 0], placements[:, 1]) / self.expected)
        return off

    def log_odds(self, off: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return what N differences of log scale add to the log-odds, shape (N,)."""
        odds: NDArray[np.float64] = scale_terms(off, self.params) @ np.array(self.params.weights)
        return odds


def scale_terms(off: NDArray[np.float64], params: ScaleParams) -> NDArray[np.float64]:
    """Return the terms of N differences of log scale, shape (N, 2): one, and the logarithm of a Cauchy distribution."""
    return np.stack([np.ones_like(off), np.log1p((off / params.spread) ** 2)], axis=1)


def scales_within(bounds: tuple[float, float], step: float) -> NDArray[np.float64]:
    """Return scales between bounds, evenly spaced in the logarithm by at most a step."""
    low, high = math.log(bounds[0]), math.log(bounds[1])
    return np.exp(np.linspace(low, high, math.ceil((high - low) / step - 1e-9) + 1))
