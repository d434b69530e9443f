"""Baseline `icp`: iterated closest points between walls, from many starts, for a similarity."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from rectmerge.alignment import Alignment
from rectmerge.analysis.dominant_angle import wall_points
from rectmerge.analysis.downscaling import Shrunk, between_given, shrunk_bounds
from rectmerge.baselines.ranked_answer import Placement, answer
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity

NOTHING = "no start converged to a placement within the bounds of the scale"


@dataclass(frozen=True, slots=True, kw_only=True)
class Icp:
    """Align walls by trimmed, two-way iterated closest points from a grid of starts over angle, scale and shift.

    Parameters
    ----------
    side_cells
        The longest side of the images that walls are taken from, in cells.
    angles, scales, shifts
        Starts: angles over the full turn, scales over the bounds, evenly in ln scale, and wall cells of B moved to
        the mean of A's walls; as many starts as their product.
    points
        Wall cells of each map in the search; the best starts are finished with ten times as many.
    rounds
        Iterations of the search, and of the finish.
    finished
        Starts that are finished.
    kept_share
        Share of the correspondences of each map that the search keeps, the closest: in (0, 1].
    reach_share
        Correspondences this close are kept by the finish, as a share of the spread of A's walls.
    near_share
        Walls this close to the other map's walls match, as a share of the spread of A's walls.
    accept_at
        The least score that is accepted.

    Raises
    ------
    InputError
        If a count is below 1, or a share or threshold is outside (0, 1].

    Notes
    -----
    P. J. Besl and N. D. McKay, PAMI 1992, DOI 10.1109/34.121791; correspondences trimmed as in D. Chetverikov et al.,
    Image and Vision Computing 2005, DOI 10.1016/j.imavis.2004.05.007; fitted by S. Umeyama, PAMI 1991,
    DOI 10.1109/34.88573.

    Extended for unknown scale as T. Zinsser, J. Schmidt and H. Niemann do ("Point set registration with integrated
    scale estimation", PRIP 2005): every iteration fits the scale, too, here held within its bounds. A closest point in
    one direction only would shrink B into any dense spot of A, so correspondences of both directions are fitted
    together. The score is the geometric mean of the two shares of walls that match. None of the articles is about
    maps: starts and thresholds are ours, and `accept_at` is a half, "most walls match". The random generator chooses
    the points. Not compared with the authors' program.
    """

    name: ClassVar[str] = "icp"
    side_cells: int = 400
    angles: int = 24
    scales: int = 5
    shifts: int = 7
    points: int = 80
    rounds: int = 20
    finished: int = 24
    kept_share: float = 0.7
    reach_share: float = 0.12
    near_share: float = 0.015
    accept_at: float = 0.5

    def __post_init__(self) -> None:
        for field in ("side_cells", "angles", "scales", "shifts", "points", "rounds", "finished"):
            if getattr(self, field) < 1:
                raise InputError(f"{field} must be >= 1, got {getattr(self, field)}")
        for field in ("kept_share", "reach_share", "near_share", "accept_at"):
            if not 0 < getattr(self, field) <= 1:
                raise InputError(f"{field} must be in (0, 1], got {getattr(self, field)}")

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Place B on A; `scale` bounds the pixel scale (cells of A per cell of B)."""
        shrunk = Shrunk.from_grid(a, self.side_cells), Shrunk.from_grid(b, self.side_cells)
        walls = [wall_points(each.grid) for each in shrunk]
        for name, points in zip("AB", walls, strict=True):
            if len(np.unique(points, axis=0)) < 2:
                return Alignment(verdict="rejected", reason=f"map {name} has no two wall cells", method=self.name)
        bounds = shrunk_bounds(scale, *shrunk)
        all_a, all_b = _Walls.from_points(walls[0]), _Walls.from_points(walls[1])
        few = all_a.sample(self.points, rng), all_b.sample(self.points, rng)
        near = self.near_share * few[0].spread
        starts = self._iterate(self._starts(*few, bounds), *few, bounds, self._closest)
        best = np.argsort(-_score(starts, *few, near), kind="stable")[: self.finished]
        many = all_a.sample(10 * self.points, rng), all_b.sample(10 * self.points, rng)
        fits = self._iterate(starts[best], *many, bounds, lambda gaps: _within(gaps, self.reach_share * few[0].spread))
        placements = [
            Placement(between_given(_similarity(fit), *shrunk), float(score))
            for fit, score in zip(fits, _score(fits, *many, near), strict=True)
        ]
        return answer(self.name, a, b, placements, accept_at=self.accept_at, scale=scale, nothing=NOTHING)

    def _starts(self, a: _Walls, b: _Walls, bounds: tuple[float, float]) -> NDArray[np.complex128]:
        """Move wall cells of B to the mean of A's walls at every angle and scale, shape (S, 2)."""
        angles = np.arange(self.angles) * math.tau / self.angles
        scales = np.geomspace(*bounds, self.scales) if bounds[0] < bounds[1] else np.array(bounds[:1])
        turns = (scales[:, None] * np.exp(1j * angles)).ravel()
        anchors = np.append(b.points.mean(), b.points)[: self.shifts]
        turn, anchor = np.repeat(turns, len(anchors)), np.tile(anchors, len(turns))
        return np.stack([turn, a.points.mean() - turn * anchor], axis=1)

    def _iterate(
        self,
        fits: NDArray[np.complex128],
        a: _Walls,
        b: _Walls,
        bounds: tuple[float, float],
        kept: Callable[[NDArray[np.float64]], NDArray[np.bool_]],
    ) -> NDArray[np.complex128]:
        """Improve placements (S, 2) by rounds of closest points and a fit to those of both directions that are kept."""
        for _ in range(self.rounds):
            placed = fits[:, :1] * b.points + fits[:, 1:]  # (S, N)
            fetched = (a.points - fits[:, 1:]) / fits[:, :1]
            source = np.concatenate([np.broadcast_to(b.points, placed.shape), b.nearest(fetched)], axis=1)
            target = np.concatenate([a.nearest(placed), np.broadcast_to(a.points, fetched.shape)], axis=1)
            gaps = np.abs(fits[:, :1] * source + fits[:, 1:] - target)
            count = placed.shape[1]
            weights = np.concatenate([kept(gaps[:, :count]), kept(gaps[:, count:])], axis=1)
            fits = _fit(source, target, weights, bounds)
        return fits

    def _closest(self, gaps: NDArray[np.float64]) -> NDArray[np.bool_]:
        return gaps <= np.quantile(gaps, self.kept_share, axis=1, keepdims=True)


def _within(gaps: NDArray[np.float64], reach: float) -> NDArray[np.bool_]:
    """Keep the gaps within reach, and a tenth of them at the least."""
    return gaps <= np.maximum(reach, np.quantile(gaps, 0.1, axis=1, keepdims=True))


@dataclass(frozen=True, slots=True, eq=False)
class _Walls:
    """Wall points as complex numbers u + i v, all or a sample, with the nearest of all for every cell around them.

    Parameters
    ----------
    points
        Shape (N,).
    closest
        Shape (H, W): the wall point nearest to a cell of a canvas with room around the walls.
    corner
        The canvas's first cell.
    spread
        Root of the mean square distance of all wall points from their mean, in cells.
    """

    points: NDArray[np.complex128]
    closest: NDArray[np.complex128]
    corner: complex
    spread: float

    @classmethod
    def from_points(cls, walls: NDArray[np.float64]) -> _Walls:
        """Take all wall points (W, 2) and tabulate the nearest of them around."""
        size = np.ptp(walls, axis=0).max()
        room = int(size // 4) + 2
        corner = walls.min(axis=0) - room
        u, v = (walls - corner).astype(np.intp).T
        open_space = np.ones((v.max() + room + 1, u.max() + room + 1), np.uint8)
        open_space[v, u] = 0
        _, labels = cv2.distanceTransformWithLabels(
            open_space, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
        )
        by_label = np.zeros(int(labels.max()) + 1, np.complex128)
        places = walls @ np.array([1, 1j])
        by_label[labels[v, u]] = places
        spread = float(np.sqrt(np.mean(np.abs(places - places.mean()) ** 2)))
        return cls(places, by_label[labels], complex(*corner), spread)

    def sample(self, max_points: int, rng: np.random.Generator) -> _Walls:
        """Draw at most `max_points` of the wall points; the nearest is still that of all."""
        return dataclasses.replace(self, points=rng.permutation(self.points)[:max_points])

    def nearest(self, points: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the wall point nearest to each point; beyond the canvas, that of the canvas's nearest cell."""
        height, width = self.closest.shape
        at = points - self.corner
        u, v = np.rint(at.real.clip(0, width - 1)).astype(np.intp), np.rint(at.imag.clip(0, height - 1)).astype(np.intp)
        nearest: NDArray[np.complex128] = self.closest[v, u]
        return nearest


def _fit(
    source: NDArray[np.complex128],
    target: NDArray[np.complex128],
    weights: NDArray[np.bool_],
    bounds: tuple[float, float],
) -> NDArray[np.complex128]:
    """Fit similarities, as z -> fit[0] z + fit[1], to points (S, N) with weights, the scale held within its bounds."""
    total = weights.sum(axis=1, keepdims=True)
    mean_source = (weights * source).sum(axis=1, keepdims=True) / total
    mean_target = (weights * target).sum(axis=1, keepdims=True) / total
    p, q = source - mean_source, target - mean_target
    product = (weights * p.conj() * q).sum(axis=1)
    energy = (weights * np.abs(p) ** 2).sum(axis=1)
    scale = np.clip(np.abs(product) / np.maximum(energy, np.finfo(float).tiny), *bounds)
    turn = scale * np.exp(1j * np.angle(product))
    return np.stack([turn, mean_target[:, 0] - turn * mean_source[:, 0]], axis=1)


def _score(fits: NDArray[np.complex128], a: _Walls, b: _Walls, near: float) -> NDArray[np.float64]:
    """Return the geometric mean of the shares of walls near the other map's walls, shape (S,)."""
    placed = fits[:, :1] * b.points + fits[:, 1:]
    fetched = (a.points - fits[:, 1:]) / fits[:, :1]
    on_a = np.abs(placed - a.nearest(placed)) <= near
    on_b = np.abs(fits[:, :1]) * np.abs(fetched - b.nearest(fetched)) <= near
    score: NDArray[np.float64] = np.sqrt(on_a.mean(axis=1) * on_b.mean(axis=1))
    return score


def _similarity(fit: NDArray[np.complex128]) -> Similarity:
    return Similarity(float(abs(fit[0])), float(np.angle(fit[0])), float(fit[1].real), float(fit[1].imag))
