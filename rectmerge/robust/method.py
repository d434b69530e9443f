"""The method `robust`: rectangles propose, walls judge, the cells of the given maps make it exact."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from rectmerge.alignment import Alignment, Candidate, Certificate, Verdict
from rectmerge.analysis.overlap import Agreement, AgreementMeter
from rectmerge.analysis.quality import measure_quality
from rectmerge.analysis.trinary_map import MapCells, trinary
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.hints import Hint
from rectmerge.robust import reasons
from rectmerge.robust.confidence_model import bent_handicap
from rectmerge.robust.features import (
    QUARTER_TURN_DEG,
    rectangles_in_frame,
)
from rectmerge.robust.prepared_map import PreparedMap
from rectmerge.robust.refinement import RIVAL_POINTS, SURFACE_POINTS, Fit, Surface, fit_surfaces, to_pixels
from rectmerge.robust.search import Ranking, Search
from rectmerge.robust.steering import steer
from rectmerge.robust.verdict import ACCEPT_AT, Evidence, judge, log_odds_of_rest, posterior
from rectmerge.robust.wall_agreement import AgreementScorer
from rectmerge.similarity import Similarity

REFINED_BEYOND = 0.05  # refinement may leave the bounds of the scale by this share
AT_LIMIT = 1e-4  # a scale this close to a widened bound, as a share, was stopped there
WEAK_CONTRAST = 0.6  # a map whose walls pile up less than this in any direction may have none that dominates
ALL_ROUND_STEP_DEG = 5  # between the frames that are tried then
BETTER_BY = 1.0  # log-odds by which another placement than the hinted one is better
MIRRORED_BY = 3.0  # log-odds by which a mirror image fits better before the maps are called mirrored
_Answer = tuple[Fit, Agreement, Evidence]


@dataclass(frozen=True, slots=True, kw_only=True)
class Robust:
    """Align by rectangles and walls; says how sure it is, and no.

    Every pair of maximal empty rectangles that could be the same room, in four quarter turns, proposes a placement;
    where these do not convince, so does every shift, correlated at every scale. Of each the walls judge, face by face:
    what meets a face of the other map that looks the same way, and what lies where the other map is free. The best has
    to hold against every shift and quarter turn at its own scale; it is accepted if it is then the one probable answer,
    and made exact on the cells of the given maps.

    Parameters
    ----------
    rectangles
        Rectangles kept of each map and frame.
    screened
        Hypotheses kept by the first screening.
    refined
        Hypotheses refined.
    candidates
        Candidates reported at the most.

    Raises
    ------
    InputError
        If a parameter is below 1.
    """

    rectangles: int = 120
    screened: int = 1000
    refined: int = 60
    candidates: int = 5

    @property
    def name(self) -> str:
        """The name people type."""
        return "robust"

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            if getattr(self, field.name) < 1:
                raise InputError(f"{field.name} must be >= 1, got {getattr(self, field.name)}")

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
        """Place B on A as `align` does, with what somebody knows of the placement."""
        maps = self._read(a), self._read(b)
        quality = {name: map_.quality.as_dict() for name, map_ in zip("ab", maps, strict=True)}
        for name, map_ in zip("AB", maps, strict=True):
            if map_.features is None:
                reason = reasons.no_wall(name, int(np.count_nonzero(map_.grid.free)))
                return Alignment(verdict="rejected", reason=reason, method=self.name, quality=quality)
        # the richer map stays and the other moves, so that the answer for (b, a) is the inverse of that for (a, b)
        swapped = maps[1].rank > maps[0].rank
        fixed, moving = maps[::-1] if swapped else maps
        bounds = (1 / scale[1], 1 / scale[0]) if swapped else scale
        search, ranking, stage = self._search(fixed, moving, bounds, rng)
        unaided = ranking.best
        if hint is not None:
            ranking = steer(hint, search, ranking, (a, b), is_swapped=swapped)
        if len(ranking) == 0:
            reason = "no placement of one map on the other at a scale within bounds"
            return Alignment(verdict="rejected", reason=reason, method=self.name, quality=quality)
        answers = self._exact(search, ranking, fixed, moving, bounds)
        is_mirrored = False
        if not answers[0][2].is_sure:
            answers, is_mirrored = self._beside_mirror_image(answers, unaided, fixed, moving, bounds, rng, stage)
        verdict, reason = self._verdict(answers[0], is_mirrored, maps)
        if verdict != "accepted" and hint is not None and unaided > answers[0][2].plausibility + BETTER_BY:
            reason = reasons.better_elsewhere(hint)
        candidates = tuple(
            _candidate(fit.inverse() if swapped else fit, agreement, evidence, a, b)
            for fit, agreement, evidence in answers
        )
        return Alignment(
            verdict=verdict,
            reason=reason,
            method=self.name,
            candidates=candidates,
            confidence=candidates[0].confidence,
            quality=quality,
        )

    def certify(
        self, a: OccupancyGrid, b: OccupancyGrid, pixels: Similarity, *, scale: tuple[float, float], seconds: float
    ) -> Certificate:
        """Show that nothing else comes close to a placement; see `rectmerge.robust.certificate.certify`."""
        from rectmerge.robust.certificate import certify

        return certify(a, b, pixels, scale=scale, seconds=seconds)

    def _read(self, grid: OccupancyGrid) -> PreparedMap:
        return PreparedMap.from_grid(grid, MapCells.from_values(trinary(grid)), measure_quality(grid), self.rectangles)

    def _verdict(self, best: _Answer, is_mirrored: bool, maps: tuple[PreparedMap, PreparedMap]) -> tuple[Verdict, str]:
        _, agreement, evidence = best
        verdict = judge(evidence)
        if verdict == "accepted":
            return verdict, reasons.accepted(evidence, agreement)
        if is_mirrored:
            return "rejected", "the maps fit when one is mirrored: is one image flipped?"
        facts = {name: map_.facts for name, map_ in zip("AB", maps, strict=True)}
        return verdict, reasons.not_accepted(verdict, evidence, agreement, facts)

    def _search(
        self,
        fixed: PreparedMap,
        moving: PreparedMap,
        scale: tuple[float, float],
        rng: np.random.Generator,
        last_stage: int = 2,
    ) -> tuple[Search, Ranking, int]:
        """Search by rectangles in the strongest orthogonal frames; where that does not convince, by every shift.

        Whatever the rectangles propose, the best has to hold against every shift and quarter turn at its own scale.
        """
        a, b = fixed.walled, moving.walled
        search = Search(
            a=a,
            b=b,
            walls_a=rng.permutation(a.walls),
            walls_b=rng.permutation(b.walls),
            scale_bounds=_widened((scale[0] * b.factor / a.factor, scale[1] * b.factor / a.factor)),
            angle=fixed.angles[0][0],
            scales=AgreementScorer(a, b, fixed.angles[0][0]),
            handicap=bent_handicap(max(fixed.thickness_cells, moving.thickness_cells)),
            screened=self.screened,
            refined=self.refined,
        )
        ranking = _against_rivals(search, search.rank(search.by_rectangles(fixed.frames, moving.frames)))
        if last_stage == 1 or _convinces(ranking):
            return search, ranking, 1
        fits = [search.by_correlation(fixed.frame_angles, moving.frame_angles)]
        if min(fixed.contrast, moving.contrast) >= WEAK_CONTRAST:
            fits.append(search.by_rectangles(fixed.all_frames(self.rectangles), moving.all_frames(self.rectangles)))
        else:
            angles = np.radians(np.arange(0, QUARTER_TURN_DEG, ALL_ROUND_STEP_DEG))
            all_round = [rectangles_in_frame(b, float(angle), most=self.rectangles) for angle in angles]
            fits.append(search.by_rectangles(fixed.frames[:1], all_round))
        ranking = search.ranked(ranking.concat(search.rank(np.concatenate(fits))))
        return search, _against_rivals(search, ranking), 2

    def _exact(
        self, search: Search, ranking: Ranking, fixed: PreparedMap, moving: PreparedMap, scale: tuple[float, float]
    ) -> list[_Answer]:
        """Make the best placements exact on the maps' own cells, and gather what speaks for each."""
        surfaces = Surface.from_cells(fixed.cells), Surface.from_cells(moving.cells)
        comparison = AgreementMeter(fixed.grid, moving.grid)
        rivals = log_odds_of_rest(ranking.plausibility)
        answers = []
        for i in range(min(self.candidates, len(ranking))):
            placement = to_pixels(ranking.placements[i], search.a, search.b)
            fit = fit_surfaces(placement, *surfaces, _widened(scale), points=RIVAL_POINTS if i else SURFACE_POINTS)
            agreement = comparison.measure(_similarity(fit))
            evidence = Evidence(
                **ranking.at(i),
                rest_log_odds=float(rivals[i]),
                surface_matched=fit.matched,
                conflict=agreement.conflict,
                slack_cells=fit.slack_cells,
                is_at_limit=_is_at_limit(fit, _widened(scale)),
            )
            answers.append((fit, agreement, evidence))
        return answers

    def _beside_mirror_image(
        self,
        answers: list[_Answer],
        unaided: float,
        fixed: PreparedMap,
        moving: PreparedMap,
        scale: tuple[float, float],
        rng: np.random.Generator,
        stage: int,
    ) -> tuple[list[_Answer], bool]:
        """Weigh the answers against the mirror image's best placement; tell whether that one fits, and better.

        The mirror image is searched as far as the maps were, where the best answer might be accepted.
        """
        flipped = PreparedMap.from_grid(moving.grid, moving.cells.mirrored(), moving.quality, self.rectangles)
        last_stage = stage if answers[0][2].probability >= ACCEPT_AT else 1
        _, ranking, _ = self._search(fixed, flipped, scale, rng, last_stage)
        if len(ranking) == 0:
            return answers, False
        mirror_log_odds = ranking.best
        weighed = [
            (fit, agreement, dataclasses.replace(evidence, mirror_log_odds=mirror_log_odds))
            for fit, agreement, evidence in answers
        ]
        best = max(unaided, answers[0][2].plausibility)
        return weighed, _convinces(ranking) and mirror_log_odds > best + MIRRORED_BY


def _against_rivals(search: Search, ranking: Ranking) -> Ranking:
    """Rank once more, with the best placement's rivals at every shift and quarter turn."""
    if len(ranking) == 0:
        return ranking
    return search.ranked(ranking.concat(search.rank(search.rivals_of(ranking.placements[0]))))


def _convinces(ranking: Ranking) -> bool:
    return (
        len(ranking) > 0 and posterior(ranking.plausibility[0], log_odds_of_rest(ranking.plausibility)[0]) >= ACCEPT_AT
    )


def _is_at_limit(fit: Fit, bounds: tuple[float, float]) -> bool:
    scale = math.hypot(fit.placement[0], fit.placement[1])
    return not bounds[0] * (1 + AT_LIMIT) < scale < bounds[1] * (1 - AT_LIMIT)


def _widened(bounds: tuple[float, float]) -> tuple[float, float]:
    return bounds[0] * (1 - REFINED_BEYOND), bounds[1] * (1 + REFINED_BEYOND)


def _similarity(fit: Fit) -> Similarity:
    a, b, tx, ty = fit.placement
    return Similarity.from_matrix([[a, -b, tx], [b, a, ty]])


def _candidate(fit: Fit, agreement: Agreement, evidence: Evidence, a: OccupancyGrid, b: OccupancyGrid) -> Candidate:
    return Candidate.from_pixels(
        _similarity(fit),
        a,
        b,
        confidence=evidence.probability,
        agreement=agreement,
        covariance=fit.covariance_in_map_frame(a),
        evidence=dataclasses.asdict(evidence) | {"residual_cells": fit.residual_cells},
    )
