import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.robust.params import VerdictParams
from rectmerge.robust.verdict import Evidence, judge, log_odds_of_rest, posterior

PARAMS = VerdictParams()
CONVINCING = Evidence(plausibility=8.0, rest_log_odds=0.0, likelihood=900.0)
ODDS = st.floats(-20, 20)
EVIDENCE = st.builds(
    Evidence, plausibility=ODDS, rest_log_odds=ODDS, mirror_log_odds=ODDS, likelihood=st.floats(-100, 5000)
)


@given(EVIDENCE)
def test_a_probability_is_one(evidence):
    assert 0 < evidence.probability < 1


@given(st.lists(ODDS, min_size=1, max_size=8))
def test_answers_exclude_each_other(odds):
    rivals = log_odds_of_rest(np.array(odds))

    assert sum(posterior(own, rival) for own, rival in zip(odds, rivals, strict=True)) < 1


def test_a_lone_answer_has_no_rivals():
    assert log_odds_of_rest(np.array([3.0])).tolist() == [-math.inf]


@given(EVIDENCE, st.sampled_from(["rest_log_odds", "mirror_log_odds"]), st.floats(0, 5))
def test_more_that_speaks_against_it_never_helps(evidence, name, more):
    worse = dataclasses.replace(evidence, **{name: getattr(evidence, name) + more})

    assert worse.probability <= evidence.probability


@given(EVIDENCE, st.floats(0, 5))
def test_more_that_speaks_for_it_never_hurts(evidence, more):
    better = dataclasses.replace(evidence, plausibility=evidence.plausibility + more)

    assert better.probability >= evidence.probability


@given(EVIDENCE)
def test_accepted_means_probable(evidence):
    assert (judge(evidence) == "accepted") == (evidence.probability >= evidence.asked)


def test_more_is_asked_where_the_overlap_is_less_than_any_that_was_fitted():
    asked = [PARAMS.asked_of(overlap) for overlap in (0.05, 0.13, PARAMS.least_overlap, 0.5)]

    assert asked == [PARAMS.accept_little_at] * 2 + [PARAMS.accept_at] * 2


@given(EVIDENCE)
def test_an_equal_rival_is_never_overruled(evidence):
    equal = dataclasses.replace(evidence, rest_log_odds=evidence.plausibility)

    assert judge(equal) != "accepted"
    assert equal.probability <= 0.5


@given(EVIDENCE, st.floats(0.01, 5))
def test_a_mirror_image_that_fits_better_leaves_even_odds_at_most(evidence, more):
    mirrored = dataclasses.replace(evidence, mirror_log_odds=evidence.plausibility + more)

    assert mirrored.probability <= 0.5


@given(st.floats(-20, -3))
def test_a_poor_placement_is_not_accepted_for_want_of_rivals(odds):
    assert judge(Evidence(plausibility=odds)) == "rejected"


@given(EVIDENCE, st.floats(0, 5))
def test_unbending_never_speaks_against_a_placement_nor_against_its_rivals(evidence, added):
    confirmed = dataclasses.replace(evidence, bend_log_odds=added)

    assert confirmed.probability >= evidence.probability
    assert confirmed.probability <= posterior(evidence.plausibility - evidence.rest_log_odds)


def test_no_gap_lies_between_accepted_and_ambiguous():
    verdicts = [judge(Evidence(plausibility=odds)) for odds in np.linspace(-8, 8, 801)]

    changes = [pair for pair in itertools.pairwise(verdicts) if pair[0] != pair[1]]
    assert changes == [("rejected", "ambiguous"), ("ambiguous", "accepted")]


@given(EVIDENCE)
def test_what_can_slide_or_grow_is_even_odds_at_most(evidence):
    assert dataclasses.replace(evidence, slack_cells=PARAMS.max_slack_cells + 1).probability <= 0.5
    assert dataclasses.replace(evidence, is_at_limit=True).probability <= 0.5


@pytest.mark.parametrize(
    ("change", "verdict"),
    [
        ({}, "accepted"),
        ({"rest_log_odds": 8.0}, "ambiguous"),
        ({"rest_log_odds": 8.0, "slack_cells": 9.0}, "rejected"),
        ({"slack_cells": 9.0}, "rejected"),
        ({"is_at_limit": True}, "rejected"),
        ({"plausibility": -5.0}, "rejected"),
    ],
)
def test_the_verdicts(change, verdict):
    assert judge(dataclasses.replace(CONVINCING, **change)) == verdict
