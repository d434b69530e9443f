"""Arrangement of components that no join decides: a beam over whole placements of them all.

In rows of equal rooms a join next door fits nearly as well, and components that are joined best first stay apart. All
pairs at once can tell: the right arrangement is often the only one that most of them agree with.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rectmerge.fleet.complex_similarity import ComplexSimilarity, rms
from rectmerge.fleet.cuts import reached
from rectmerge.fleet.evidence import Evidence, Pair
from rectmerge.fleet.join_scorer import JoinScorer
from rectmerge.fleet.params import FleetParams

Members = tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Arrangement:
    """Components in the frame of one of them.

    Parameters
    ----------
    placements
        Placement of each component, the one whose frame it is first.
    nats
        What all asked pairs of maps give to it, less the chances of a false edge.
    """

    placements: Mapping[Members, ComplexSimilarity]
    nats: float


@dataclass(frozen=True, slots=True, eq=False)
class Arranger:
    """Arranger of components.

    Parameters
    ----------
    evidence
        Evidence of the asked pairs.
    poses
        Pose of each map in the frame of its component.
    params
        Parameters of all stages.
    """

    evidence: Evidence
    poses: Sequence[ComplexSimilarity]
    params: FleetParams

    def arrangements(self, components: Sequence[Members]) -> list[Arrangement]:
        """List probable arrangements of all components in the frame of the first, the best first.

        None where no arrangement of them can be probable enough to be taken.
        """
        if self._most(components) < self.params.join.accept_log_odds:
            return []
        level = [Arrangement({components[0]: ComplexSimilarity()}, sum(map(self._inside, components)))]
        for _ in components[1:]:
            longer = [one for each in level for other in components for one in self._with(each, other)]
            longer.sort(key=lambda one: -one.nats)
            level = []
            for one in longer:
                if len(level) == self.params.arrange.beam:
                    break
                if not any(self._is_same(one, other) for other in level):
                    level.append(one)
        return level

    def log_odds(self, found: Sequence[Arrangement]) -> float:
        """Return the log-odds of the first of some arrangements against all others, and against none.

        It has to lead by a margin: fits of like rooms differ by chance.
        """
        if not found:
            return -math.inf
        best, *others = (one.nats for one in found)
        rivals = float(np.logaddexp.reduce([-math.inf, *others]))
        return min(best, best - rivals - self.params.arrange.margin)

    def unasked(self, arrangement: Arrangement) -> list[Pair]:
        """List the pairs that nobody asked and that an arrangement lays on each other."""
        poses = {
            index: placement @ self.poses[index]
            for members, placement in arrangement.placements.items()
            for index in members
        }
        pairs = [pair for pair in itertools.combinations(sorted(poses), 2) if not self.evidence.is_asked(pair)]
        least = self.params.join.implied_overlap
        return [
            pair for pair in pairs if self.evidence.overlap(pair, poses[pair[0]].inverse() @ poses[pair[1]]) >= least
        ]

    def _most(self, components: Sequence[Members]) -> float:
        """Return no less than the nats of any arrangement: every pair gives its best candidate's at most, or none."""
        maps = [index for members in components for index in members]
        candidates = (self.evidence.candidates[pair] for pair in self.evidence.between(maps, maps))
        return sum(max((one.alone for one in each if one.alone > 0), default=0.0) for each in candidates)

    def _inside(self, members: Members) -> float:
        """Return the nats of a component as it is."""
        pairs = self.evidence.between(members, members)
        return self._scorer(self.poses).nats_of(ComplexSimilarity(), pairs, frozenset(members))

    def _with(self, arrangement: Arrangement, members: Members) -> list[Arrangement]:
        """List the arrangements that have one more component, wherever a candidate proposes it."""
        if members in arrangement.placements:
            return []
        poses = list(self.poses)
        for placed, placement in arrangement.placements.items():
            for index in placed:
                poses[index] = placement @ poses[index]
        left = [index for placed in arrangement.placements for index in placed]
        pairs, scorer = self.evidence.between(left, members), self._scorer(poses)
        known = arrangement.nats - math.log(len(left) * len(members))
        return [
            Arrangement(
                {**arrangement.placements, members: placement},
                known + scorer.nats_of(placement, pairs, frozenset(left)),
            )
            for placement in scorer.proposals(left, members, pairs)
        ]

    def _scorer(self, poses: Sequence[ComplexSimilarity]) -> JoinScorer:
        return JoinScorer(self.evidence, poses, self.params)

    def _is_same(self, one: Arrangement, other: Arrangement) -> bool:
        return one.placements.keys() == other.placements.keys() and all(
            self._is_near(members, placement, other.placements[members])
            for members, placement in one.placements.items()
        )

    def _is_near(self, members: Members, one: ComplexSimilarity, other: ComplexSimilarity) -> bool:
        """Return whether two placements of a component are the same, within the tolerance of an agreement."""
        maps, evidence = self.evidence.maps, self.params.evidence
        marks = np.concatenate([self.poses[index].apply(maps[index].landmarks) for index in members])
        extent = one.scale * max(self.poses[index].scale * maps[index].diagonal for index in members)
        return rms(one.apply(marks) - other.apply(marks)) <= evidence.max_sigmas * evidence.tolerance * extent


def repeated_groups(components: Sequence[Members], repeated: Collection[Pair]) -> list[list[Members]]:
    """Group components that are connected by pairs of a place that repeats itself, two or more, the largest first."""
    edges = [*repeated, *((members[0], index) for members in components for index in members)]
    groups: list[list[Members]] = []
    for members in sorted(components, key=lambda one: (-len(one), one)):
        if not any(members in group for group in groups):
            near = reached(members, edges)
            groups.append([other for other in components if other[0] in near])
    return [sorted(group, key=lambda one: (-len(one), one)) for group in groups if len(group) > 1]
