"""Correlation of the wall faces of two maps over every shift, turn by turn and scale by scale.

Where two maps share no whole room, no rectangle of one is one of the other; and a rival that explains the walls as well
as the best placement must not be missed because nothing proposed it. Both are found by trying every shift.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.correlating import highest_peaks, sum_products
from rectmerge.analysis.distance_codes import ON_BORDER
from rectmerge.analysis.wall_faces import WallFaces
from rectmerge.robust.correlation_params import CorrelateParams
from rectmerge.robust.likelihood import WallNoise, face_gains
from rectmerge.robust.params import GainParams

QUARTER_TURNS = np.array([[[c, -s], [s, c]] for c, s in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))])
Image = NDArray[np.float32]
Spectra = NDArray[np.complex64]


@dataclass(frozen=True, eq=False)
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
    def from_faces(cls, sides: WallFaces, scale: float, table: Image) -> _Raster:
        """Turn a map upright and shrink it by a scale, correlated cells per working cell; `table` has its gains."""
        height, width = sides.free.shape
        cos, sin = math.cos(sides.angle), math.sin(sides.angle)
        linear = scale * np.array([[cos, sin], [-sin, cos]])
        size = np.ceil(np.abs(linear) @ [width, height]).astype(int) + 2
        shift = (size - 1) / 2 - linear @ [(width - 1) / 2, (height - 1) / 2]
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

    @functools.cached_property
    def back(self) -> NDArray[np.float64]:
        """Takes what `linear` gives back to working cells."""
        return np.asarray(np.linalg.inv(self.linear), np.float64)

    @property
    def size(self) -> tuple[int, int]:
        return self.walls.shape[2], self.walls.shape[1]


def scales_within(bounds: tuple[float, float], step: float) -> NDArray[np.float64]:
    """Return scales between bounds, evenly spaced in the logarithm by at most a step."""
    low, high = math.log(bounds[0]), math.log(bounds[1])
    return np.exp(np.linspace(low, high, math.ceil((high - low) / step) + 1))


def correlate(
    a: WallFaces,
    frames_b: Sequence[WallFaces],
    scales: Iterable[float],
    params: CorrelateParams,
    gain: GainParams,
    *,
    max_shifts: int,
) -> tuple[NDArray[np.float64], Image]:
    """Find the best shifts of B on A for each scale, frame of B and quarter turn.

    Parameters
    ----------
    a
        The map that stays, in the frame that others are laid on.
    frames_b
        The other map, in each of its frames that is laid on A's.
    scales
        Of the working grids, cells of A per cell of B.
    params, gain
        Parameters of the correlation, and of the gain of a wall point.
    max_shifts
        Shifts kept of each scale, frame and quarter turn.

    Returns
    -------
    placements, gains
        Shape (N, 4) between the working grids, and (N,): the gain of all walls of each, those of both maps, nats. Of a
        scale, wall points count by the coarser map's cells.
    """
    base = max(params.cell_cells, math.hypot(*a.free.shape) / params.max_diagonal_cells)

    @functools.lru_cache(maxsize=1)
    def drawn_a(cell: float) -> _Raster:
        return _Raster.from_faces(a, 1 / cell, face_gains(a, _noise(cell, params), gain))

    @functools.lru_cache(maxsize=1)
    def spectra_of_a(cell: float, side: int) -> Spectra:
        return _spectra(drawn_a(cell).gains, drawn_a(cell).walls, side)

    placements: list[NDArray[np.float64]] = []
    gains: list[Image] = []
    for scale in scales:
        cell = base * max(1.0, scale)  # what the coarser map shows is enough
        noise = _noise(cell / scale, params)
        counted = {id(b.counts): b for b in frames_b}  # frames of eight ways share the counts of two
        tables = {key: face_gains(b, noise, gain) for key, b in counted.items()}
        frames = [_Raster.from_faces(b, scale / cell, tables[id(b.counts)]) for b in frames_b]
        side = cv2.getOptimalDFTSize(max(drawn_a(cell).size) + max(max(on_b.size) for on_b in frames))
        spectra_a = spectra_of_a(cell, side)
        for on_b in frames:
            spectra_b = _spectra(on_b.walls * min(1.0, scale), on_b.gains * min(1.0, 1 / scale), side)
            peaks = [_peaks(turned, max_shifts) for turned in _correlated(spectra_a, spectra_b)]
            placements.append(_placements([at for at, _ in peaks], drawn_a(cell), on_b, side))
            gains += [peak for _, peak in peaks]
    return np.concatenate(placements), np.concatenate(gains)


def _noise(cell: float, params: CorrelateParams) -> WallNoise:
    """Return the noise of the walls on a grid whose correlated cells have a width, in working cells."""
    return WallNoise((params.spread_cells * cell,), params.outliers)


def _spectra(real: Image, imaginary: Image, side: int) -> Spectra:
    """Transform four pairs of images, each pair packed as one complex image of a square, shape (4, side, side)."""
    spectra = np.zeros((len(real), side, side, 2), np.float32)
    rows = max(real.shape[1], imaginary.shape[1])
    for k, (one, two) in enumerate(zip(real, imaginary, strict=True)):
        spectra[k, : one.shape[0], : one.shape[1], 0] = one
        spectra[k, : two.shape[0], : two.shape[1], 1] = two
        spectra[k] = cv2.dft(spectra[k], nonzeroRows=rows)
    return spectra.view(np.complex64)[..., 0]


def _correlated(spectra_a: Spectra, spectra_b: Spectra) -> Iterator[Image]:
    """Correlate all four normals at once, A's gains at B's walls and B's at A's, for each quarter turn of B.

    Turning an image by a quarter, from u towards v about its first cell, turns its spectrum alike.
    """
    across = np.ascontiguousarray(spectra_b.transpose(0, 2, 1))
    total = np.empty(spectra_a.shape[1:], np.complex64)
    turned = (spectra_b, False, False), (across, False, True), (spectra_b, True, True), (across, True, False)
    for quarter, (spectra, turns_rows, turns_cols) in enumerate(turned):
        sum_products(spectra_a, spectra, quarter, turns_rows, turns_cols, total)
        image = cv2.dft(total.view(np.float32).reshape(*total.shape, 2), flags=cv2.DFT_INVERSE | cv2.DFT_SCALE)
        yield np.asarray(image[..., 0], np.float32)


def _peaks(scores: Image, most: int) -> tuple[NDArray[np.float64], Image]:
    """Find the highest local maxima, (N, 2) as (u, v), and their values."""
    cells, values = np.empty(most, np.int64), np.empty(most, np.float32)
    count = highest_peaks(scores, cells, values)
    v, u = np.divmod(cells[:count], scores.shape[1])
    return np.stack([u, v], axis=1).astype(np.float64), values[:count]


def _placements(shifts: Sequence[NDArray[np.float64]], on_a: _Raster, on_b: _Raster, side: int) -> NDArray[np.float64]:
    """Turn shifts between rasters for each quarter turn, known modulo the side, into placements of working grids."""
    turns = np.repeat(QUARTER_TURNS, [len(at) for at in shifts], axis=0)  # (N, 2, 2)
    least = -np.maximum(0.0, turns @ np.array(on_b.size))  # B's corners are at no more
    at = (np.concatenate(shifts) - least) % side + least
    placements = np.empty((len(at), 4))
    placements[:, :2] = (on_a.back @ turns @ on_b.linear)[:, :, 0]
    placements[:, 2:] = (at + turns @ on_b.shift - on_a.shift) @ on_a.back.T
    return placements
