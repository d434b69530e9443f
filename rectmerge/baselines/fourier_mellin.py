"""Baseline `fourier-mellin`: rotation and scale from the amplitude spectra, then translation, by phase correlation."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Alignment
from rectmerge.baselines.images import middle_scale, resize, working_factors
from rectmerge.baselines.ranked_answer import Placement, answer
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

SMALLEST_SIDE = 32  # fewer frequencies do not determine a turn
Image = NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True)
class FourierMellin:
    """Align by the Fourier-Mellin transform of one layer of the maps.

    Parameters
    ----------
    layer
        The layer that is registered: "occupied" or "free" cells, 1 for such a cell, else 0.
    side
        Side in cells of the square that either map is put on, and the number of angles and of radii of its spectrum.
    peaks
        Peaks of the spectra's correlation that are tried; each is a turn, and that turn plus half a turn.
    accept_at
        The least peak of the translation's phase correlation, 0..1, that is accepted.

    Raises
    ------
    InputError
        If a parameter is out of its range.

    Notes
    -----
    B. S. Reddy and B. N. Chatterji, "An FFT-based technique for translation, rotation, and scale-invariant image
    registration", IEEE Transactions on Image Processing 5(8), 1996, DOI 10.1109/83.506761. The method finds the scale
    itself: nothing was added but that only scales within the bounds are looked at. One peak and a spectrum as fine as
    the image are theirs; the threshold of rejection is our choice. For the translation the square is doubled, so that a
    shift is not mistaken for another one modulo its side. Not compared with the authors' program.
    """

    name: ClassVar[str] = "fourier-mellin"
    layer: Literal["occupied", "free"] = "occupied"
    side: int = 512
    peaks: int = 1
    accept_at: float = 0.05

    def __post_init__(self) -> None:
        if self.layer not in ("occupied", "free"):
            raise InputError(f'layer must be "occupied" or "free", got {self.layer!r}')
        if self.side < SMALLEST_SIDE:
            raise InputError(f"side must be >= {SMALLEST_SIDE}, got {self.side}")
        if self.peaks < 1:
            raise InputError(f"peaks must be >= 1, got {self.peaks}")
        if not self.accept_at > 0:
            raise InputError(f"accept_at must be > 0, got {self.accept_at}")

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Place B on A; `scale` bounds the pixel scale (cells of A per cell of B)."""
        layers = [(grid.occupied if self.layer == "occupied" else grid.free).astype(np.float32) for grid in (a, b)]
        placements: list[Placement] = []
        if all(layer.any() for layer in layers):
            factors, middle = working_factors(a, b, scale, self.side), middle_scale(scale)
            on_a, on_b = (resize(layer, factor) for layer, factor in zip(layers, factors, strict=True))
            bounds = scale[0] / middle, scale[1] / middle
            for turn in find_turns(on_a.image, on_b.image, bounds, self.side, self.peaks):
                pixels, score = find_shift(on_a.image, on_b.image, turn, self.side)
                placements.append(Placement(on_a.to_grid @ pixels @ on_b.to_grid.inverse(), score))
        return answer(
            self.name,
            a,
            b,
            placements,
            accept_at=self.accept_at,
            scale=scale,
            nothing=f"a map has no {self.layer} cell",
        )


def find_turns(a: Image, b: Image, scale: tuple[float, float], side: int, max_peaks: int) -> Iterator[Similarity]:
    """Find turns with scales that take image B's amplitude spectrum to A's, each also with half a turn added.

    Parameters
    ----------
    a, b
        Images, shape (h, w), no side longer than `side`.
    scale
        Bounds of the scale.
    side
        Side of the square that is transformed; the number of angles and of radii.
    max_peaks
        Peaks of the phase correlation that are taken.
    """
    angle_step, radius_step = math.pi / side, math.log(side / 2) / side
    surface = phase_correlation(_log_polar_spectrum(a, side), _log_polar_spectrum(b, side))
    shifts = np.rint(np.fft.fftfreq(side, 1 / side))
    log_scales = -shifts * radius_step
    slack = radius_step / 2
    is_within = (log_scales >= math.log(scale[0]) - slack) & (log_scales <= math.log(scale[1]) + slack)
    surface[:, ~is_within] = -np.inf
    for row, col in highest_maxima(surface, max_peaks):
        down, along = _between_bins(surface, row, col)
        turn = (row + down) * angle_step
        size = math.exp(float(log_scales[col]) - along * radius_step)
        yield Similarity(size, turn)
        yield Similarity(size, turn + math.pi)


def find_shift(a: Image, b: Image, turn: Similarity, side: int) -> tuple[Similarity, float]:
    """Find the translation for a turn with a scale, and the peak of its phase correlation, 0..1."""
    canvas = 2 * side
    middle = (np.array([b.shape[1], b.shape[0]]) - 1) / 2
    tx, ty = side - turn.apply(middle)
    centred = Similarity(turn.scale, turn.angle, float(tx), float(ty))
    turned = cv2.warpAffine(b, centred.matrix, (canvas, canvas), flags=cv2.INTER_LINEAR)
    surface = phase_correlation(_on_square(a, canvas), np.asarray(turned, np.float32))
    row, col = np.unravel_index(int(np.argmax(surface)), surface.shape)
    down, along = _between_bins(surface, int(row), int(col))
    # A lies in the first quarter of the canvas and B's middle in its centre: shifts go from -1.5 to 0.5 sides
    dv, du = (int(at) - canvas if at > side / 2 else int(at) for at in (row, col))
    return Similarity(1.0, 0.0, du + along, dv + down) @ centred, float(surface[row, col])


def phase_correlation(a: Image, b: Image) -> Image:
    """Correlate the phases of two images of one shape: the value at (row, col) scores B moved by that shift."""
    cross = np.fft.rfft2(a) * np.conj(np.fft.rfft2(b))
    magnitude = np.abs(cross)
    phases = np.divide(cross, magnitude, out=np.zeros_like(cross), where=magnitude > 1e-9 * magnitude.max())
    return np.asarray(np.fft.irfft2(phases, s=a.shape), np.float32)


def highest_maxima(surface: Image, max_peaks: int) -> list[tuple[int, int]]:
    """List the highest local maxima, as (row, col), best first."""
    is_peak = (surface >= cv2.dilate(surface, np.ones((5, 5), np.uint8))) & np.isfinite(surface)
    cells = np.flatnonzero(is_peak)
    best = cells[np.argsort(-surface.ravel()[cells], kind="stable")[:max_peaks]]
    return [(int(row), int(col)) for row, col in zip(*np.divmod(best, surface.shape[1]), strict=True)]


def _log_polar_spectrum(image: Image, side: int) -> Image:
    """Return the high-passed amplitude spectrum over half a turn of angles (rows) and log radii (columns)."""
    spectrum = np.fft.fftshift(np.abs(np.fft.fft2(_on_square(image, side))))
    frequency = np.cos(math.pi * np.fft.fftshift(np.fft.fftfreq(side)))
    crossed = np.outer(frequency, frequency)
    passed = (spectrum * (1 - crossed) * (2 - crossed)).astype(np.float32)
    angles = math.pi / side * np.arange(side)[:, None]
    radii = (side / 2) ** (np.arange(side) / side)
    u, v = (side // 2 + radii * along(angles) for along in (np.cos, np.sin))
    return np.asarray(cv2.remap(passed, u.astype(np.float32), v.astype(np.float32), cv2.INTER_LINEAR), np.float32)


def _on_square(image: Image, side: int) -> Image:
    square = np.zeros((side, side), np.float32)
    square[: image.shape[0], : image.shape[1]] = image
    return square


def _between_bins(surface: Image, row: int, col: int) -> tuple[float, float]:
    """Find the offset of a peak from its bin by a parabola along either axis, each -0.5..0.5."""
    offsets = []
    for line, at in ((surface[:, col], row), (surface[row], col)):
        before, peak, after = (float(line[(at + k) % len(line)]) for k in (-1, 0, 1))
        bend = before - 2 * peak + after
        usable = math.isfinite(bend) and bend < 0
        offsets.append(min(0.5, max(-0.5, (before - after) / (2 * bend))) if usable else 0.0)
    return offsets[0], offsets[1]
