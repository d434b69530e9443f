"""Evidence of all asked pairs: the log-odds of their candidates, and their support for a joint placement."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rectmerge.aligning import DOUBTED
from rectmerge.alignment import Alignment, Candidate
from rectmerge.fleet.complex_similarity import ComplexSimilarity, Points, rms
from rectmerge.fleet.map_sample import MapSample, overlap
from rectmerge.fleet.params import EvidenceParams
from rectmerge.robust.confidence_model import RIGID_TERMS
from rectmerge.robust.params import ConfidenceParams, VerdictParams
from rectmerge.robust.verdict import calibrated_log_odds

Pair = tuple[int, int]  # indices of two maps, the smaller first
Witness = Callable[[Pair, ComplexSimilarity], float]  # log-odds of a placement of a pair by walls, without a search
CROSS = np.array([0, 1, 1j, -1, -1j], np.complex128)
MIN_SHARED_POINTS = 5
MIN_RADIUS_CELLS = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class PairCandidate:
    """Candidate of a pair as evidence.

    Parameters
    ----------
    pair
        Indices of the two maps.
    rank
        Of the candidate among those of its pair, from 0.
    placement
        From the second map's pixels to the first's.
    alone
        Log-odds against no placement where nothing else speaks for it.
    bonus
        What it gains where another pair says so too.
    overlap
        Of the two maps under it.
    points, images
        Shape (5,): points of the second map in the shared area, and where they come to lie in the first.
    span
        Diagonal of the smaller map, in cells of the first: the unit of agreement.
    """

    pair: Pair
    rank: int
    placement: ComplexSimilarity
    alone: float
    bonus: float
    overlap: float
    points: Points
    images: Points
    span: float


class Support(NamedTuple):
    """Nats that a pair gives to a placement, and its candidate that agrees with it, if one does."""

    nats: float
    candidate: PairCandidate | None


class Evidence:
    """Candidates of the asked pairs of some maps.

    Parameters
    ----------
    maps
        Samples of the maps; their indices name them.
    params
        Parameters of the log-odds and of agreement.
    witness
        Measures one placement of a pair by the walls.
    """

    def __init__(self, maps: Sequence[MapSample], params: EvidenceParams, witness: Witness) -> None:
        self.maps = maps
        self.params = params
        self._witness = witness
        self._measured: dict[Pair, list[tuple[ComplexSimilarity, float]]] = {}
        self.candidates: dict[Pair, Sequence[PairCandidate]] = {}
        self.repeated: set[Pair] = set()  # of maps of a place that repeats itself
        self._stacks: dict[Pair, _Stack] = {}
        self._mirror: dict[Pair, float] = {}
        self._partners: list[set[int]] = [set() for _ in maps]

    def add(self, pair: Pair, alignment: Alignment, *, is_swapped: bool) -> None:
        """Add the answer of a pair; it places the first map on the second if swapped."""
        candidates = []
        odds, has_bonus = log_odds(alignment, self.params)
        if not has_bonus:
            self.repeated.add(pair)
        first, second = (self.maps[index] for index in pair)
        for rank, (candidate, alone) in enumerate(zip(alignment.candidates, odds, strict=True)):
            placement = ComplexSimilarity.from_similarity(candidate.pixels)
            placement = placement.inverse() if is_swapped else placement
            share, is_common = overlap(first, second, placement)
            points = _spread(second.points[is_common] if is_common.sum() >= MIN_SHARED_POINTS else second.points)
            span = min(first.diagonal, placement.scale * second.diagonal)
            images = placement.apply(points)
            bonus = has_bonus * np.interp(share, self.params.bonus_overlaps, (0.0, self.params.bonus))
            candidates.append(PairCandidate(pair, rank, placement, alone, float(bonus), share, points, images, span))
        self.candidates[pair] = candidates
        self._stacks[pair] = _Stack.of(candidates)
        self._mirror[pair] = max((_mirror(candidate) for candidate in alignment.candidates), default=-math.inf)
        self._partners[pair[0]].add(pair[1])
        self._partners[pair[1]].add(pair[0])

    def is_asked(self, pair: Pair) -> bool:
        """Return whether a pair was asked."""
        return pair in self.candidates

    def between(self, left: Iterable[int], right: Iterable[int]) -> list[Pair]:
        """List the asked pairs of a map on the left with one on the right."""
        ours, theirs = set(left), set(right)
        fewer, more = sorted((ours, theirs), key=len)
        return sorted({(min(i, j), max(i, j)) for i in fewer for j in self._partners[i] & more})

    def overlap(self, pair: Pair, placement: ComplexSimilarity) -> float:
        """Measure the overlap of a pair under a placement of its second map on its first."""
        return overlap(self.maps[pair[0]], self.maps[pair[1]], placement)[0]

    def agrees(self, pair: Pair, placement: ComplexSimilarity) -> bool:
        """Return whether a candidate of an asked pair agrees with a placement."""
        return self._told(pair, placement).candidate is not None

    def is_measured(self, pair: Pair, placement: ComplexSimilarity) -> bool:
        """Return whether the walls were asked about a placement of a pair, or one that is the same."""
        return self._walls_at(pair, placement) is not None

    def measure(self, pair: Pair, placement: ComplexSimilarity) -> None:
        """Ask the walls of both maps about a placement of a pair."""
        nats = _calibrated(self._witness(pair, placement), self._mirror[pair])
        self._measured.setdefault(pair, []).append((placement, nats))

    def support(self, pair: Pair, placement: ComplexSimilarity) -> Support:
        """Return the support of an asked pair for a placement of its second map on its first.

        A candidate that agrees gives its log-odds; where none does, the pair speaks against a placement the more, the
        larger the overlap that its own search should have found. Where the walls were asked they have the last word
        against it: no more is said for a placement than they say.
        """
        support = self._told(pair, placement)
        walls = self._walls_at(pair, placement)
        if walls is None:
            return support
        bonus = 0.0 if support.candidate is None else support.candidate.bonus
        return support._replace(nats=min(support.nats, max(walls, self.params.max_contradiction) + bonus))

    def _walls_at(self, pair: Pair, placement: ComplexSimilarity) -> float | None:
        """Return what the walls say of a placement; None where they were not asked."""
        second = self.maps[pair[1]]
        reach = (
            self.params.max_sigmas
            * self.params.tolerance
            * min(self.maps[pair[0]].diagonal, placement.scale * second.diagonal)
        )
        near = [
            (away, nats)
            for at, nats in self._measured.get(pair, ())
            if (away := rms(at.apply(second.landmarks) - placement.apply(second.landmarks))) < reach
        ]
        return min(near)[1] if near else None

    def _told(self, pair: Pair, placement: ComplexSimilarity) -> Support:
        """Return the support by the answer of a pair alone."""
        params, stack = self.params, self._stacks[pair]
        if len(stack.span):
            sigmas = stack.distances(placement) / params.tolerance
            nats = np.where(sigmas < params.max_sigmas, stack.supported - 0.5 * sigmas**2, -np.inf)
            best = int(np.argmax(nats))
            if nats[best] > params.min_agreement:
                return Support(float(nats[best]), self.candidates[pair][best])
        missed = np.interp(self.overlap(pair, placement), params.miss_overlaps, params.miss_nats)
        return Support(float(missed), None)

    def agreeing(self, members: Iterable[int], poses: Sequence[ComplexSimilarity]) -> list[PairCandidate]:
        """List the candidates that agree with the placements of a component's maps, one a pair at most."""
        inside = set(members)
        agreeing = []
        for pair in sorted(self.candidates):
            if inside.issuperset(pair):
                candidate = self.support(pair, relative(poses, pair)).candidate
                if candidate is not None:
                    agreeing.append(candidate)
        return agreeing


class _Stack(NamedTuple):
    """Candidates of a pair in arrays."""

    points: Points  # (K, 5)
    images: Points  # (K, 5)
    span: NDArray[np.float64]  # (K,)
    supported: NDArray[np.float64]  # (K,)

    @classmethod
    def of(cls, candidates: Sequence[PairCandidate]) -> _Stack:
        empty = np.empty((0, len(CROSS)), np.complex128)
        return cls(
            np.array([one.points for one in candidates]) if candidates else empty,
            np.array([one.images for one in candidates]) if candidates else empty,
            np.array([one.span for one in candidates]),
            np.array([one.alone + one.bonus for one in candidates]),
        )

    def distances(self, placement: ComplexSimilarity) -> NDArray[np.float64]:
        """Return the RMS distance of each candidate from a placement, in spans, shape (K,)."""
        apart = np.abs(self.images - placement.apply(self.points)) ** 2
        distances: NDArray[np.float64] = np.sqrt(apart.mean(axis=1)) / self.span
        return distances


def relative(poses: Sequence[ComplexSimilarity], pair: Pair) -> ComplexSimilarity:
    """Return the placement of a pair's second map on its first, from their poses in one frame."""
    return poses[pair[0]].inverse() @ poses[pair[1]]


def log_odds(alignment: Alignment, params: EvidenceParams) -> tuple[list[float], bool]:
    """Return the log-odds of each candidate of a pair, and whether an agreement with another pair adds a bonus.

    It adds none where the place repeats itself: there an alias of one pair is an alias of the next.
    """
    plausible = [candidate.evidence.get("plausibility", -math.inf) for candidate in alignment.candidates]
    is_doubted = any(candidate.evidence.get(DOUBTED) for candidate in alignment.candidates)
    if not alignment and not is_doubted and sum(nats > params.repeated_log_odds for nats in plausible) >= 2:
        return _repeated(alignment.candidates, params), False
    odds = [_alone(candidate, params) for candidate in alignment.candidates]
    excess = max(0.0, max(odds, default=0.0) - params.max_log_odds)  # the best is capped, and keeps its lead
    return [max(nats - excess, params.min_log_odds) for nats in odds], True


def _alone(candidate: Candidate, params: EvidenceParams) -> float:
    evidence = candidate.evidence
    if "plausibility" in evidence:
        odds = _calibrated(evidence["plausibility"], _mirror(candidate)) + evidence.get("bend_log_odds", 0.0)
    else:
        share = min(max(candidate.confidence, 1e-12), 1 - 1e-12)
        odds = math.log(share / (1 - share))
    if (
        evidence.get(DOUBTED)
        or evidence.get("is_at_limit")
        or evidence.get("slack_cells", 0.0) > params.max_slack_cells
    ):
        odds = min(odds, 0.0)
    return odds


def _mirror(candidate: Candidate) -> float:
    return candidate.evidence.get("mirror_log_odds", -math.inf)


def _calibrated(plausibility: float, mirror: float) -> float:
    """Return the log-odds of a placement against none; its rivals are proposals of their own, so they do not count."""
    return calibrated_log_odds(plausibility, -math.inf, mirror, VerdictParams())


def _repeated(candidates: Sequence[Candidate], params: EvidenceParams) -> list[float]:
    """Return the log-odds of candidates in a place that repeats itself.

    There the walls of an alias fit nearly as well, and whichever lets more walls meet looks more plausible: only the
    quality of the fit counts, so the terms of quantity are taken out of the plausibility. The best is likely by its
    lead over the next: among identical rooms none leads, and where rooms differ a little only the right placement lays
    no wall on solid floor.
    """
    model = ConfidenceParams()
    weights = dict(zip(RIGID_TERMS, model.rigid, strict=True))
    fits = []
    for candidate in candidates:
        found = candidate.evidence
        matched, share = found.get("clutter", 0.0) * found.get("clutter_matched", 0.0), found.get("overlap", 0.0)
        fit = found.get("plausibility", params.min_log_odds)
        fit -= weights["log_clutter_matched"] * math.log(matched + model.min_matched_faces)
        fit -= weights["log_overlap"] * math.log(share + model.min_overlap)
        fits.append(fit - (params.little_overlap_cost if share < params.little_overlap else 0.0))
    best, second = sorted(fits, reverse=True)[:2]
    on_floor = candidates[fits.index(best)].evidence.get("on_floor", 0.0)
    level = params.lead_weight * (best - second - params.even_lead) - params.floor_cost * on_floor
    level = min(max(level, -params.max_lead), params.max_lead)
    return [level + params.fit_weight * (fit - best) for fit in fits]


def _spread(points: Points) -> Points:
    """Return five points spread as some points are: their mean, and a cross around it at their RMS radius."""
    middle = points.mean()
    cross: Points = middle + max(MIN_RADIUS_CELLS, rms(points - middle)) * CROSS
    return cross
