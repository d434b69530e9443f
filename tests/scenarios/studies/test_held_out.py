import dataclasses
import re

import numpy as np
import pytest

from rectmerge.errors import InputError
from rectmerge.robust.params import VerdictParams
from rectmerge.robust.verdict import probability
from scenarios.studies import held_out
from scenarios.studies.probability_fit import BestCandidate, fit_probability
from tests.scenarios.studies.test_calibration import drawn_row

PARAMS = VerdictParams()


@pytest.fixture(scope="module")
def rows():
    rng = np.random.default_rng(2)
    return [drawn_row(rng, is_found=k % 2 != 0, place=f"p{k % 12}") for k in range(48)]


@pytest.mark.slow
def test_the_report_holds_all_weights_and_a_verdict_on_every_pair(rows):
    lines = held_out.report(rows)

    assert all(name in lines for name in ("confidence.rigid = (", "confidence.bent = (", "verdict.weights = ("))
    assert sum(int(n) for n in re.findall(r"(\d+) n,", lines)) == len(rows)
    assert sum(int(n) for n in re.findall(r"(\d+) right-accepted", lines)) > 12


def test_a_report_without_usable_rows_is_refused(rows):
    with pytest.raises(InputError, match="no row may be fitted"):
        held_out.report([{**row, "info": {**row["info"], "split": "test"}} for row in rows])


def test_a_pair_without_its_right_candidates_keeps_the_others(rows):
    wrong = held_out.without_right(rows[1])

    assert wrong["grades"] == ["off"]
    assert len(wrong["evidence"]) == 1
    assert held_out.without_right(wrong) is None


def drawn_candidates(weights, *, seed=0, count=4000):
    rng = np.random.default_rng(seed)
    params = dataclasses.replace(PARAMS, weights=weights)
    odds = rng.uniform(-6, 8, (count, 3))
    return [
        BestCandidate(
            grade="fine" if rng.random() < probability(own, own - abs(rest), mirror, params) else "off",
            log_odds=own,
            rest_log_odds=own - abs(rest),
            mirror_log_odds=mirror,
            is_held=True,
            overlap=0.5,
        )
        for own, rest, mirror in odds.tolist()
        if mirror < own
    ]


def test_known_weights_are_recovered():
    known = (0.5, 0.4, 0.7)

    fitted = fit_probability(candidates := drawn_candidates(known), np.ones(len(candidates)), PARAMS)

    np.testing.assert_allclose(fitted, known, atol=0.2)


@pytest.mark.parametrize(
    ("change", "outcome"),
    [
        ({}, "right-accepted"),
        ({"grade": "off"}, "wrong-accepted"),
        ({"is_held": False}, "refused"),
        ({"rest_log_odds": 8.0}, "refused"),
        ({"log_odds": 1.2}, "right-accepted"),
        ({"log_odds": 1.2, "overlap": 0.05}, "refused"),
    ],
)
def test_the_outcome_is_that_of_the_verdict(change, outcome):
    best = BestCandidate(
        grade="fine", log_odds=8.0, rest_log_odds=-2.0, mirror_log_odds=-2.0, is_held=True, overlap=0.5
    )

    assert held_out.outcome(dataclasses.replace(best, **change), PARAMS) == outcome
