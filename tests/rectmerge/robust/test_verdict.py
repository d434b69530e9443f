import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.robust.verdict import ACCEPT_AT, Evidence, judge

CONVINCING = Evidence(likelihood=900.0, rival=0.1, overlap=0.9, iou=0.8, support=1.0, missing=0.0)
SHARES = st.floats(0, 1)
EVIDENCE = st.builds(
    Evidence,
    likelihood=st.floats(-100, 5000),
    rival=st.floats(0, 2),
    overlap=SHARES,
    iou=SHARES,
    support=st.floats(-1, 6),
    missing=SHARES,
    matched=SHARES,
    conflict=SHARES,
)


@given(EVIDENCE)
def test_a_probability_is_one(evidence):
    assert 0 < evidence.probability < 1
    assert evidence.probability_without_rival >= evidence.probability


@given(EVIDENCE, st.sampled_from(["rival", "missing", "conflict"]), st.floats(0, 1))
def test_more_that_speaks_against_it_never_helps(evidence, name, more):
    worse = dataclasses.replace(evidence, **{name: getattr(evidence, name) + more})

    assert worse.probability <= evidence.probability


@given(EVIDENCE, st.sampled_from(["iou", "support"]), st.floats(0, 1))
def test_more_that_speaks_for_it_never_hurts(evidence, name, more):
    better = dataclasses.replace(evidence, **{name: getattr(evidence, name) + more})

    assert better.probability >= evidence.probability


@given(EVIDENCE)
def test_accepted_means_probable(evidence):
    verdict, reason = judge(evidence)

    assert (verdict == "accepted") == (evidence.probability >= ACCEPT_AT)
    assert reason


@given(EVIDENCE, st.floats(0.9, 2.0))
def test_whatever_else_speaks_for_it_an_equal_rival_is_never_overruled(evidence, rival):
    assert judge(dataclasses.replace(evidence, rival=rival))[0] != "accepted"


def test_the_verdicts_and_their_reasons():
    assert judge(CONVINCING)[0] == "accepted"
    verdict, reason = judge(dataclasses.replace(CONVINCING, rival=0.98))
    assert verdict == "ambiguous"
    assert "98%" in reason
    verdict, reason = judge(
        dataclasses.replace(CONVINCING, likelihood=-5.0, rival=2.0, iou=0.0, support=0.0, missing=1.0)
    )
    assert verdict == "rejected"
    assert "no placement" in reason
    verdict, reason = judge(dataclasses.replace(CONVINCING, iou=0.1, support=0.1, missing=0.9))
    assert verdict == "rejected"
    assert "90%" in reason


@pytest.mark.parametrize("matched", [0.5, 0.9])
def test_maps_that_fit_to_the_cell_may_not_contradict_each_other(matched):
    crisp = dataclasses.replace(CONVINCING, matched=matched, conflict=0.5)
    bent = dataclasses.replace(crisp, matched=0.1)

    assert crisp.probability < bent.probability
