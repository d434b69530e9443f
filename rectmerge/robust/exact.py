"""Exact answers: the best placements, refined on the cells of the given maps, with their evidence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rectmerge.alignment import Candidate
from rectmerge.analysis.overlap import Agreement, AgreementMeter
from rectmerge.elastic.unbend import unbend
from rectmerge.grid import OccupancyGrid
from rectmerge.robust import wall_agreement
from rectmerge.robust.confidence_model import plausibility, surface_exact_odds
from rectmerge.robust.params import ConfidenceParams, ExactParams
from rectmerge.robust.prepared_map import PreparedMap
from rectmerge.robust.ranking import Ranking
from rectmerge.robust.refinement import Fit, Surface, fit_surfaces, to_pixels
from rectmerge.robust.verdict import Evidence, log_odds_of_rest
from rectmerge.robust.working_pair import WorkingPair
from rectmerge.similarity import Similarity


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """Exact placement of the moving map on the fixed one, with its agreement and evidence."""

    fit: Fit
    agreement: Agreement
    evidence: Evidence

    def beside_mirror(self, mirror_log_odds: float) -> Answer:
        """Return the answer with the best placement of the mirror image as a rival."""
        return replace(self, evidence=replace(self.evidence, mirror_log_odds=mirror_log_odds))

    def unbent(self, a: OccupancyGrid, b: OccupancyGrid) -> Answer:
        """Let unbending speak for the answer where that decides, and walls held back from its fit confirm it.

        Parameters
        ----------
        a, b
            The fixed and the moving map.
        """
        params = self.evidence.params
        confirmed = replace(self.evidence, bend_log_odds=params.bend_log_odds)
        decides = self.evidence.probability < confirmed.asked <= confirmed.probability
        return replace(self, evidence=confirmed) if decides and unbend(a, b, _similarity(self.fit)) else self

    def candidate(self, a: OccupancyGrid, b: OccupancyGrid, *, is_swapped: bool) -> Candidate:
        """Return the answer as a placement of B on A; A was moved onto B if swapped."""
        fit = self.fit.inverse() if is_swapped else self.fit
        return Candidate.from_pixels(
            _similarity(fit),
            a,
            b,
            confidence=self.evidence.probability,
            agreement=self.agreement,
            covariance=fit.covariance_in_map_frame(a),
            evidence=replace(self.evidence, residual_cells=fit.residual_cells).as_dict(),
        )


def make_exact(
    pair: WorkingPair, ranking: Ranking, fixed: PreparedMap, moving: PreparedMap, scale: tuple[float, float]
) -> Sequence[Answer]:
    """Refine the best placements on the maps' own cells, and gather the evidence for each.

    What turns out exact counts against bent maps; the order stays.
    """
    params = pair.params
    surfaces = Surface.from_cells(fixed.cells), Surface.from_cells(moving.cells)
    meter, bounds = AgreementMeter(fixed.grid, moving.grid), params.exact.widened(scale)

    def fitted(i: int, points: int) -> Fit:
        placement = to_pixels(ranking.placements[i], fixed.walled, moving.walled)
        return fit_surfaces(placement, *surfaces, bounds, params.exact, points=points)

    count = min(params.max_candidates, len(ranking))
    fits = [fitted(i, params.exact.rival_points if i else params.exact.surface_points) for i in range(count)]
    ranking = _with_surfaces(ranking, fits, params.confidence)
    rest, answers = log_odds_of_rest(ranking.plausibility), []
    for i, fit in enumerate(fits):
        agreement = meter.measure(_similarity(fit))
        evidence = Evidence(
            plausibility=float(ranking.plausibility[i]),
            rest_log_odds=float(rest[i]),
            rigid=float(ranking.rigid[i]),
            bent=float(ranking.bent[i]),
            handicap=pair.handicap,
            likelihood=float(ranking.likelihood[i]),
            support=float(ranking.support[i]),
            agreement=wall_agreement.at(ranking.agreement, i),
            surface_matched=fit.surface_matched,
            conflict=agreement.conflict,
            slack_cells=fit.slack_cells,
            is_at_limit=_is_at_limit(fit, bounds, params.exact),
            params=params.verdict,
        )
        answers.append(Answer(fit, agreement, evidence))
    return answers


def _with_surfaces(ranking: Ranking, fits: Sequence[Fit], params: ConfidenceParams) -> Ranking:
    """Return a ranking whose first placements count, as bent maps, for what their exact fits leave."""
    bent = ranking.bent.copy()
    bent[: len(fits)] += surface_exact_odds(np.array([fit.surface_matched for fit in fits]), params)
    change = plausibility(ranking.rigid, bent) - plausibility(ranking.rigid, ranking.bent)
    return replace(ranking, bent=bent, plausibility=ranking.plausibility + change)


def _is_at_limit(fit: Fit, bounds: tuple[float, float], params: ExactParams) -> bool:
    scale = math.hypot(fit.placement[0], fit.placement[1])
    return not bounds[0] * (1 + params.at_limit) < scale < bounds[1] * (1 - params.at_limit)


def _similarity(fit: Fit) -> Similarity:
    a, b, tx, ty = fit.placement
    return Similarity.from_matrix([[a, -b, tx], [b, a, ty]])
