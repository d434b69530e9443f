from dataclasses import replace

import numpy as np
import pytest

from rectmerge.aligning import DOUBTED
from rectmerge.alignment import Alignment, Candidate
from rectmerge.fleet.evidence import log_odds
from rectmerge.fleet.params import EvidenceParams
from rectmerge.robust.params import VerdictParams
from rectmerge.similarity import Similarity

PARAMS = EvidenceParams()


def ambiguous(*candidates: tuple[float, float]) -> Alignment:
    """An ambiguous answer whose candidates have these plausibilities and shares of walls on solid floor."""
    found = tuple(
        Candidate(
            b_to_a=Similarity(1.0, 0.0, float(k)),
            pixels=Similarity(1.0, 0.0, float(k)),
            confidence=0.4,
            overlap=0.8,
            conflict=0.0,
            covariance=None,
            evidence={"plausibility": nats, "on_floor": floor, "overlap": 0.8, "clutter": 40, "clutter_matched": 1},
        )
        for k, (nats, floor) in enumerate(candidates)
    )
    return Alignment(verdict="ambiguous", reason="", method="", candidates=found, confidence=0.4)


@pytest.mark.parametrize(
    ("candidates", "low", "high"),
    [
        (((11.0, 0.0), (11.0, 0.0)), -3.0, -2.9),  # identical rooms
        (((12.0, 0.0), (9.5, 0.01)), 2.9, 3.0),  # rooms that differ a little
        (((12.0, 0.1), (10.5, 0.11)), -3.0, -2.9),  # the right placement is not among them
    ],
)
def test_where_a_place_repeats_itself_the_best_is_likely_by_its_lead_and_by_no_wall_on_floor(candidates, low, high):
    odds, has_bonus = log_odds(ambiguous(*candidates), PARAMS)

    assert low <= odds[0] <= high
    assert odds[1] <= odds[0]
    assert not has_bonus


def test_elsewhere_candidates_have_the_odds_of_the_verdict_and_the_best_is_capped():
    odds, has_bonus = log_odds(ambiguous((9.0, 0.0), (1.0, 0.0)), PARAMS)

    _, of_own, of_lead = VerdictParams().weights
    assert np.allclose(odds, [6.0, 6.0 - 8.0 * (of_own + of_lead)], atol=0.01)
    assert has_bonus


def test_what_the_resolutions_do_not_allow_speaks_for_no_join():
    pair = ambiguous((9.0, 0.0), (7.0, 0.0))
    first = replace(pair.candidates[0], evidence={**pair.candidates[0].evidence, DOUBTED: 1.0})

    odds, _ = log_odds(replace(pair, candidates=(first, *pair.candidates[1:])), PARAMS)

    assert odds[0] <= 0.0
