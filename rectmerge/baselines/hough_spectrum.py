"""Baseline `hough-spectrum`: rotations from the Hough spectra, translations from the X and Y spectra."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Alignment
from rectmerge.analysis.overlap import cells_of
from rectmerge.baselines.acceptance import CellComparison
from rectmerge.baselines.images import middle_scale
from rectmerge.baselines.ranked_answer import Placement, answer
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

MOST_POINTS = 20_000  # an evenly spaced choice of more occupied cells says the same
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class HoughSpectrum:
    """Align by spectra of the occupied cells: their Hough transforms for the turn, their profiles for the shift.

    Parameters
    ----------
    angle_step_deg
        Width of a bin of the Hough spectrum.
    turns
        Local maxima of the Hough spectra's correlation that are tried; each is a turn, and that turn plus half a turn.
    shifts
        Maxima of the X spectra's correlation, and of the Y spectra's, that are combined for each turn.
    scale_search
        False: the scale is the middle of its bounds, 1 where nothing is known, as the method is rigid. True: scales
        across the bounds are tried.
    scale_step
        Step between the scales that are tried, in ln s.
    rank_by
        The score: "acceptance", Carpin's acceptance index, or "walls", the share of shared walls.
    longest_cells
        Bins across the longest side of A; a bin is a cell where A is smaller.
    accept_at
        The least score, 0..1, that is accepted.

    Raises
    ------
    InputError
        If a parameter is out of its range.

    Notes
    -----
    S. Carpin, "Fast and accurate map merging for multi-robot systems", Autonomous Robots 25(3), 2008,
    DOI 10.1007/s10514-008-9097-4, from its outline: turns by the Hough spectra, shifts by the X and Y spectra, and
    hypotheses ranked by the acceptance index, agree / (agree + disagree). That both maps are turned until A's walls lie
    along the axes before the X and Y spectra are taken, the bin of one degree, the number of turns and the threshold
    are our choice.

    Extended for unknown scale: the Hough spectrum's peaks do not depend on it, so turns are found once; B's points are
    multiplied by each scale before the X and Y spectra are taken. A map shrunk into the other's free space disagrees
    with it little, which the acceptance index does not see; the share of shared walls does. Not compared with the
    author's program.
    """

    name: ClassVar[str] = "hough-spectrum"
    angle_step_deg: float = 1.0
    turns: int = 2
    shifts: int = 1
    scale_search: bool = False
    scale_step: float = 0.02
    rank_by: Literal["acceptance", "walls"] = "acceptance"
    longest_cells: int = 500
    accept_at: float = 0.9

    def __post_init__(self) -> None:
        for field in ("turns", "shifts", "longest_cells"):
            if getattr(self, field) < 1:
                raise InputError(f"{field} must be >= 1, got {getattr(self, field)}")
        for field in ("angle_step_deg", "scale_step", "accept_at"):
            if not getattr(self, field) > 0:
                raise InputError(f"{field} must be > 0, got {getattr(self, field)}")
        if self.rank_by not in ("acceptance", "walls"):
            raise InputError(f'rank_by must be "acceptance" or "walls", got {self.rank_by!r}')

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Place B on A; `scale` bounds the pixel scale (cells of A per cell of B)."""
        on_a, on_b = (cells_of(grid.occupied, MOST_POINTS)[:, ::-1].astype(np.float64) for grid in (a, b))
        placements: list[Placement] = []
        if len(on_a) and len(on_b):
            comparison = CellComparison(a, b)
            score = comparison.acceptance_index if self.rank_by == "acceptance" else comparison.shared_walls
            hypotheses = self._hypotheses(on_a, on_b, scale, bin_cells=max(1.0, max(a.shape) / self.longest_cells))
            placements = [Placement(pixels, score(pixels)) for pixels in hypotheses]
        return answer(
            self.name, a, b, placements, accept_at=self.accept_at, scale=scale, nothing="a map has no occupied cell"
        )

    def _hypotheses(
        self, a: Floats, b: Floats, scale: tuple[float, float], *, bin_cells: float
    ) -> Iterator[Similarity]:
        """Place B's points on A's, shape (N, 2) as (u, v), at each turn, scale and shift that fits the spectra."""
        angles = np.radians(np.arange(0, 180, self.angle_step_deg))
        spectrum_a = hough_spectrum(a / bin_cells, angles)
        spectrum_b = hough_spectrum(b * middle_scale(scale) / bin_cells, angles)
        upright = Similarity(1 / bin_cells, -float(angles[np.argmax(spectrum_a)]))
        on_a = upright.apply(a)
        turns = turns_between(spectrum_a, spectrum_b, self.turns)
        for turn, size in itertools.product(turns, self._scales(scale)):
            turned = upright @ Similarity(size, turn)
            on_b = turned.apply(b)
            shifts = [shifts_between(on_a[:, axis], on_b[:, axis], self.shifts) for axis in (0, 1)]
            for dx, dy in itertools.product(*shifts):
                yield upright.inverse() @ Similarity(1.0, 0.0, dx, dy) @ turned

    def _scales(self, scale: tuple[float, float]) -> list[float]:
        """List the scales to try: the middle of the bounds, and with a search those around it."""
        reach = math.log(scale[1] / scale[0]) / 2 if self.scale_search else 0.0
        steps = math.floor(reach / self.scale_step + 0.5)
        return [middle_scale(scale) * math.exp(k * self.scale_step) for k in range(-steps, steps + 1)]


def hough_spectrum(points: Floats, angles: Floats) -> Floats:
    """Return the energy of the Hough transform at each angle: the sum over the lines of their squared counts.

    Parameters
    ----------
    points
        Shape (N, 2), as (u, v) in bins.
    angles
        Shape (K,), of the lines' normals, from u towards v.
    """
    distances = np.rint(points @ np.stack([np.cos(angles), np.sin(angles)])).astype(np.intp)  # (N, K)
    distances -= distances.min(axis=0)
    return np.array([float((np.bincount(column) ** 2.0).sum()) for column in distances.T])


def turns_between(a: Floats, b: Floats, max_peaks: int) -> list[float]:
    """List the turns, in radians, at which spectrum B shifted cyclically fits spectrum A best, each with its half turn.

    Parameters
    ----------
    a, b
        Hough spectra over the angles from 0 to pi, shape (K,).
    max_peaks
        Local maxima of their circular cross-correlation that are taken.
    """
    fit = np.fft.irfft(np.fft.rfft(a) * np.conj(np.fft.rfft(b)), len(a))
    step = math.pi / len(a)
    return [half + step * at for at in _maxima(np.pad(fit, 1, mode="wrap"), max_peaks) for half in (0.0, math.pi)]


def shifts_between(a: Floats, b: Floats, max_peaks: int) -> list[float]:
    """List the shifts that take coordinates of B's points to A's, by the correlation of their spectra of unit bins."""
    counts, starts = [], []
    for coordinates in (a, b):
        bins = np.rint(coordinates).astype(np.intp)
        starts.append(int(bins.min()))
        counts.append(np.bincount(bins - bins.min()).astype(np.float64))
    fit = np.correlate(counts[0], counts[1], mode="full")
    nearest = starts[0] - starts[1] - len(counts[1]) + 1
    return [float(nearest + at) for at in _maxima(np.pad(fit, 1), max_peaks)]


def _maxima(padded: Floats, max_peaks: int) -> list[int]:
    """List the highest local maxima of values padded by one at either end, best first."""
    values = padded[1:-1]
    peaks = np.flatnonzero((values >= padded[:-2]) & (values > padded[2:]))
    return [int(at) for at in peaks[np.argsort(-values[peaks], kind="stable")[:max_peaks]]]
