"""Score of joins of two components: all placements that candidates propose, by what all pairs between them say."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from rectmerge.fleet.complex_similarity import ComplexSimilarity, Points, rms
from rectmerge.fleet.evidence import Evidence, Pair, PairCandidate, Support
from rectmerge.fleet.params import FleetParams


@dataclass(frozen=True, slots=True, eq=False)
class Join:
    """Join of two components, offered or made.

    Parameters
    ----------
    left, right
        The maps of both, before the join.
    placement
        From the frame of the right component to that of the left.
    log_odds
        Against every other placement and none.
    agreeing
        Candidates that say so.
    unrivalled
        Log-odds against none alone.
    rivals
        Other placements that candidates speak for and that rest on few pairs.
    """

    left: tuple[int, ...]
    right: tuple[int, ...]
    placement: ComplexSimilarity
    log_odds: float
    agreeing: tuple[PairCandidate, ...]
    unrivalled: float = math.inf
    rivals: tuple[ComplexSimilarity, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class JoinScorer:
    """Scorer of joins.

    Parameters
    ----------
    evidence
        Evidence of the asked pairs.
    poses
        Pose of each map in the frame of its component, as they are at the moment.
    params
        Parameters of all stages.
    """

    evidence: Evidence
    poses: Sequence[ComplexSimilarity]
    params: FleetParams

    def offer(self, left: Sequence[int], right: Sequence[int], pairs: Sequence[Pair]) -> Join | None:
        """Return the best placement of one part on another by the pairs between them, with its odds against others."""
        proposals = self.proposals(left, right, pairs)
        if not proposals:
            return None
        scored = [self._score(placement, pairs, set(left)) for placement in proposals]
        best = max(range(len(scored)), key=lambda index: scored[index][0])
        others = [nats for index, (nats, _) in enumerate(scored) if index != best]
        alone = scored[best][0] - math.log(len(left) * len(right))  # so many chances of a false edge between the two
        few = self.params.join.few_agreeing
        return Join(
            left=tuple(left),
            right=tuple(right),
            placement=proposals[best],
            log_odds=alone - float(np.logaddexp.reduce([0.0, *others])),
            agreeing=scored[best][1],
            unrivalled=alone,
            rivals=tuple(
                proposals[index]
                for index, (nats, agreeing) in enumerate(scored)
                if index != best and nats > 0 and len(agreeing) <= few
            ),
        )

    def cut_log_odds(self, left: Sequence[int], right: Sequence[int]) -> float:
        """Return the log-odds that two parts of a component lie right to each other, by all pairs between them."""
        pairs = self.evidence.between(left, right)
        nats = [
            self._score(placement, pairs, set(left))[0]
            for placement in self.proposals(left, right, pairs, first=ComplexSimilarity())
        ]
        return nats[0] - math.log(len(left) * len(right)) - float(np.logaddexp.reduce([0.0, *nats[1:]]))

    def proposals(
        self,
        left: Sequence[int],
        right: Sequence[int],
        pairs: Sequence[Pair],
        *,
        first: ComplexSimilarity | None = None,
    ) -> list[ComplexSimilarity]:
        """List the distinct placements of the right part on the left that candidates propose, likeliest first.

        A given placement comes first whatever its odds.
        """
        ours = set(left)
        proposed = [] if first is None else [(math.inf, first)]
        for pair in pairs:
            for candidate in self.evidence.candidates[pair]:
                if candidate.alone >= self.params.join.min_proposal:
                    i, j = pair if pair[0] in ours else pair[::-1]
                    on_left = candidate.placement if i < j else candidate.placement.inverse()
                    proposed.append((candidate.alone, self.poses[i] @ on_left @ self.poses[j].inverse()))
        proposed.sort(key=lambda item: -item[0])
        maps, poses, evidence = self.evidence.maps, self.poses, self.params.evidence
        marks = np.concatenate([poses[index].apply(maps[index].landmarks) for index in right])
        extent = max(poses[index].scale * maps[index].diagonal for index in left)
        kept: list[tuple[ComplexSimilarity, Points]] = []
        for _, placement in proposed:
            at = placement.apply(marks)
            if all(rms(at - other) > evidence.max_sigmas * evidence.tolerance * extent for _, other in kept):
                kept.append((placement, at))
            if len(kept) == self.params.join.max_proposals:
                break
        return [placement for placement, _ in kept]

    def _score(
        self, placement: ComplexSimilarity, pairs: Sequence[Pair], left: Collection[int]
    ) -> tuple[float, tuple[PairCandidate, ...]]:
        """Return the nats of a placement of the right component on the left, and the candidates that agree.

        The maps of a component show the same walls, so an alias that fits one of them fits all: agreements bring their
        own odds, but the bonus counts once. And one pair has to be probable by itself.
        """
        supports = self._supports(placement, pairs, left)
        agreeing = tuple(support.candidate for support in supports if support.candidate is not None)
        bonuses = [candidate.bonus for candidate in agreeing]
        total = sum(support.nats for support in supports) - (sum(bonuses) - (max(bonuses) if len(bonuses) > 1 else 0.0))
        if max((candidate.alone for candidate in agreeing), default=-math.inf) < self.params.join.needs:
            total = min(total, 0.0)
        return total, agreeing

    def nats_of(self, placement: ComplexSimilarity, pairs: Sequence[Pair], left: Collection[int]) -> float:
        """Return the nats of a placement of the right component on the left, however few a single pair gives."""
        return sum(
            nats - (0.0 if candidate is None else candidate.bonus)
            for nats, candidate in self._supports(placement, pairs, left)
        )

    def _supports(self, placement: ComplexSimilarity, pairs: Sequence[Pair], left: Collection[int]) -> list[Support]:
        """Return the support of each pair for a placement of the right component on the left."""
        supports = []
        for pair in pairs:
            first, second = (self.poses[index] if index in left else placement @ self.poses[index] for index in pair)
            supports.append(self.evidence.support(pair, first.inverse() @ second))
        return supports
