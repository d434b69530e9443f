"""Working pair: the features of two maps, ready for placements of B on A to be compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.placements import distinct
from rectmerge.analysis.wall_faces import EIGHTH, QUARTER, WallFaces, rounded_turn
from rectmerge.robust.confidence_model import bent_handicap
from rectmerge.robust.features import Features
from rectmerge.robust.likelihood import WallLikelihood, WallNoise
from rectmerge.robust.params import Params
from rectmerge.robust.prepared_map import PreparedMap
from rectmerge.robust.refinement import refine
from rectmerge.robust.wall_agreement import AgreementScorer


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class WorkingPair:
    """Features of two maps, with their walls in random order.

    Parameters
    ----------
    a, b
        The features; B is moved.
    walls_a, walls_b
        Their wall points in random order: the first ones stand for all where not all are used.
    scale_bounds
        Bounds of the scale between the working grids.
    angle, angle_b
        Of the strongest direction of A's walls and of B's, radians.
    scorer
        Scorer of the agreement of the walls.
    handicap
        Log-odds by which the maps are less likely bent, 0 or below.
    params
        Parameters of the method.
    """

    a: Features
    b: Features
    walls_a: NDArray[np.float64]
    walls_b: NDArray[np.float64]
    scale_bounds: tuple[float, float]
    angle: float
    angle_b: float
    scorer: AgreementScorer
    handicap: float
    params: Params

    @classmethod
    def from_maps(
        cls,
        fixed: PreparedMap,
        moving: PreparedMap,
        scale: tuple[float, float],
        rng: np.random.Generator,
        params: Params,
    ) -> WorkingPair:
        """Pair two maps with walls; `scale` bounds the scale between their pixels."""
        a, b, angle, angle_b = fixed.walled, moving.walled, fixed.angles[0][0], moving.angles[0][0]
        between = scale[0] * b.factor / a.factor, scale[1] * b.factor / a.factor
        return cls(
            a=a,
            b=b,
            walls_a=rng.permutation(a.walls),
            walls_b=rng.permutation(b.walls),
            scale_bounds=params.exact.widened(between),
            angle=angle,
            angle_b=angle_b,
            scorer=AgreementScorer((a, b), (fixed.detailed, moving.detailed), (angle, angle_b), params),
            handicap=bent_handicap(max(fixed.thickness_cells, moving.thickness_cells), params.confidence),
            params=params,
        )

    def likelihood(self, noise: WallNoise) -> WallLikelihood:
        """Return the likelihood of the walls under a noise."""
        return WallLikelihood(self.a, self.b, self.walls_a, self.walls_b, noise, self.params.gain)

    def fit(self, placements: NDArray[np.float64], points: int, reaches: Sequence[float]) -> NDArray[np.float64]:
        """Refine placements by some of the wall points of each map, shape (N, 4)."""
        walls = self.walls_a[:points], self.walls_b[:points]
        return refine(placements, self.a, self.b, walls, tuple(reaches), self.scale_bounds)

    def faces_of_b(self, turn: float) -> WallFaces:
        """Return B's faces, of the eight ways of its own frame the four that a turn brings nearest to A's normals.

        Their angle is the one that the turn lays on A's.
        """
        quarters, is_oblique = map(int, rounded_turn(self.angle - turn - self.angle_b))
        faces = self.b.faces(self.angle_b + is_oblique * EIGHTH, self.params.faces)
        return replace(faces, angle=self.angle - turn - quarters * QUARTER)

    def distinct(self, placements: NDArray[np.float64], apart_cells: float, max_kept: int) -> NDArray[np.intp]:
        """Return the indices of the first placements of each neighbourhood."""
        indices: NDArray[np.intp] = distinct(placements, self.b.landmarks, apart_cells, max_kept)
        return indices
