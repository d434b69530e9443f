"""Joint inference: components of maps are joined best first, by the evidence of all pairs that a join lays together.

A join is proposed by any candidate of any pair between two components. Its evidence is the support of all asked pairs
between them, against that of every other proposal and against none; cycles that close settle ambiguous pairs, and those
that do not throw out wrong ones. Before a join, the pairs that it would lay on each other are asked: a pair not asked
is no evidence.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from rectmerge.fleet.arranging import Arranger, repeated_groups
from rectmerge.fleet.complex_similarity import ComplexSimilarity
from rectmerge.fleet.cuts import weak_cuts
from rectmerge.fleet.evidence import Evidence, Pair, relative
from rectmerge.fleet.join_scorer import Join, JoinScorer
from rectmerge.fleet.params import FleetParams
from rectmerge.fleet.placing import place

Ask = Callable[[Sequence[Pair]], int]  # asks pairs, and returns how many it could


class Joining:
    """Components of maps and their poses, joined while the evidence allows.

    Parameters
    ----------
    evidence
        Evidence of the asked pairs; asking adds to it.
    ask
        Asks pairs of maps.
    params
        Parameters of all stages.
    start
        Poses of maps that are together from the beginning, by component; they keep their places to each other.
    """

    def __init__(
        self, evidence: Evidence, ask: Ask, params: FleetParams, start: Sequence[Mapping[int, ComplexSimilarity]] = ()
    ) -> None:
        count = len(evidence.maps)
        self.evidence = evidence
        self.params = params
        self.members: dict[int, tuple[int, ...]] = {index: (index,) for index in range(count)}  # by their first map
        self.poses = [ComplexSimilarity()] * count
        self.joins: list[Join] = []
        self._scorer = JoinScorer(evidence, self.poses, params)
        self._ask = ask
        self._root = list(range(count))
        self._offers: dict[Pair, Join | None] = {}
        self._undone: set[tuple[tuple[int, ...], tuple[int, ...]]] = set()
        self._held = {index for poses in start for index in poses}
        self._arranged: dict[tuple[int, ...], float] = {}  # log-odds by the maps that were arranged together
        for poses in start:
            for index, pose in poses.items():
                del self.members[index]
                self.poses[index] = pose
            self._gather(tuple(sorted(poses)))

    def run(self) -> None:
        """Join components until no join is probable enough, and refine the placements of each.

        Where nothing is sure, likely joins are made on trial. In the end a component is cut wherever all its pairs
        together leave a cut improbable, and what is cut off may join elsewhere.
        """
        params = self.params.join
        for _ in range(len(self.poses)):
            self._join_while(params.accept_log_odds)
            self._join_while(params.trial_log_odds)
            if not self._reconsider_all():
                break
        else:
            while self._reconsider_all(is_cut_only=True):
                pass
        for group in repeated_groups(list(self.members.values()), self.evidence.repeated):
            maps = {index for members in group for index in members}
            if self._held.isdisjoint(maps) and len(maps) <= self.params.arrange.most_maps:
                self._arrange(group)
        for members in self.members.values():
            for _ in range(self.params.place.passes):
                self._refine(members)

    def _join_while(self, least: float) -> None:
        """Join components as long as a join has some log-odds."""
        while (best := self._best_offer(least)) is not None:
            if implied := self._implied(best):
                if self._ask(implied) == 0:  # the budget is spent: no join on pairs that nobody asked
                    self._offers[best.left[0], best.right[0]] = None
                else:
                    self._forget(best.left[0], best.right[0])
                continue
            self._make(best)

    def _arrange(self, group: Sequence[tuple[int, ...]]) -> None:
        """Join components of a place that repeats itself, which no join decides, if all their pairs at once do."""
        arranger = Arranger(self.evidence, self.poses, self.params)
        found = arranger.arrangements(group)
        while found and self._ask(arranger.unasked(found[0])):
            found = arranger.arrangements(group)
        odds = arranger.log_odds(found)
        if odds < self.params.join.accept_log_odds:
            return
        together = group[0]
        for members, placement in list(found[0].placements.items())[1:]:
            self._make(Join(together, members, placement, odds, ()), is_refined=False)
            together = tuple(sorted(together + members))
        self._arranged[together] = odds

    def _reconsider_all(self, *, is_cut_only: bool = False) -> bool:
        """Reconsider every component once; return whether one has changed."""
        changes = [self._reconsider(members, is_cut_only) for members in list(self.members.values())]
        return any(changes)

    def _reconsider(self, members: Sequence[int], is_cut_only: bool) -> bool:
        """Cut a component where its pairs leave a cut improbable or fit better elsewhere; return whether it was cut."""
        if len(members) == 1 or self.members.get(members[0]) != members or not self._held.isdisjoint(members):
            return False
        edges = [edge.pair for edge in self.evidence.agreeing(members, self.poses)]
        cuts = [*weak_cuts(members, edges, members[0]), (members[0],)]
        odds = [self._scorer.cut_log_odds([index for index in members if index not in side], side) for side in cuts]
        weakest = odds.index(min(odds))
        if odds[weakest] < self.params.join.accept_log_odds:
            self._cut(members, cuts[weakest])
            return True
        if is_cut_only:
            return False
        offers = [self._offer_elsewhere(side, members) for side in cuts]
        gains = [(0.0 if offer is None else offer.log_odds - own) for offer, own in zip(offers, odds, strict=True)]
        best = gains.index(max(gains))
        offer = offers[best]
        if offer is None or gains[best] < self.params.join.move_margin:
            return False
        self._cut(members, cuts[best])
        self._make(offer)
        return True

    def _offer_elsewhere(self, side: Sequence[int], members: Sequence[int]) -> Join | None:
        """Return the most probable join of a part of a component with another component."""
        offers = [
            self._scorer.offer(other, side, pairs)
            for other in self.members.values()
            if other != members and (pairs := self.evidence.between(other, side))
        ]
        return max((offer for offer in offers if offer is not None), key=lambda offer: offer.log_odds, default=None)

    def _cut(self, members: Sequence[int], side: Sequence[int]) -> None:
        """Part a component in two; the same join is not made on trial again."""
        parts = tuple(index for index in members if index not in side), tuple(side)
        del self.members[members[0]]
        self._forget(members[0])
        self._undone.add(parts)
        for part in parts:
            self._gather(part)

    def total(self) -> float:
        """Return the nats that all asked pairs give to the components as they are."""
        nats = 0.0
        for pair in self.evidence.candidates:
            if self._root[pair[0]] == self._root[pair[1]]:
                support = self.evidence.support(pair, relative(self.poses, pair))
                nats += support.nats - (0.0 if support.candidate is None else support.candidate.bonus)
        return nats

    def cut_log_odds(self, left: Sequence[int], right: Sequence[int]) -> float:
        """Return the log-odds that two parts of a component lie right to each other; see `JoinScorer`.

        Of an arrangement they are no less than its own.
        """
        arranged = self._arranged.get(tuple(sorted([*left, *right])), -math.inf)
        return max(arranged, self._scorer.cut_log_odds(left, right))

    def take(self, pair: Pair) -> None:
        """Join two maps by the best candidate of their pair, whatever else is known."""
        best = self.evidence.candidates[pair][0]
        self._make(Join((pair[0],), (pair[1],), best.placement, math.inf, (best,)))

    def _best_offer(self, least: float) -> Join | None:
        """Return the most probable join of two components; None where none has so much log-odds."""
        between: dict[Pair, list[Pair]] = {}
        for first, second in sorted(self.evidence.candidates):
            roots = sorted((self._root[first], self._root[second]))
            if roots[0] != roots[1]:
                between.setdefault((roots[0], roots[1]), []).append((first, second))
        best = None
        for key, pairs in sorted(between.items()):
            if key not in self._offers:
                self._offers[key] = self._offer(self.members[key[0]], self.members[key[1]], pairs)
            offer = self._offers[key]
            if offer is None or self._is_undone(offer):
                continue
            if best is None or offer.log_odds > best.log_odds:
                best = offer
        return best if best is not None and best.log_odds >= least else None

    def _is_undone(self, offer: Join) -> bool:
        """Return whether a trial join was undone before."""
        is_trial = offer.log_odds < self.params.join.accept_log_odds
        return is_trial and not self._undone.isdisjoint({(offer.left, offer.right), (offer.right, offer.left)})

    def _implied(self, join: Join) -> list[Pair]:
        """List the pairs to ask before a join: those that it lays on each other, the largest overlap first."""
        params = self.params.join
        is_single = min(len(join.left), len(join.right)) == 1
        if is_single and len(join.agreeing) >= params.enough_agreeing:
            return []
        implied = []
        for i in join.left:
            for j in join.right:
                pair = (min(i, j), max(i, j))
                if not self.evidence.is_asked(pair):
                    on_left = self.poses[i].inverse() @ join.placement @ self.poses[j]
                    share = self.evidence.overlap(pair, on_left if i < j else on_left.inverse())
                    if share >= params.implied_overlap:
                        implied.append((-share, pair))
        return [pair for _, pair in sorted(implied)[: params.asked_at_once]]

    def _offer(self, left: Sequence[int], right: Sequence[int], pairs: Sequence[Pair]) -> Join | None:
        """Return the most probable join of two parts, once the walls were asked where few pairs speak for it.

        They are asked about its rivals too: a sure but wrong pair does not outvote several that agree.
        """
        offer = self._scorer.offer(left, right, pairs)
        while offer is not None and offer.unrivalled >= self.params.join.trial_log_odds and self._measure(offer, pairs):
            offer = self._scorer.offer(left, right, pairs)
        return offer

    def _measure(self, join: Join, pairs: Sequence[Pair]) -> bool:
        """Ask the walls about a join and its rivals, where few pairs speak for them; return whether anything is new."""
        is_new = False
        is_single = len(join.agreeing) <= self.params.join.few_agreeing
        for placement in (*([join.placement] if is_single else ()), *join.rivals):
            for pair in pairs:
                first, second = (
                    self.poses[index] if index in join.left else placement @ self.poses[index] for index in pair
                )
                place = first.inverse() @ second
                is_laid = self.evidence.overlap(pair, place) >= self.params.join.implied_overlap
                if (is_laid or self.evidence.agrees(pair, place)) and not self.evidence.is_measured(pair, place):
                    self.evidence.measure(pair, place)
                    is_new = True
        return is_new

    def _make(self, join: Join, *, is_refined: bool = True) -> None:
        """Join two components."""
        together = tuple(sorted(join.left + join.right))
        for index in join.right:
            self.poses[index] = join.placement @ self.poses[index]
        del self.members[join.left[0]], self.members[join.right[0]]
        self._forget(join.left[0], join.right[0])
        self._gather(together)
        self.joins.append(join)
        if is_refined and len(together) > 2:
            self._refine(together)

    def _gather(self, members: tuple[int, ...]) -> None:
        """Make a component of some maps, which are in none."""
        self.members[members[0]] = members
        for index in members:
            self._root[index] = members[0]

    def _forget(self, *roots: int) -> None:
        """Drop the offers between changed components and others."""
        for key in [key for key in self._offers if not set(roots).isdisjoint(key)]:
            del self._offers[key]

    def _refine(self, members: Sequence[int]) -> None:
        edges = self.evidence.agreeing(members, self.poses)
        held = self._held.intersection(members) or {members[0]}
        refined = place(self.evidence.maps, self.poses, edges, held, self.params.place) if edges else {}
        for index, pose in refined.items():
            self.poses[index] = pose
