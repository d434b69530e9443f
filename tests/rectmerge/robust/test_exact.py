"""Exact answers: what walls that meet exactly say of bent maps, and unbending of an answer that is nearly sure."""

from dataclasses import replace

import numpy as np
import pytest

from rectmerge.analysis.overlap import Agreement
from rectmerge.robust.confidence_model import plausibility
from rectmerge.robust.exact import Answer, make_exact
from rectmerge.robust.params import Params, VerdictParams
from rectmerge.robust.prepared_map import PreparedMap
from rectmerge.robust.ranking import rank
from rectmerge.robust.refinement import Fit
from rectmerge.robust.verdict import NO_AGREEMENT, Evidence, judge
from rectmerge.robust.working_pair import WorkingPair
from rectmerge.similarity import Similarity
from tests.rectmerge.elastic.bent_maps import bent_view, large_building, random_displacement
from tests.rectmerge.robust import plans

NEARLY = Evidence(
    agreement=NO_AGREEMENT._replace(overlap=0.5),
    plausibility=2.0,
    rest_log_odds=-20.0,
    params=replace(VerdictParams(), weights=(0.0, 0.5, 0.0)),
)


def answer(pixels, evidence=NEARLY):
    placement = np.array([pixels.matrix[0, 0], pixels.matrix[1, 0], pixels.tx, pixels.ty])
    return Answer(Fit(placement, np.eye(4), 0.9, 1.0), Agreement(0.9, 0.8, 0.0), evidence)


def bent_case():
    a, pixels = large_building(), Similarity(0.8, 0.3, 60.0, -40.0)
    truth = random_displacement(1, a.shape, spacing=200, size=14)
    b = bent_view(a, pixels, truth, (560, 720))
    cells = np.argwhere(b.free)[::197, ::-1].astype(float)
    return a, b, Similarity.fit(cells, truth.apply(pixels.apply(cells)))


def test_a_bend_that_holds_makes_a_likely_answer_sure():
    a, b, fit = bent_case()

    confirmed = answer(fit).unbent(a, b)

    assert judge(NEARLY) == "ambiguous"
    assert judge(confirmed.evidence) == "accepted"
    assert confirmed.evidence.as_dict()["bend_log_odds"] == VerdictParams().bend_log_odds


def test_maps_that_do_not_bend_leave_it_as_likely_as_it_is():
    a = large_building()

    assert answer(Similarity()).unbent(a, a).evidence == NEARLY


@pytest.mark.parametrize(
    "change", [{"plausibility": 12.0}, {"plausibility": 0.0}, {"rest_log_odds": 2.0}, {"mirror_log_odds": 3.0}]
)
def test_an_answer_that_it_cannot_decide_is_not_unbent(change):
    given = answer(Similarity(), replace(NEARLY, **change))

    assert given.unbent(None, None) is given  # no map is looked at


def test_a_placement_under_which_walls_meet_exactly_is_less_likely_as_bent_maps():
    params, grid = Params(), plans.see(plans.office(3)).grid
    maps = PreparedMap.from_grid(grid, params), PreparedMap.from_grid(grid, params)
    pair = WorkingPair.from_maps(*maps, (0.5, 2.0), np.random.default_rng(0), params)
    ranking = rank(pair, np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 60.0, 40.0]])).take(np.array([0, 1]))
    rigid, bent = np.array([-9.0, -9.0]), np.array([3.0, 2.0])
    as_bent = replace(ranking, rigid=rigid, bent=bent, plausibility=plausibility(rigid, bent))

    exact, beside = make_exact(pair, as_bent, *maps, (0.5, 2.0))

    assert exact.evidence.surface_matched > 0.5 > beside.evidence.surface_matched
    assert exact.evidence.bent < 3.0 - 5.0
    assert exact.evidence.plausibility < beside.evidence.plausibility
    assert exact.evidence.rest_log_odds == pytest.approx(beside.evidence.plausibility)
