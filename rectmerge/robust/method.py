"""The method `robust`: rectangles propose, walls judge, the cells of the given maps make it exact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rectmerge.alignment import Alignment, Verdict
from rectmerge.grid import OccupancyGrid
from rectmerge.hints import Guess, Hint
from rectmerge.robust import reasons
from rectmerge.robust.certificate import ScoreCertificate, certify
from rectmerge.robust.exact import Answer, make_exact
from rectmerge.robust.outside import without_outside
from rectmerge.robust.params import Params
from rectmerge.robust.prepared_map import PreparedMap
from rectmerge.robust.search import Search, search
from rectmerge.robust.steering import steer
from rectmerge.robust.verdict import judge
from rectmerge.robust.working_pair import WorkingPair
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True, kw_only=True)
class Robust(Params):
    """Align by rectangles and walls, with a probability, or refuse with a reason.

    Every pair of maximal empty rectangles that could be the same room, in four quarter turns, proposes a placement;
    where these do not convince, so does every shift, correlated at every scale. Each is scored by the walls, face by
    face: the faces that match a face of the other map with the same normal, and the walls where the other map is free.
    The best has to hold against every shift and quarter turn at its own scale, and, unless it is sure, against the
    mirror image; it is accepted if it is then the one probable answer, and made exact on the cells of the given maps.
    Where nothing is accepted and one map is white around its building, its outside is taken as unknown instead.

    The parameters are those of `rectmerge.robust.params.Params`.
    """

    @property
    def name(self) -> str:
        """The name people type."""
        return "robust"

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        """Place B on A; `scale` bounds the pixel scale (cells of A per cell of B)."""
        return self.align_by(None, a, b, scale=scale, rng=rng)

    def align_by(
        self,
        hint: Hint | None,
        a: OccupancyGrid,
        b: OccupancyGrid,
        *,
        scale: tuple[float, float],
        rng: np.random.Generator,
    ) -> Alignment:
        """Place B on A as `align` does, with a hint about the placement."""
        alignment = self._align(hint, a, b, scale=scale, rng=rng)
        if alignment:
            return alignment
        inside = without_outside(a, self.outside), without_outside(b, self.outside)
        whites = [name for name, map_, whole in zip("AB", inside, (a, b), strict=True) if map_ is not whole]
        if len(whites) != 1:  # two white outsides agree, as two unknown ones do
            return alignment
        again = self._align(hint, *inside, scale=scale, rng=rng)
        # two searches are two chances of a wrong answer: each gets half of the risk
        is_sure = again and (again.confidence or 0.0) >= (1 + self.verdict.accept_at) / 2
        return replace(again, reason=reasons.without_outside(again.reason, whites[0])) if is_sure else alignment

    def _align(
        self,
        hint: Hint | None,
        a: OccupancyGrid,
        b: OccupancyGrid,
        *,
        scale: tuple[float, float],
        rng: np.random.Generator,
    ) -> Alignment:
        # prepare both maps
        maps = PreparedMap.from_grid(a, self), PreparedMap.from_grid(b, self)
        if missing := self._missing_walls(maps):
            return self._rejected(missing, maps)
        # the richer map stays and the other moves, so that the answer for (b, a) is the inverse of that for (a, b)
        is_swapped = maps[1].rank > maps[0].rank
        fixed, moving = maps[::-1] if is_swapped else maps
        bounds = (1 / scale[1], 1 / scale[0]) if is_swapped else scale
        # propose placements, and challenge the best by its rivals
        pair = WorkingPair.from_maps(fixed, moving, bounds, rng, self)
        result = search(pair, fixed, moving)
        ranking = result.ranking if hint is None else steer(hint, pair, result.ranking, (a, b), is_swapped=is_swapped)
        if len(ranking) == 0:
            return self._rejected("no placement of one map on the other at a scale within bounds", maps)
        # make the placements exact
        answers, is_mirrored = make_exact(pair, ranking, fixed, moving, bounds), False
        if not (answers[0].evidence.is_sure or isinstance(hint, Guess)):
            answers, is_mirrored = self._challenge_by_mirror(answers, result, fixed, moving, bounds, rng)
        answers = [answers[0].unbent(fixed.grid, moving.grid), *answers[1:]]
        # decide
        verdict, reason = self._decide(answers[0], is_mirrored, maps)
        better_from = answers[0].evidence.plausibility + self.hint.better_by
        if verdict != "accepted" and hint is not None and result.ranking.best > better_from:
            reason = reasons.better_elsewhere(hint)
        candidates = tuple(answer.candidate(a, b, is_swapped=is_swapped) for answer in answers)
        return Alignment(
            verdict=verdict,
            reason=reason,
            method=self.name,
            candidates=candidates,
            confidence=candidates[0].confidence,
            quality=_quality(maps),
        )

    def certify(
        self,
        a: OccupancyGrid,
        b: OccupancyGrid,
        pixels: Similarity,
        *,
        scale: tuple[float, float],
        seconds: float,
    ) -> ScoreCertificate:
        """Certify an accepted placement; see `rectmerge.robust.certificate.certify`."""
        return certify(a, b, pixels, scale=scale, seconds=seconds, params=self)

    def _challenge_by_mirror(
        self,
        answers: Sequence[Answer],
        result: Search,
        fixed: PreparedMap,
        moving: PreparedMap,
        scale: tuple[float, float],
        rng: np.random.Generator,
    ) -> tuple[Sequence[Answer], bool]:
        """Take the mirror image's best placement as a rival; say whether the maps are mirrored.

        The mirror image is searched as far as the maps were, where the best answer might be accepted.
        """
        best = answers[0].evidence
        flipped = moving.mirrored
        is_full_allowed = result.is_full and best.probability >= best.asked
        pair = WorkingPair.from_maps(fixed, flipped, scale, rng, self)
        mirror = search(pair, fixed, flipped, is_full_allowed=is_full_allowed)
        if len(mirror.ranking) == 0:
            return answers, False
        log_odds = mirror.ranking.best
        is_better = log_odds > max(result.ranking.best, best.plausibility) + self.verdict.mirrored_by
        return [answer.beside_mirror(log_odds) for answer in answers], mirror.convinces and is_better

    def _decide(self, best: Answer, is_mirrored: bool, maps: tuple[PreparedMap, PreparedMap]) -> tuple[Verdict, str]:
        if is_mirrored:
            return "rejected", "the maps fit when one is mirrored: is one image flipped?"
        verdict = judge(best.evidence)
        if verdict == "accepted":
            return verdict, reasons.accepted(best.evidence, best.agreement, self.reason)
        facts = {name: map_.facts for name, map_ in zip("AB", maps, strict=True)}
        return verdict, reasons.not_accepted(verdict, best.evidence, best.agreement, facts, self.reason)

    def _missing_walls(self, maps: tuple[PreparedMap, PreparedMap]) -> str | None:
        for name, map_ in zip("AB", maps, strict=True):
            if map_.features is None:
                return reasons.no_wall(name, int(np.count_nonzero(map_.grid.free)), self.reason)
        return None

    def _rejected(self, reason: str, maps: tuple[PreparedMap, PreparedMap]) -> Alignment:
        return Alignment(verdict="rejected", reason=reason, method=self.name, quality=_quality(maps))


def _quality(maps: tuple[PreparedMap, PreparedMap]) -> dict[str, dict[str, float]]:
    return {name: map_.quality.as_dict() for name, map_ in zip("ab", maps, strict=True)}
