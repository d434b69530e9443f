"""A planar laser scanner: where its beams point, and how its readings differ from the true ranges."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError


@dataclass(frozen=True, slots=True, kw_only=True)
class Lidar:
    """A scanner; the defaults are those of the RPLidar class.

    Parameters
    ----------
    beams
        Beams per scan, spread evenly over the field of view.
    fov_deg
        Field of view about the heading, degrees.
    min_range_m, max_range_m
        Readings outside are not reported.
    sigma_m, sigma_per_m
        Standard deviation of a range r: ``sigma_m + sigma_per_m * r``.
    dropout
        Probability that a beam returns nothing.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    beams: int = 360
    fov_deg: float = 360.0
    min_range_m: float = 0.12
    max_range_m: float = 12.0
    sigma_m: float = 0.01
    sigma_per_m: float = 0.005
    dropout: float = 0.01

    def __post_init__(self) -> None:
        if not 1 <= self.beams <= 3600:
            raise InputError(f"beams must be 1 to 3600, got {self.beams}")
        if not 0 < self.fov_deg <= 360:
            raise InputError(f"fov_deg must be > 0 and <= 360, got {self.fov_deg}")
        if not 0 <= self.min_range_m < self.max_range_m <= 100:
            raise InputError(f"ranges must satisfy 0 <= min < max <= 100, got {self.min_range_m}, {self.max_range_m}")
        if not (0 <= self.sigma_m <= 1 and 0 <= self.sigma_per_m <= 1 and 0 <= self.dropout <= 1):
            raise InputError("sigma_m, sigma_per_m and dropout must lie in 0..1")

    @property
    def angles(self) -> NDArray[np.float64]:
        """Directions of the beams from the heading, shape (beams,), radians counter-clockwise."""
        fov = math.radians(self.fov_deg)
        middles = np.arange(self.beams, dtype=np.float64) + 0.5
        return middles * (fov / self.beams) - fov / 2

    def limit(self, ranges: NDArray[np.float64]) -> NDArray[np.float64]:
        """Report ranges as the scanner would without noise.

        Parameters
        ----------
        ranges
            True ranges, any shape, metres; inf where there is nothing.

        Returns
        -------
        NDArray
            The same shape: inf beyond the longest range, nan (no reading) below the shortest.
        """
        far = np.where(ranges > self.max_range_m, np.inf, ranges)
        return np.where(far < self.min_range_m, np.nan, far)

    def observe(
        self, ranges: NDArray[np.float64], rng: np.random.Generator, *, level: float = 1.0
    ) -> NDArray[np.float64]:
        """Report ranges with noise and dropouts.

        Parameters
        ----------
        ranges
            True ranges, any shape, metres; inf where there is nothing.
        rng
            Of the noise.
        level
            Multiplies the standard deviation and the dropout probability; 0 is an exact scanner.

        Returns
        -------
        NDArray
            The same shape: inf where nothing is in reach, nan where the beam was lost.
        """
        sigma = self.sigma_m + self.sigma_per_m * np.where(np.isfinite(ranges), ranges, 0.0)
        noisy = ranges + level * sigma * rng.standard_normal(ranges.shape)
        lost = rng.random(ranges.shape) < level * self.dropout
        return np.where(lost, np.nan, self.limit(noisy))
