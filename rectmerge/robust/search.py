"""Finding the placements that explain both maps: proposed by rectangles or by trying every shift, judged by walls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from rectmerge._kernels.placements import distinct
from rectmerge.analysis.wall_faces import WallFaces
from rectmerge.robust.confidence_model import bent_odds, plausibility, rigid_odds
from rectmerge.robust.correlation import correlate, scales_within
from rectmerge.robust.features import Features, Frame
from rectmerge.robust.hypotheses import propose
from rectmerge.robust.likelihood import BENDING_NOISE, JUDGED_NOISES, SEARCH_NOISE, WallLikelihood, WallNoise
from rectmerge.robust.refinement import BROAD, FINE, NARROW, ONTO_BENT, ONTO_RIGID, refine
from rectmerge.robust.wall_agreement import AgreementScorer, WallAgreement

SCREEN_POINTS = (40, 200)  # wall points of each map in the two screenings
SEARCH_POINTS, FINAL_POINTS = 300, 800  # wall points of each map in the two refinements
SAME_CELLS = 4.0  # hypotheses closer than this, in working cells, are one
SAME_FIT_CELLS = 3.0  # so are refined ones
SAME_RADIUS = 0.2  # answers closer than this share of the map's radius say the same
NEARLY_AS_PLAUSIBLE = 6.0  # difference of log-odds
FITS = 15  # refined placements of rectangles that are judged in full
SHIFTS, RIVALS = 8, 5  # correlated shifts kept of each turn: of every scale, and beside the best placement
SWEPT = 48  # correlated placements that are refined and judged in full
BENT_FITS = 8  # of these, judged as bent maps too
KEPT = 20
DAMPING_RIGID, DAMPING_LOOSE = 0.25, 0.5  # powers of the overlap by which likelihoods are damped


@dataclass(frozen=True, kw_only=True, eq=False)
class Ranking(WallAgreement):
    """N distinct placements between working grids, most plausible first, and what speaks for each.

    Parameters
    ----------
    placements
        Shape (N, 4), rows (a, b, tx, ty).
    likelihood, support
        Shape (N,): log-likelihood ratio of the walls, damped by a power of the overlap, and per wall point of the map
        that has fewer.
    rigid, bent
        Shape (N,): log-odds that a placement is right, were there no other, if the maps are rigid and if they are bent.
    plausibility
        Shape (N,): both together.
    """

    placements: NDArray[np.float64]
    likelihood: NDArray[np.float64]
    support: NDArray[np.float64]
    rigid: NDArray[np.float64]
    bent: NDArray[np.float64]
    plausibility: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.placements)

    @property
    def best(self) -> float:
        """The highest plausibility, minus infinity where there is no placement."""
        return float(self.plausibility[0]) if len(self) else -math.inf

    def at(self, which: int) -> dict[str, float]:
        """Return what speaks for one placement, by name."""
        names = [field.name for field in fields(self) if field.name != "placements"]
        return {name: float(getattr(self, name)[which]) for name in names}


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
    angle
        Of the strongest directions of A's walls, radians.
    scales
        What placements are weighed on.
    handicap
        Log-odds by which the maps are less likely bent, 0 or below.
    screened, refined
        Hypotheses kept by the first screening, and refined.
    """

    a: Features
    b: Features
    walls_a: NDArray[np.float64]
    walls_b: NDArray[np.float64]
    scale_bounds: tuple[float, float]
    angle: float
    scales: AgreementScorer
    handicap: float
    screened: int
    refined: int

    def by_rectangles(self, frames_a: Sequence[Frame], frames_b: Sequence[Frame]) -> NDArray[np.float64]:
        """Refine the best of the placements that pairs of rectangles propose, shape (N, 4)."""
        hypotheses = propose(frames_a, frames_b, self.scale_bounds)
        return self.near(hypotheses) if len(hypotheses) else np.empty((0, 4))

    def by_correlation(self, angles_a: Sequence[float], angles_b: Sequence[float]) -> NDArray[np.float64]:
        """Refine the best of all shifts, at every scale, that lay a direction of B on one of A, shape (N, 4)."""
        sides_b = [self.b.faces(angle) for angle in angles_b]
        pairs = [(self.a.faces(angle), on_b) for angle in angles_a for on_b in sides_b]
        return self._best_shifts(pairs, scales_within(self.scale_bounds), SHIFTS, SWEPT)

    def rivals_of(self, placement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Refine the best of all shifts and quarter turns beside a placement, at its scale, shape (N, 4)."""
        turn, scale = math.atan2(placement[1], placement[0]), math.hypot(placement[0], placement[1])
        pair = self.a.faces(self.angle), self.b.faces(self.angle - turn)
        return self._best_shifts([pair], np.array([scale]), RIVALS, 4 * RIVALS)

    def near(self, starts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Refine the best of some placements, shape (N, 4)."""
        judge = self._judge(SEARCH_NOISE)
        return self._refined(judge, self._screen(judge, starts))

    def rank(self, fits: NDArray[np.float64]) -> Ranking:
        """Give each fit, shape (N, 4), its most plausible form, as rigid or bent maps, and rank them."""
        forms = np.concatenate([fits, *(self._fit(fits, FINAL_POINTS, reaches) for reaches in (ONTO_RIGID, ONTO_BENT))])
        weights = self.scales.score(forms)
        likelihood = self._likelihoods(forms, weights.overlap)
        support = likelihood / min(len(self.walls_a), len(self.walls_b))
        judged = Ranking(
            placements=forms,
            likelihood=likelihood,
            support=support,
            rigid=(rigid := rigid_odds(weights)),
            bent=(bent := bent_odds(weights, support) + self.handicap),
            plausibility=np.logaddexp(rigid, bent),
            **vars(weights),
        )
        return self.ranked(judged)

    def ranked(self, ranking: Ranking) -> Ranking:
        """Order placements that were judged, most plausible first, and keep the distinct ones."""
        odds = np.logaddexp(ranking.rigid, ranking.bent)
        order = np.argsort(-odds, kind="stable")
        apart = self.same_within
        heads = order[distinct(ranking.placements[order], self.b.landmarks, apart, KEPT)]
        likeliest = ranking.take(self._likeliest_beside(heads, ranking, odds, apart))
        kept = replace(likeliest, rigid=ranking.rigid[heads], bent=ranking.bent[heads])
        weighed = replace(kept, plausibility=plausibility(kept.rigid, kept.bent))
        return self.best_distinct(weighed)  # two heads may have had the same placement between them

    def best_distinct(self, ranking: Ranking) -> Ranking:
        """Order placements, most plausible first, and leave out what says the same as one before it."""
        order = np.argsort(-ranking.plausibility, kind="stable")
        return ranking.take(order[distinct(ranking.placements[order], self.b.landmarks, self.same_within, KEPT)])

    @property
    def same_within(self) -> float:
        """Working cells within which two placements of the landmarks say the same."""
        return max(SAME_FIT_CELLS, SAME_RADIUS * self.a.radius)

    def _likeliest_beside(
        self, heads: NDArray[np.intp], ranking: Ranking, odds: NDArray[np.float64], apart: float
    ) -> NDArray[np.intp]:
        """Of the placements that say the same as each head, take the likeliest: it is the more exact one.

        How plausible it is that the maps belong there at all, the head tells.
        """
        a, b, tx, ty = ranking.placements.T[:, :, None]
        u, v = self.b.landmarks.T
        at = np.stack([a * u - b * v + tx, b * u + a * v + ty])  # (2, N, landmarks)
        best = []
        for head in heads:
            is_same = np.abs(at - at[:, [head]]).max(axis=(0, 2)) < apart
            is_same &= odds >= odds[head] - NEARLY_AS_PLAUSIBLE
            best.append(np.argmax(np.where(is_same, ranking.likelihood, -np.inf)))
        return np.array(best, np.intp)

    def _likelihoods(self, placements: NDArray[np.float64], overlaps: NDArray[np.float64]) -> NDArray[np.float64]:
        scores = np.array([self._judge(noise).score(placements) for noise in JUDGED_NOISES])  # (K, N)
        rigid, loose = scores[0] * overlaps**DAMPING_RIGID, scores[1:].max(axis=0) * overlaps**DAMPING_LOOSE
        likelihoods: NDArray[np.float64] = np.maximum(rigid, loose)
        best = np.argsort(-likelihoods, kind="stable")[:BENT_FITS]
        bent = self._judge(BENDING_NOISE).score_bent(placements[best]) * overlaps[best] ** DAMPING_LOOSE
        likelihoods[best] = np.maximum(likelihoods[best], bent)
        return likelihoods

    def _screen(self, judge: WallLikelihood, hypotheses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Keep the distinct hypotheses under which a sample of the walls agrees best."""
        for points, most in zip(SCREEN_POINTS, (self.screened, len(hypotheses)), strict=True):
            hypotheses = _best(hypotheses, judge.score(hypotheses, most_points=points), most)
        return self._distinct(hypotheses, SAME_CELLS, self.refined)

    def _refined(self, judge: WallLikelihood, hypotheses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Refine the hypotheses, half of them all the way, and keep the best, distinct ones."""
        fits = self._fit(hypotheses, SEARCH_POINTS, BROAD)
        fits = _best(fits, judge.score(fits), len(fits) // 2 + 1)
        fits = self._fit(fits, SEARCH_POINTS, FINE)
        fits = _best(fits, judge.score(fits), len(fits))
        return self._distinct(fits, SAME_FIT_CELLS, FITS)

    def _best_shifts(
        self, pairs: Sequence[tuple[WallFaces, WallFaces]], scales: NDArray[np.float64], most: int, refined: int
    ) -> NDArray[np.float64]:
        """Correlate maps in pairs of frames, and refine the best, distinct placements."""
        found = [correlate(on_a, on_b, scales, most=most) for on_a, on_b in pairs]
        placements, gains = (np.concatenate(parts) for parts in zip(*found, strict=True))
        best = self._distinct(_best(placements, gains, len(gains)), SAME_CELLS, refined)
        return self._fit(best, SEARCH_POINTS, NARROW)

    def _distinct(self, placements: NDArray[np.float64], apart: float, most: int) -> NDArray[np.float64]:
        kept: NDArray[np.float64] = placements[distinct(placements, self.b.landmarks, apart, most)]
        return kept

    def _judge(self, noise: WallNoise) -> WallLikelihood:
        return WallLikelihood(self.a, self.b, self.walls_a, self.walls_b, noise)

    def _fit(self, placements: NDArray[np.float64], points: int, reaches: tuple[float, ...]) -> NDArray[np.float64]:
        walls = self.walls_a[:points], self.walls_b[:points]
        return refine(placements, self.a, self.b, walls, reaches, self.scale_bounds)


def _best(placements: NDArray[np.float64], scores: NDArray[np.float64], most: int) -> NDArray[np.float64]:
    """Order placements by score, best first, and keep the first ones."""
    best: NDArray[np.float64] = placements[np.argsort(-scores, kind="stable")[:most]]
    return best
