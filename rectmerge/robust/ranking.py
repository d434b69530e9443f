"""Ranking of placements by their plausibility as rigid and as bent maps."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rectmerge.robust import wall_agreement
from rectmerge.robust.confidence_model import bent_odds, plausibility, rigid_odds
from rectmerge.robust.likelihood import WallNoise
from rectmerge.robust.wall_agreement import Agreements
from rectmerge.robust.working_pair import WorkingPair


@dataclass(frozen=True, kw_only=True, eq=False)
class Ranking:
    """N distinct placements between working grids, most plausible first, with the log-odds and measures of each.

    Parameters
    ----------
    placements
        Shape (N, 4), rows (a, b, tx, ty).
    agreement
        Agreement of the walls, N each.
    likelihood, support
        Shape (N,): log-likelihood ratio of the walls, damped by a power of the overlap, and per wall point of the map
        that has fewer.
    rigid, bent
        Shape (N,): log-odds that a placement is right, were there no other, if the maps are rigid and if they are bent.
    plausibility
        Shape (N,): both together.
    """

    placements: NDArray[np.float64]
    agreement: Agreements
    likelihood: NDArray[np.float64]
    support: NDArray[np.float64]
    rigid: NDArray[np.float64]
    bent: NDArray[np.float64]
    plausibility: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.placements)

    @property
    def best(self) -> float:
        """Highest plausibility, minus infinity where there is no placement."""
        return float(self.plausibility[0]) if len(self) else -math.inf

    def take(self, indices: NDArray[np.intp]) -> Ranking:
        """Return some of the placements, in this order."""
        return Ranking(
            placements=self.placements[indices],
            agreement=wall_agreement.take(self.agreement, indices),
            likelihood=self.likelihood[indices],
            support=self.support[indices],
            rigid=self.rigid[indices],
            bent=self.bent[indices],
            plausibility=self.plausibility[indices],
        )

    def concat(self, other: Ranking) -> Ranking:
        """Return the placements of both, those of this one first."""
        return Ranking(
            placements=np.concatenate([self.placements, other.placements]),
            agreement=wall_agreement.concat(self.agreement, other.agreement),
            likelihood=np.concatenate([self.likelihood, other.likelihood]),
            support=np.concatenate([self.support, other.support]),
            rigid=np.concatenate([self.rigid, other.rigid]),
            bent=np.concatenate([self.bent, other.bent]),
            plausibility=np.concatenate([self.plausibility, other.plausibility]),
        )


def rank(pair: WorkingPair, fits: NDArray[np.float64]) -> Ranking:
    """Give each fit, shape (N, 4), its most plausible form, as rigid or bent maps, and rank them."""
    params, confidence = pair.params.rank, pair.params.confidence
    reaches = params.rigid_reaches_cells, params.bent_reaches_cells
    forms = np.concatenate([fits, *(pair.fit(fits, params.refine_points, cells) for cells in reaches)])
    agreement = pair.scorer.score(forms)
    likelihood = _likelihoods(pair, forms, agreement.overlap)
    support = likelihood / min(len(pair.walls_a), len(pair.walls_b))
    rigid = rigid_odds(agreement, confidence)
    bent = bent_odds(agreement, support, confidence) + pair.handicap
    ranking = Ranking(
        placements=forms,
        agreement=agreement,
        likelihood=likelihood,
        support=support,
        rigid=rigid,
        bent=bent,
        plausibility=np.logaddexp(rigid, bent),
    )
    return rerank(pair, ranking)


def rerank(pair: WorkingPair, ranking: Ranking) -> Ranking:
    """Order scored placements, most plausible first, and keep the distinct ones."""
    odds = np.logaddexp(ranking.rigid, ranking.bent)
    order = np.argsort(-odds, kind="stable")
    apart = _same_within(pair)
    heads = order[pair.distinct(ranking.placements[order], apart, pair.params.rank.max_ranked)]
    likeliest = ranking.take(_likeliest_beside(pair, heads, ranking, odds, apart))
    kept = replace(likeliest, rigid=ranking.rigid[heads], bent=ranking.bent[heads])
    scored = replace(kept, plausibility=plausibility(kept.rigid, kept.bent))
    return best_distinct(pair, scored)  # two heads may have had the same placement between them


def best_distinct(pair: WorkingPair, ranking: Ranking) -> Ranking:
    """Order placements, most plausible first, and leave out each that is the same as one before it."""
    order = np.argsort(-ranking.plausibility, kind="stable")
    return ranking.take(
        order[pair.distinct(ranking.placements[order], _same_within(pair), pair.params.rank.max_ranked)]
    )


def _same_within(pair: WorkingPair) -> float:
    """Return the distance of the landmarks, in working cells, within which two placements are the same."""
    params = pair.params.rank
    return max(params.same_fit_cells, params.same_radius_share * pair.a.radius)


def _likeliest_beside(
    pair: WorkingPair, heads: NDArray[np.intp], ranking: Ranking, odds: NDArray[np.float64], apart: float
) -> NDArray[np.intp]:
    """Return the likeliest of the placements that are the same as each head: it is the more exact one.

    The log-odds are those of the head.
    """
    a, b, tx, ty = ranking.placements.T[:, :, None]
    u, v = pair.b.landmarks.T
    at = np.stack([a * u - b * v + tx, b * u + a * v + ty])  # (2, N, landmarks)
    best = []
    for head in heads:
        is_same = np.abs(at - at[:, [head]]).max(axis=(0, 2)) < apart
        is_same &= odds >= odds[head] - pair.params.rank.same_log_odds
        best.append(np.argmax(np.where(is_same, ranking.likelihood, -np.inf)))
    return np.array(best, np.intp)


def _likelihoods(
    pair: WorkingPair, placements: NDArray[np.float64], overlaps: NDArray[np.float64]
) -> NDArray[np.float64]:
    params = pair.params.rank
    noises = [WallNoise((spread,), share) for spread, share in zip(params.spreads_cells, params.outliers, strict=True)]
    scores = np.array([pair.likelihood(noise).score(placements) for noise in noises])  # (K, N)
    rigid = scores[0] * overlaps**params.rigid_damping
    loose = scores[1:].max(axis=0) * overlaps**params.loose_damping
    likelihoods: NDArray[np.float64] = np.maximum(rigid, loose)
    best = np.argsort(-likelihoods, kind="stable")[: params.max_bent_fits]
    bending = pair.likelihood(WallNoise((params.bending_spread_cells,), params.bending_outliers))
    bent = bending.score_bent(placements[best], params) * overlaps[best] ** params.loose_damping
    likelihoods[best] = np.maximum(likelihoods[best], bent)
    return likelihoods
