"""The search for placements of one map's working grid on another's: propose, screen, refine, rank."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.placements import add_scores, distinct, invert
from rectmerge.overlap import area_overlap, cells_of
from rectmerge.robust.features import Features, Frame
from rectmerge.robust.hypotheses import propose
from rectmerge.robust.likelihood import BENDING_NOISE, JUDGED_NOISES, SEARCH_NOISE, Judge, WallNoise
from rectmerge.robust.refinement import BROAD, FINE, ONTO_BENT, ONTO_RIGID, refine
from rectmerge.robust.verdict import Evidence, likelihood_ratio

SCREEN_POINTS = (40, 200)  # wall points of each map in the two screenings
SEARCH_POINTS, FINAL_POINTS = 300, 800  # wall points of each map in the two refinements
SAME_CELLS = 4.0  # hypotheses closer than this, in working cells, are one
SAME_FIT_CELLS = 3.0  # so are refined ones
SAME_RADIUS = 0.25  # answers closer than this share of the map's radius say the same
FITS = 15  # refined placements that are judged in full
BENT_FITS = 8  # of these, judged as bent maps too
SAMPLED_FLOOR = 2000  # free cells that stand for all where overlaps are compared
KEPT = 20
DAMPING_RIGID, DAMPING_LOOSE = 0.25, 0.5  # powers of the overlap by which likelihoods are damped
BESIDE_CELLS = 3.0
DEEP_CELLS = 8.0  # a wall this far from the other map's walls, in its free space, is missing there


@dataclass(frozen=True, slots=True, eq=False)
class Ranking:
    """Placements between working grids, best first.

    Parameters
    ----------
    placements
        Shape (N, 4), rows (a, b, tx, ty).
    likelihoods
        Shape (N,): log-likelihood ratio of the walls, damped by a power of the overlap.
    """

    placements: NDArray[np.float64]
    likelihoods: NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Search:
    """Two maps' features, made ready to be compared.

    Parameters
    ----------
    a, b
        The features; B is moved.
    walls_a, walls_b
        Their wall points in random order: the first ones stand for all where not all are used.
    scale_bounds
        Bounds of the scale between the working grids.
    screened, refined
        Hypotheses kept by the first screening, and refined.
    """

    a: Features
    b: Features
    walls_a: NDArray[np.float64]
    walls_b: NDArray[np.float64]
    scale_bounds: tuple[float, float]
    screened: int
    refined: int

    def run(self, frames_a: Sequence[Frame], frames_b: Sequence[Frame]) -> Ranking:
        """Rank the placements that the rectangles of the frames propose."""
        hypotheses = propose(frames_a, frames_b, self.scale_bounds)
        if len(hypotheses) == 0:
            return Ranking(np.empty((0, 4)), np.empty(0))
        judge = self._judge(SEARCH_NOISE)
        return self._ranked(self._refined(judge, self._screen(judge, hypotheses)))

    def evidence(self, ranking: Ranking, which: int = 0) -> Evidence:
        """Gather the evidence for one of the ranked placements against the best of the others."""
        placement, likelihood = ranking.placements[which], float(ranking.likelihoods[which])
        overlap, iou = free_overlap(placement, self.a, self.b)
        apart = SAME_RADIUS * self.b.radius * math.hypot(placement[0], placement[1])
        here = _moved(placement[None], self.b.landmarks)
        elsewhere = np.abs(_moved(ranking.placements, self.b.landmarks) - here).max(axis=(1, 2)) >= apart  # (N,)
        rival = float(ranking.likelihoods[elsewhere].max(initial=0.0))
        return Evidence(
            likelihood=likelihood,
            rival=likelihood_ratio(rival, likelihood),
            overlap=overlap,
            iou=iou,
            support=likelihood / min(len(self.walls_a), len(self.walls_b)),
            missing=self._missing(placement),
        )

    def _missing(self, placement: NDArray[np.float64]) -> float:
        deep_b, known_b = _walls_in(self.a, _moved(placement[None], self.walls_b)[0], DEEP_CELLS)
        back = invert(placement[None])
        deep_a, known_a = _walls_in(self.b, _moved(back, self.walls_a)[0], DEEP_CELLS * math.hypot(*back[0, :2]))
        return (deep_b + deep_a) / max(1, known_b + known_a)

    def _screen(self, judge: Judge, hypotheses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Keep the distinct hypotheses under which a sample of the walls agrees best."""
        for points, most in zip(SCREEN_POINTS, (self.screened, len(hypotheses)), strict=True):
            hypotheses = _best(hypotheses, judge.score(hypotheses, most_points=points), most)
        return self._distinct(hypotheses, SAME_CELLS, self.refined)

    def _refined(self, judge: Judge, hypotheses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Refine the hypotheses, half of them all the way, and keep the best, distinct ones."""
        fits = self._fit(hypotheses, SEARCH_POINTS, BROAD)
        fits = _best(fits, judge.score(fits), len(fits) // 2 + 1)
        fits = self._fit(fits, SEARCH_POINTS, FINE)
        fits = _best(fits, judge.score(fits), len(fits))
        return self._distinct(fits, SAME_FIT_CELLS, FITS)

    def _distinct(self, placements: NDArray[np.float64], apart: float, most: int) -> NDArray[np.float64]:
        kept: NDArray[np.float64] = placements[distinct(placements, self.b.landmarks, apart, most)]
        return kept

    def _ranked(self, fits: NDArray[np.float64]) -> Ranking:
        """Give each fit its most likely form, as rigid or bent maps, and rank by likelihood under the best noise.

        Of two fits the one with more overlap is likelier, the more so if they need wide or bent walls.
        """
        forms = np.stack([fits, *(self._fit(fits, FINAL_POINTS, reaches) for reaches in (ONTO_RIGID, ONTO_BENT))])
        judges = [self._judge(noise) for noise in JUDGED_NOISES]
        scores = np.array([[judge.score(form) for judge in judges] for form in forms])  # (3, K, N)
        form, each = scores.max(axis=1).argmax(axis=0), np.arange(len(fits))
        placements, scores = forms[form, each], scores[form, :, each].T  # (N, 4), (K, N)
        overlaps = sampled_overlaps(placements, self.a, self.b)
        rigid, loose = scores[0] * overlaps**DAMPING_RIGID, scores[1:].max(axis=0) * overlaps**DAMPING_LOOSE
        likelihoods = np.maximum(rigid, loose)
        best = np.argsort(-likelihoods, kind="stable")[:BENT_FITS]
        bent = self._judge(BENDING_NOISE).score_bent(placements[best]) * overlaps[best] ** DAMPING_LOOSE
        likelihoods[best] = np.maximum(likelihoods[best], bent)
        order = np.argsort(-likelihoods, kind="stable")
        order = order[distinct(placements[order], self.b.landmarks, SAME_FIT_CELLS, KEPT)]
        return Ranking(placements[order], likelihoods[order])

    def _judge(self, noise: WallNoise) -> Judge:
        return Judge(self.a, self.b, self.walls_a, self.walls_b, noise)

    def _fit(self, placements: NDArray[np.float64], points: int, reaches: tuple[float, ...]) -> NDArray[np.float64]:
        walls = self.walls_a[:points], self.walls_b[:points]
        return refine(placements, self.a, self.b, walls, reaches, self.scale_bounds)


def free_overlap(placement: NDArray[np.float64], a: Features, b: Features) -> tuple[float, float]:
    """Share of the smaller free space, and of the union, that both maps see free under a placement."""
    matrix = np.array([[placement[0], -placement[1], placement[2]], [placement[1], placement[0], placement[3]]])
    return area_overlap(a.free.view(np.uint8), b.free.view(np.uint8), matrix)


def sampled_overlaps(placements: NDArray[np.float64], a: Features, b: Features) -> NDArray[np.float64]:
    """Estimate the overlap of the free spaces under each placement, shape (N,), from evenly spaced free cells of B."""
    floor = np.ascontiguousarray(cells_of(b.free, SAMPLED_FLOOR)[:, ::-1].T, np.float32)
    hits = np.zeros(len(placements), np.int64)
    add_scores(placements, floor, a.free.astype(np.int32), hits)
    area_a, area_b = np.count_nonzero(a.free), np.count_nonzero(b.free) * (placements[:, :2] ** 2).sum(axis=1)
    overlaps: NDArray[np.float64] = hits / max(1, floor.shape[1]) * area_b / np.minimum(area_a, area_b)
    return np.minimum(1.0, overlaps)


def _walls_in(other: Features, points: NDArray[np.float64], deep: float) -> tuple[int, int]:
    """Count the points that lie deep in a map's free space, and those on its known cells or beside its walls."""
    u, v = np.rint(points).astype(np.intp).T
    height, width = other.free.shape
    inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
    cells = v[inside], u[inside]
    distance = other.distance[cells]
    is_deep = other.free[cells] & (distance > deep)
    return int(is_deep.sum()), int((other.known[cells] | (distance < BESIDE_CELLS)).sum())


def _best(placements: NDArray[np.float64], scores: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """Order placements by score, best first, and keep the first ones."""
    best: NDArray[np.float64] = placements[np.argsort(-scores, kind="stable")[:most]]
    return best


def _moved(placements: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Move points, shape (P, 2), by each placement: shape (N, P, 2)."""
    a, b, tx, ty = placements.T[:, :, None]
    u, v = points.T
    moved: NDArray[np.float64] = np.stack([a * u - b * v + tx, b * u + a * v + ty], axis=-1)
    return moved
