"""Sample of a map: enough of it to compare placements and to measure overlaps, many thousand times."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge.fleet.complex_similarity import ComplexSimilarity, Points, to_complex
from rectmerge.grid import OccupancyGrid

SAMPLED_CELLS = 400  # free cells, evenly spaced: an overlap is exact to about 2 %
AROUND = np.array([1, 1j, -1, -1j], np.complex128)


@dataclass(frozen=True, slots=True, eq=False)
class MapSample:
    """Free cells of a map, its size, and four landmarks.

    Parameters
    ----------
    free
        Mask of free cells, shape (H, W).
    points
        Pixels of some free cells, shape (N,).
    area
        Number of free cells.
    diagonal
        Of the bounding box of the known cells, in cells.
    centre, radius
        Mean of the free cells, and their root mean square distance from it, in cells.
    digest
        Fingerprint of cells, resolution and origin.
    """

    free: NDArray[np.bool_]
    points: Points
    area: float
    diagonal: float
    centre: complex
    radius: float
    digest: str

    @classmethod
    def from_grid(cls, grid: OccupancyGrid) -> MapSample:
        """Sample a map that has free cells."""
        rows, cols = (np.flatnonzero((~grid.unknown).any(axis=axis)) for axis in (1, 0))
        cells = np.flatnonzero(grid.free)
        even = np.linspace(0, len(cells) - 1, min(SAMPLED_CELLS, len(cells))).astype(np.intp)
        points = to_complex(np.stack(np.divmod(cells[even], grid.shape[1])[::-1], axis=1))
        return cls(
            free=grid.free,
            points=points,
            area=float(len(cells)),
            diagonal=float(np.hypot(np.ptp(rows) + 1, np.ptp(cols) + 1)),
            centre=complex(points.mean()),
            radius=max(1.0, float(np.sqrt(np.mean(np.abs(points - points.mean()) ** 2)))),
            digest=digest(grid),
        )

    @property
    def landmarks(self) -> Points:
        """Four points around the free space at its radius, shape (4,): where placements are compared."""
        landmarks: Points = self.centre + self.radius * AROUND
        return landmarks


def digest(grid: OccupancyGrid) -> str:
    """Return a fingerprint of a map's cells, resolution and origin."""
    facts = f"{grid.shape} {grid.resolution} {grid.origin}".encode()
    return hashlib.sha256(facts + grid.occupancy.tobytes()).hexdigest()


def overlap(a: MapSample, b: MapSample, placement: ComplexSimilarity) -> tuple[float, NDArray[np.bool_]]:
    """Measure the overlap of B placed on A, on B's sampled cells.

    Returns
    -------
    overlap
        Common free area over the smaller free area, 0..1.
    is_common
        Shape (N,): which of B's points are free in A.
    """
    at = placement.apply(b.points)
    u, v = np.rint(at.real).astype(np.intp), np.rint(at.imag).astype(np.intp)
    height, width = a.free.shape
    is_common = (u >= 0) & (v >= 0) & (u < width) & (v < height)
    is_common[is_common] = a.free[v[is_common], u[is_common]]
    area_b = b.area * placement.scale**2
    return min(1.0, float(is_common.mean()) * area_b / min(a.area, area_b)), is_common
