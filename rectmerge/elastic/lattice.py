"""Lattice of cubic B-splines, and a displacement on it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rectmerge._kernels import spline_lattice

EXACT_CELLS = 1e-6  # of the inverse
MAX_INVERSE_STEPS = 50
SAMPLES_PER_SPACING = 4  # where a displacement is looked at for folds


@dataclass(frozen=True, slots=True)
class Lattice:
    """Nodes of uniform cubic B-splines over a box, in the pixels of A.

    Parameters
    ----------
    corner
        (x, y) where the box begins; the first node lies one spacing before it.
    spacing
        Between nodes, in cells of A.
    counts
        (nx, ny) nodes, at least 4 each.
    """

    corner: tuple[float, float]
    spacing: float
    counts: tuple[int, int]

    @classmethod
    def over(cls, low: NDArray[np.float64], high: NDArray[np.float64], spacing: float) -> Lattice:
        """Cover the box from `low` to `high`, (2,) each."""
        nx, ny = (max(1, math.ceil(extent / spacing)) + 3 for extent in (high - low).tolist())
        return cls((float(low[0]), float(low[1])), spacing, (nx, ny))

    @property
    def steps(self) -> tuple[int, int]:
        """Rows of the coefficients from a node to the next along x and y; 1 along the shorter side."""
        nx, ny = self.counts
        return (1, nx) if nx <= ny else (ny, 1)

    @property
    def node_count(self) -> int:
        """Number of nodes."""
        return self.counts[0] * self.counts[1]

    @property
    def half_width(self) -> int:
        """Half the bandwidth of the normal equations."""
        return 2 * (3 * min(self.counts) + 3) + 1

    def nodes(self) -> NDArray[np.float64]:
        """Return the places of the nodes, (nodes, 2), in the order of the coefficients."""
        x, y = (
            corner + self.spacing * (np.arange(count) - 1)
            for corner, count in zip(self.corner, self.counts, strict=True)
        )
        columns, rows = np.meshgrid(x, y)
        return np.stack([self.from_rows(columns), self.from_rows(rows)], axis=1)

    def as_rows(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Lay values of the nodes, (nodes,), out in rows along x, (ny, nx)."""
        nx, ny = self.counts
        return values.reshape(ny, nx) if self.steps[0] == 1 else values.reshape(nx, ny).T

    def from_rows(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Undo `as_rows`."""
        return np.ascontiguousarray(rows if self.steps[0] == 1 else rows.T).ravel()

    def samples(self, per_spacing: int) -> NDArray[np.float64]:
        """Return evenly spread points of the box, (N, 2)."""
        x, y = (
            corner + self.spacing * (np.arange((count - 3) * per_spacing) + 0.5) / per_spacing
            for corner, count in zip(self.corner, self.counts, strict=True)
        )
        return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether points, (..., 2), lie in the box."""
        g = (np.asarray(points, np.float64) - self.corner) / self.spacing
        return np.asarray(((g >= 0) & (g <= np.array(self.counts) - 3)).all(axis=-1), np.bool_)


@dataclass(frozen=True, slots=True, eq=False)
class Displacement:
    """Displacement u of the plane: x goes to x + u(x), in the pixels of A; constant outwards beyond its lattice.

    Parameters
    ----------
    lattice
        Its nodes.
    coefficients
        Shape (nodes, 2), in cells of A, in the order of `Lattice.steps`.
    """

    lattice: Lattice
    coefficients: NDArray[np.float64]

    @classmethod
    def none(cls, lattice: Lattice) -> Displacement:
        """Return the displacement that moves nothing."""
        return cls(lattice, np.zeros((lattice.node_count, 2)))

    def at(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return u at points, shape (..., 2)."""
        flat, shape = _flat(points)
        grid = self.lattice
        moves = spline_lattice.displace(self.coefficients, grid.corner, grid.spacing, grid.counts, grid.steps, flat)
        return moves.reshape(shape)

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return x + u(x) for points, shape (..., 2)."""
        moved: NDArray[np.float64] = np.asarray(points, np.float64) + self.at(points)
        return moved

    def undo(
        self, points: ArrayLike, *, tolerance: float = EXACT_CELLS, max_steps: int = MAX_INVERSE_STEPS
    ) -> NDArray[np.float64]:
        """Return the points that `apply` takes to the given ones, shape (..., 2); exact where nothing is folded."""
        flat, shape = _flat(points)
        grid = self.lattice
        found = spline_lattice.undo(
            self.coefficients, grid.corner, grid.spacing, grid.counts, grid.steps, flat, tolerance, max_steps
        )
        return found.reshape(shape)

    def jacobian(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the derivative of x + u(x) at points, shape (..., 2, 2)."""
        flat, shape = _flat(points)
        grid = self.lattice
        rows = spline_lattice.gradients(self.coefficients, grid.corner, grid.spacing, grid.counts, grid.steps, flat)
        jacobian: NDArray[np.float64] = np.eye(2) + rows.reshape(*shape, 2)
        return jacobian

    def extremes(self) -> tuple[float, float, float]:
        """Return the least determinant and the least and the greatest stretch of the Jacobian over the lattice."""
        jacobian = self.jacobian(self.lattice.samples(SAMPLES_PER_SPACING))
        stretch = np.linalg.svd(jacobian, compute_uv=False)
        return float(np.linalg.det(jacobian).min()), float(stretch.min()), float(stretch.max())


def _flat(points: ArrayLike) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    array = np.asarray(points, np.float64)
    return np.ascontiguousarray(array.reshape(-1, 2)), array.shape
