"""Planar laser scanners: directions of their beams, errors of their readings, and profiles of products.

To add a scanner, add a line to `LIDARS`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from rectmerge.errors import InputError
from sim.world import SCAN_HEIGHT_M

JUMP_M = 0.3  # neighbouring ranges further apart than this lie on two surfaces
GLASS_DEG = 5.0  # a pane sends light back to the scanner about its normal only


@dataclass(frozen=True, slots=True, eq=False)
class RayHits:
    """True distances along the beams of one scan.

    Parameters
    ----------
    ranges
        Shape (B,), metres to the first wall, piece of furniture or other robot; inf where there is none.
    glass
        Shape (B,), metres to the first pane before that; inf where there is none.
    """

    ranges: NDArray[np.float64]
    glass: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Lidar:
    """Laser scanner; the defaults are those of the RPLidar class, without mixed pixels.

    Parameters
    ----------
    beams
        Beams per scan, spread evenly over the field of view.
    fov_deg
        Field of view about the heading, degrees; as wide as all beams together.
    rate_hz
        Scans per second.
    min_range_m, max_range_m
        Readings outside are not reported.
    sigma_m, sigma_per_m
        Standard deviation of a range r: ``sigma_m + sigma_per_m * r``.
    dropout
        Probability that a beam returns nothing.
    mixed_pixels
        Probability that a beam next to a jump of more than 0.3 m falls on both surfaces and reports a range between.
    glass_return
        Probability that a beam reports a pane that it meets within 5 degrees of its normal.
    height_m
        Height of the plane of the beams above the floor.

    Raises
    ------
    InputError
        If a value is out of range.
    """

    beams: int = 360
    fov_deg: float = 360.0
    rate_hz: float = 10.0
    min_range_m: float = 0.12
    max_range_m: float = 12.0
    sigma_m: float = 0.01
    sigma_per_m: float = 0.005
    dropout: float = 0.01
    mixed_pixels: float = 0.0
    glass_return: float = 0.8
    height_m: float = SCAN_HEIGHT_M

    def __post_init__(self) -> None:
        if not 1 <= self.beams <= 3600:
            raise InputError(f"beams must be 1 to 3600, got {self.beams}")
        if not 0 < self.fov_deg <= 360:
            raise InputError(f"fov_deg must be > 0 and <= 360, got {self.fov_deg}")
        if not 0 < self.rate_hz <= 100:
            raise InputError(f"rate_hz must be > 0 and <= 100, got {self.rate_hz}")
        if not 0 <= self.min_range_m < self.max_range_m <= 100:
            raise InputError(f"ranges must satisfy 0 <= min < max <= 100, got {self.min_range_m}, {self.max_range_m}")
        for name in ("sigma_m", "sigma_per_m", "dropout", "mixed_pixels", "glass_return"):
            if not 0 <= getattr(self, name) <= 1:
                raise InputError(f"{name} must lie in 0..1, got {getattr(self, name)}")
        if not 0.1 <= self.height_m <= 0.6:
            raise InputError(f"height_m must be 0.1 to 0.6, where robots see each other, got {self.height_m}")

    @property
    def angles(self) -> NDArray[np.float64]:
        """Directions of the beams from the heading, shape (beams,), radians counter-clockwise."""
        middles = np.arange(self.beams, dtype=np.float64) + 0.5
        return middles * self._step - math.radians(self.fov_deg) / 2

    @property
    def _step(self) -> float:
        return math.radians(self.fov_deg) / self.beams

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
        self,
        ranges: NDArray[np.float64],
        glass: NDArray[np.float64] | None,
        rng: np.random.Generator,
        *,
        level: float = 1.0,
    ) -> NDArray[np.float64]:
        """Report ranges with noise, dropouts, mixed pixels and returns from glass.

        Parameters
        ----------
        ranges, glass
            True distances to solid surfaces and to panes before them, shape (..., beams), metres, inf where there is
            none; None for a world without glass.
        rng
            Source of the noise.
        level
            Multiplies noise, dropouts and mixed pixels; 0 is an exact scanner, which sees through all glass.

        Returns
        -------
        NDArray
            The same shape: inf where nothing is in reach, nan where the beam was lost.

        Notes
        -----
        Glass sends a beam back where it is met squarely and lets it pass elsewhere (P. Foster et al., VisAGGE: Visible
        Angle Grid for Glass Environments, ICRA 2013): a pane shows as a short piece of wall that wanders with the
        robot. The angle comes from the distances of neighbouring beams on the pane; a lone beam counts as oblique.
        """
        normal = rng.standard_normal(ranges.shape)
        lost, mixes, share, returns = (rng.random(ranges.shape) for _ in range(4))
        if glass is not None and level > 0:
            is_returned = (self._incidence(glass) <= math.radians(GLASS_DEG)) & (returns < self.glass_return)
            ranges = np.where(is_returned, np.minimum(ranges, glass), ranges)
        other = np.where(mixes < level * self.mixed_pixels, self._across_a_jump(ranges), np.inf)
        seen = np.where(np.isfinite(other), (1.0 - share) * ranges + share * other, ranges)
        sigma = self.sigma_m + self.sigma_per_m * np.where(np.isfinite(seen), seen, 0.0)
        return np.where(lost < level * self.dropout, np.nan, self.limit(seen + level * sigma * normal))

    def _incidence(self, glass: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the angles between beams and the normal of their pane, radians; a right angle without a neighbour."""
        met = np.where(np.isfinite(glass), glass, 0.0)
        angle = np.full(glass.shape, np.pi / 2)
        for side in (-1, 1):
            neighbour = self._neighbours(met, side, 0.0)
            ahead = np.abs(neighbour * math.cos(self._step) - met)  # of the chord between both points on the pane
            angle = np.minimum(angle, np.arctan2(ahead, neighbour * math.sin(self._step)))
        return angle

    def _across_a_jump(self, ranges: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the range of the neighbour that differs most in range; inf where none is beyond a jump."""
        met = np.where(ranges <= self.max_range_m, ranges, np.nan)
        other, jump = np.full(ranges.shape, np.inf), np.full(ranges.shape, JUMP_M)
        for side in (-1, 1):
            neighbour = self._neighbours(met, side, np.nan)
            apart = np.abs(neighbour - met)
            other = np.where(apart > jump, neighbour, other)
            jump = np.fmax(apart, jump)
        return other

    def _neighbours(self, values: NDArray[np.float64], side: int, beyond: float) -> NDArray[np.float64]:
        """Return the values of the neighbours on one side; a scanner of 360 degrees has no last beam."""
        neighbours = np.roll(values, side, axis=-1)
        if self.fov_deg < 360:
            neighbours[..., 0 if side > 0 else -1] = beyond
        return neighbours


# Read in Slamtec, "RPLIDAR A1 Introduction and Datasheet" (A1M8) and "RPLIDAR A2 Introduction and Datasheet" (A2M8,
# rev. 2.5); Hokuyo, "Communication Protocol Specification for SCIP2.0" (steps, fields of view); SICK, "Measurement
# Errors LMSxxx". As commonly quoted, the originals not seen: both Hokuyos' reach and errors, the LMS111's reach and
# field of view, the A2's shortest range. A deviation is half of a bound on the error, or a repeatability whole;
# systematic errors are left out. Dropouts, mixed pixels, glass and the height at which a robot carries it are ours.
LIDARS: Mapping[str, Lidar] = MappingProxyType(
    {
        "rplidar-a1": Lidar(  # range resolution < 1 % of the distance; 1 degree at 5.5 Hz
            beams=360, fov_deg=360.0, rate_hz=5.5, min_range_m=0.15, max_range_m=12.0,
            sigma_m=0.01, sigma_per_m=0.005, dropout=0.02, mixed_pixels=0.3, glass_return=0.7, height_m=0.2,
        ),
        "rplidar-a2": Lidar(  # the same resolution; 8000 samples per second at 10 Hz
            beams=800, fov_deg=360.0, rate_hz=10.0, min_range_m=0.2, max_range_m=12.0,
            sigma_m=0.008, sigma_per_m=0.005, dropout=0.01, mixed_pixels=0.3, glass_return=0.7, height_m=0.25,
        ),
        "urg-04lx": Lidar(  # 10 mm to 1 m, 1 % of the distance beyond
            beams=682, fov_deg=239.77, rate_hz=10.0, min_range_m=0.06, max_range_m=4.095,
            sigma_m=0.003, sigma_per_m=0.004, dropout=0.01, mixed_pixels=0.4, glass_return=0.8, height_m=0.25,
        ),
        "utm-30lx": Lidar(  # repeatability 10 mm to 10 m, 30 mm to 30 m
            beams=1081, fov_deg=270.25, rate_hz=40.0, min_range_m=0.1, max_range_m=30.0,
            sigma_m=0.01, sigma_per_m=0.0006, dropout=0.005, mixed_pixels=0.2, glass_return=0.9, height_m=0.35,
        ),
        "lms1xx": Lidar(  # statistical error 12 mm; half a degree at 50 Hz
            beams=541, fov_deg=270.5, rate_hz=50.0, min_range_m=0.5, max_range_m=20.0,
            sigma_m=0.012, sigma_per_m=0.0, dropout=0.005, mixed_pixels=0.2, glass_return=0.9, height_m=0.3,
        ),
    }
)  # fmt: skip


def find_lidar(name: str) -> Lidar:
    """Return the scanner of a named profile.

    Raises
    ------
    InputError
        If there is no such profile; the message lists those there are.
    """
    if name not in LIDARS:
        raise InputError(f"no lidar {name!r}; there are: {', '.join(LIDARS)}")
    return LIDARS[name]
