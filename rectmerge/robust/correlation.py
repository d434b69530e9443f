"""Correlation of the wall faces of two maps over every shift, turn by turn and scale by scale.

Where two maps share no whole room, no rectangle of one is one of the other; and a rival that explains the walls as well
as the best placement must not be missed because nothing proposed it. Both are found by trying every shift.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.analysis.distance_codes import ON_BORDER
from rectmerge.analysis.wall_faces import WallFaces
from rectmerge.robust.likelihood import WallNoise, face_gains
from rectmerge.robust.params import CorrelateParams, GainParams

QUARTER_TURNS = (np.eye(2), np.array([[0.0, -1.0], [1.0, 0.0]]), -np.eye(2), np.array([[0.0, 1.0], [-1.0, 0.0]]))
Image = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class _Raster:
    """Map in its orthogonal frame: walls and gains by normal, and the transform of its working cells.

    Parameters
    ----------
    walls, gains
        Shape (4, h, w): wall points counted, and the gain of a foreign wall point.
    linear, shift
        A working cell p is at ``linear @ p + shift``.
    """

    walls: Image
    gains: Image
    linear: NDArray[np.float64]
    shift: NDArray[np.float64]

    @classmethod
    def from_faces(cls, sides: WallFaces, scale: float, params: CorrelateParams, gain: GainParams) -> _Raster:
        """Turn a map upright and shrink it by a scale, correlated cells per working cell."""
        height, width = sides.free.shape
        cos, sin = math.cos(sides.angle), math.sin(sides.angle)
        linear = scale * np.array([[cos, sin], [-sin, cos]])
        size = np.ceil(np.abs(linear) @ [width, height]).astype(int) + 2
        shift = (size - 1) / 2 - linear @ [(width - 1) / 2, (height - 1) / 2]
        table = face_gains(sides, WallNoise((params.spread_cells / scale,), params.outliers), gain)
        walls = np.zeros((4, size[1], size[0]), np.float32)
        gains = np.empty_like(walls)
        # written out: a product of so slender matrices wakes threads that wait for each other on a busy machine
        x, y = sides.walls.T
        u, v = (np.rint(row[0] * x + row[1] * y + by).astype(np.intp) for row, by in zip(linear, shift, strict=True))
        at = v * size[0] + u  # (N,)
        for k in range(4):
            codes = cv2.warpAffine(
                sides.codes[k], np.column_stack([linear, shift]), size.tolist(),
                flags=cv2.INTER_NEAREST, borderValue=ON_BORDER,
            )  # fmt: skip
            gains[k] = cv2.LUT(codes, table[k])
            walls[k] = np.bincount(at[sides.faces[:, k]], minlength=walls[k].size).reshape(walls[k].shape)
        return cls(walls, gains, linear, shift)

    @property
    def size(self) -> tuple[int, int]:
        return self.walls.shape[2], self.walls.shape[1]


def scales_within(bounds: tuple[float, float], step: float) -> NDArray[np.float64]:
    """Return scales between bounds, evenly spaced in the logarithm by at most a step."""
    low, high = math.log(bounds[0]), math.log(bounds[1])
    return np.exp(np.linspace(low, high, math.ceil((high - low) / step) + 1))


def correlate(
    a: WallFaces, b: WallFaces, scales: Iterable[float], params: CorrelateParams, gain: GainParams, *, max_shifts: int
) -> tuple[NDArray[np.float64], Image]:
    """Find the best shifts of B on A for each scale and quarter turn.

    Parameters
    ----------
    a, b
        Both maps, in the frames that are laid on each other.
    scales
        Of the working grids, cells of A per cell of B.
    params, gain
        Parameters of the correlation, and of the gain of a wall point.
    max_shifts
        Shifts kept of each scale and quarter turn.

    Returns
    -------
    placements, gains
        Shape (N, 4) between the working grids, and (N,): the gain of all walls of each, those of both maps, nats. Of a
        scale, wall points count by the coarser map's cells.
    """
    base = max(params.cell_cells, math.hypot(*a.free.shape) / params.max_diagonal_cells)
    raster_of_a = functools.lru_cache(maxsize=1)(lambda cell: _Raster.from_faces(a, 1 / cell, params, gain))
    placements, gains = [], []
    for scale in scales:
        cell = base * max(1.0, scale)  # what the coarser map shows is enough
        on_a, on_b = raster_of_a(cell), _Raster.from_faces(b, scale / cell, params, gain)
        side = cv2.getOptimalDFTSize(max(on_a.size) + max(on_b.size))
        spectra_a = _spectra(on_a.gains, on_a.walls, side)
        spectra_b = _spectra(on_b.walls * min(1.0, scale), on_b.gains * min(1.0, 1 / scale), side)
        for quarter, turn in enumerate(QUARTER_TURNS):
            at, peak = _peaks(_correlated(spectra_a, spectra_b, quarter), max_shifts)
            placements.append(_placements(at, on_a, on_b, turn, side))
            gains.append(peak)
            spectra_b = [_turned(spectrum) for spectrum in spectra_b]
    return np.concatenate(placements), np.concatenate(gains)


def _spectra(real: Image, imaginary: Image, side: int) -> list[Image]:
    """Transform four pairs of images, each pair packed as one complex image of a square."""
    spectra = []
    for one, two in zip(real, imaginary, strict=True):
        packed = np.zeros((side, side, 2), np.float32)
        packed[: one.shape[0], : one.shape[1], 0] = one
        packed[: two.shape[0], : two.shape[1], 1] = two
        spectra.append(np.asarray(cv2.dft(packed), np.float32))
    return spectra


def _turned(spectrum: Image) -> Image:
    """Turn a square's spectrum as if its image had been turned by a quarter, from u towards v, about its first cell."""
    return np.asarray(cv2.transpose(np.concatenate([spectrum[:1], spectrum[:0:-1]])), np.float32)


def _correlated(spectra_a: list[Image], spectra_b: list[Image], quarter: int) -> Image:
    """Correlate all four ways at once: the real part sums A's gains at B's walls and B's gains at A's walls."""
    products = [
        cv2.mulSpectrums(spectra_a[(k + quarter) % 4], spectrum, 0, conjB=True) for k, spectrum in enumerate(spectra_b)
    ]
    total = products[0] + products[1] + products[2] + products[3]
    return np.ascontiguousarray(cv2.dft(total, flags=cv2.DFT_INVERSE | cv2.DFT_SCALE)[..., 0])


def _peaks(scores: Image, most: int) -> tuple[NDArray[np.float64], Image]:
    """Find the highest local maxima, (N, 2) as (u, v), and their values."""
    cells = np.flatnonzero(scores >= cv2.dilate(scores, np.ones((3, 3), np.uint8)))
    values = scores.ravel()[cells]
    if len(values) > most:
        high = values >= np.partition(values, -most)[-most]
        cells, values = cells[high], values[high]
    best = np.argsort(-values, kind="stable")[:most]
    v, u = np.divmod(cells[best], scores.shape[1])
    return np.stack([u, v], axis=1).astype(np.float64), values[best]


def _placements(
    at: NDArray[np.float64], on_a: _Raster, on_b: _Raster, turn: NDArray[np.float64], side: int
) -> NDArray[np.float64]:
    """Turn shifts between rasters, known modulo the side, into placements between the working grids."""
    corners = np.array([[x, y] for x in (0, on_b.size[0]) for y in (0, on_b.size[1])]) @ turn.T
    least = -corners.max(axis=0)
    at = (at - least) % side + least
    back = np.linalg.inv(on_a.linear)
    linear = back @ turn @ on_b.linear
    shifts = (at + turn @ on_b.shift - on_a.shift) @ back.T  # (N, 2)
    return np.column_stack([np.broadcast_to(linear[:, 0], shifts.shape), shifts])
