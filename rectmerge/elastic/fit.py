"""Fit of a displacement to the walls of two maps: Gauss-Newton steps with a shrinking reach."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.banded import solve_banded
from rectmerge._kernels.spline_lattice import add_pulls, wall_pulls
from rectmerge.elastic.lattice import Displacement, Lattice
from rectmerge.elastic.matching import FacePair
from rectmerge.elastic.params import FitParams
from rectmerge.elastic.smoothness import smoothness

RIDGE = 1e-9  # of the largest diagonal element: nodes without walls around them stay


@dataclass(frozen=True, slots=True, eq=False)
class ElasticFit:
    """The problem of fitting a displacement to two maps, or to part of their faces.

    Parameters
    ----------
    pair
        Faces of both maps under their similarity.
    lattice
        Nodes over B's walls.
    prior
        Of `smoothness`.
    params
        Weights and steps.
    """

    pair: FacePair
    lattice: Lattice
    prior: NDArray[np.float64]
    params: FitParams

    @classmethod
    def of_pair(cls, pair: FacePair, params: FitParams) -> ElasticFit:
        """Lay a lattice over B's walls, and a margin as wide as a wall's reach at the end, not far beyond A's walls."""
        margin, beyond = params.reaches[-1] * pair.diagonal, params.beyond * pair.diagonal
        low = np.maximum(pair.placed.min(axis=0) - margin, pair.a.points.min(axis=0) - beyond)
        high = np.minimum(pair.placed.max(axis=0) + margin, pair.a.points.max(axis=0) + beyond)
        lattice = Lattice.over(low, high, params.spacing * pair.diagonal)
        return cls(pair, lattice, smoothness(lattice, params.patch * pair.diagonal, params), params)

    def fit(self, of_a: NDArray[np.intp], of_b: NDArray[np.intp]) -> Displacement:
        """Fit the displacement to faces `of_a` of A and `of_b` of B, given by their numbers."""
        found = Displacement.none(self.lattice)
        for reach, stiffness in zip(self.params.reaches, self.params.stiffness, strict=True):
            found = self._step(found, reach * self.pair.diagonal, stiffness, of_a, of_b)
        return found

    def _step(
        self,
        now: Displacement,
        reach: float,
        stiffness: float,
        of_a: NDArray[np.intp],
        of_b: NDArray[np.intp],
    ) -> Displacement:
        """Return the minimum of the energy with the partners that faces have now."""
        band, right = stiffness * self.prior, np.zeros(2 * self.lattice.node_count)
        params, pair = self.params, self.pair
        faces = pair.moved(now, of_a, of_b)
        for wall, back, weight in zip(
            faces.match(reach), faces.match_backs(reach), (pair.weight_b, pair.weight_a), strict=True
        ):
            share = weight / params.correlated_cells / (2 * params.wall_std_cells**2)
            along = params.along_weight * share
            pulls = wall_pulls(wall.offsets, wall.normals, wall.is_matched, reach, share, along)
            self._add(band, right, now, wall.points, pulls)
            is_behind = back.is_matched & ~wall.is_matched
            behind = params.behind_weight * share
            pulls = wall_pulls(back.offsets, back.normals, is_behind, reach, behind, 0.0)
            self._add(band, right, now, back.points, pulls)
        band[:, 0] += RIDGE * band[:, 0].max()
        return Displacement(self.lattice, solve_banded(band, right).reshape(-1, 2))

    def _add(
        self,
        band: NDArray[np.float64],
        right: NDArray[np.float64],
        now: Displacement,
        points: NDArray[np.float64],
        pulls: tuple[NDArray[np.float64], NDArray[np.float64]],
    ) -> None:
        """Add the pulls on displaced points to the normal equations."""
        grid = self.lattice
        add_pulls(
            band, right, now.coefficients, grid.corner, grid.spacing, grid.counts, grid.steps, points, *pulls
        )  # fmt: skip
