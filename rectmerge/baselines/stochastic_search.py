"""Baseline `stochastic-search`: adaptive random walks towards the placement of the greatest image similarity."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.random_walk import walk
from rectmerge.alignment import Alignment
from rectmerge.analysis.downscaling import Shrunk, between_given, shrunk_bounds
from rectmerge.analysis.overlap import cells_of
from rectmerge.baselines.acceptance import CellComparison
from rectmerge.baselines.ranked_answer import Placement, answer
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

LEAST_STEP = np.array([math.radians(0.1), 0.002, 0.2, 0.2])  # deviations of turn, ln scale, u and v


@dataclass(frozen=True, slots=True, kw_only=True)
class StochasticSearch:
    """Search placements by random walks that adapt their steps; accept where the cells of both maps agree.

    Parameters
    ----------
    side_cells
        The longest side of the images that are compared, in cells.
    cells
        Cells of each value and map whose distances are summed.
    walks
        Walks, each from a placement drawn over all angles, scales and shifts.
    steps
        Steps of a walk.
    history
        Accepted samples whose spread is the size of the next step.
    worse_share
        Probability that a step is accepted although it is worse.
    lock_cells
        The article's c_lock: the weight of an agreeing cell against distances, in cells.
    least_overlap
        Placements where less of the smaller map is known in both do not count.
    accept_at
        The least acceptance indicator, agreeing cells over those known in both, that is accepted.

    Raises
    ------
    InputError
        If a count is below 1, `history` below 2, `lock_cells` negative, or a share or threshold outside 0..1.

    Notes
    -----
    A. Birk and S. Carpin, "Merging occupancy grid maps from multiple robots", Proc. IEEE 94(7), 2006,
    DOI 10.1109/JPROC.2006.876965: the image similarity psi (for free and occupied, the mean Manhattan distance of each
    cell to the nearest of the same value in the other map, both ways), minimised together with c_lock times
    disagreeing less agreeing cells, by the random walk of S. Carpin and G. Pillonetto, IEEE Trans. Robotics 21(1),
    2005, DOI 10.1109/TRO.2004.833790, whose Gaussian steps take their spread from the last accepted samples.

    Extended for unknown scale: ln scale is a fourth coordinate of the walk, held within its bounds. Departs from the
    article where it is slow: psi is taken over a choice of cells, and distances of A's cells are looked up in B's own
    distance map, along B's axes, times the scale; agreement counts as a share, so that c_lock does not depend on the
    size of a map. Several shorter walks replace a long one. The parameters are ours.
    Not compared with the authors' program.
    """

    name: ClassVar[str] = "stochastic-search"
    side_cells: int = 200
    cells: int = 250
    walks: int = 12
    steps: int = 2500
    history: int = 10
    worse_share: float = 0.01
    lock_cells: float = 10.0
    least_overlap: float = 0.2
    accept_at: float = 0.9

    def __post_init__(self) -> None:
        for field, least in (("side_cells", 1), ("cells", 1), ("walks", 1), ("steps", 1), ("history", 2)):
            if getattr(self, field) < least:
                raise InputError(f"{field} must be >= {least}, got {getattr(self, field)}")
        for field in ("worse_share", "least_overlap"):
            if not 0 <= getattr(self, field) <= 1:
                raise InputError(f"{field} must be in 0..1, got {getattr(self, field)}")
        if not 0 < self.accept_at <= 1:
            raise InputError(f"accept_at must be in (0, 1], got {self.accept_at}")
        if not self.lock_cells >= 0:
            raise InputError(f"lock_cells must be >= 0, got {self.lock_cells}")

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Place B on A; `scale` bounds the pixel scale (cells of A per cell of B)."""
        shrunk = Shrunk.from_grid(a, self.side_cells), Shrunk.from_grid(b, self.side_cells)
        sampled = [_SampledMap.from_grid(each.grid, self.cells, rng) for each in shrunk]
        for name, each in zip("AB", sampled, strict=True):
            if not all(map(len, each.cells)):
                reason = f"map {name} has no free or no occupied cell"
                return Alignment(verdict="rejected", reason=reason, method=self.name)
        ends = self._walk_ends(sampled[0], sampled[1], shrunk_bounds(scale, *shrunk), rng)
        comparison = CellComparison(shrunk[0].grid, shrunk[1].grid)
        placements = [
            Placement(between_given(pixels, *shrunk), comparison.acceptance_index(pixels))
            for pixels in ends
            if comparison.known_share(pixels) >= self.least_overlap
        ]
        nothing = f"no placement where {100 * self.least_overlap:g} % of the smaller map is known in both"
        return answer(self.name, a, b, placements, accept_at=self.accept_at, scale=scale, nothing=nothing)

    def _walk_ends(
        self, a: _SampledMap, b: _SampledMap, bounds: tuple[float, float], rng: np.random.Generator
    ) -> list[Similarity]:
        """Walk from random starts; return the most similar placement of each walk, the best first."""
        limits = math.log(bounds[0]), math.log(bounds[1])
        height, width = a.distances[0].shape
        lowest, highest = (-math.pi, limits[0], 0, 0), (math.pi, limits[1], width - 1, height - 1)
        ends = []
        for _ in range(self.walks):
            start = rng.uniform(lowest, highest, (self.history, 4))
            noise, luck = rng.normal(size=(self.steps, 4)), rng.random(self.steps) < self.worse_share
            best, value = walk(
                start,
                noise,
                luck,
                LEAST_STEP,
                limits,
                a.cells,
                b.cells,
                a.distances,
                b.distances,
                b.middle,
                self.lock_cells,
            )
            ends.append((value, best))
        return [_similarity(best, b.middle) for _, best in sorted(ends, key=lambda end: end[0])]


@dataclass(frozen=True, slots=True, eq=False)
class _SampledMap:
    """Sampled cells of a map, (N, 2) as (u, v), and Manhattan distances to all, (H, W): free first, then occupied."""

    cells: tuple[NDArray[np.float64], NDArray[np.float64]]
    distances: tuple[NDArray[np.float32], NDArray[np.float32]]
    middle: tuple[float, float]

    @classmethod
    def from_grid(cls, grid: OccupancyGrid, max_cells: int, rng: np.random.Generator) -> _SampledMap:
        """Draw at most `max_cells` cells of each value and measure the distances to all."""
        free, occupied = grid.free, grid.occupied
        cells = tuple(
            rng.permutation(cells_of(mask, mask.size))[:max_cells, ::-1].astype(np.float64) for mask in (free, occupied)
        )
        height, width = grid.shape
        middle = (width - 1) / 2, (height - 1) / 2
        return cls((cells[0], cells[1]), (_distance_to(free), _distance_to(occupied)), middle)


def _distance_to(mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    return np.asarray(cv2.distanceTransform((~mask).view(np.uint8), cv2.DIST_L1, cv2.DIST_MASK_3), np.float32)


def _similarity(at: NDArray[np.float64], middle: tuple[float, float]) -> Similarity:
    """Read (angle, ln scale, u, v) as the placement that takes `middle` to (u, v)."""
    turn = Similarity(math.exp(at[1]), float(at[0]))
    du, dv = turn.apply(middle)
    return Similarity(turn.scale, math.remainder(turn.angle, math.tau), float(at[2] - du), float(at[3] - dv))
