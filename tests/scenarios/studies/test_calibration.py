import numpy as np
import pytest

from rectmerge.errors import InputError
from rectmerge.robust.confidence_model import BENT_TERMS, RIGID_TERMS, bent_terms, rigid_terms
from rectmerge.robust.params import ConfidenceParams
from rectmerge.robust.wall_agreement import WallAgreement
from scenarios.studies.calibration import AGAINST, GradedCandidates, OddsWeights, fit_odds, usable

SHARES = ("matched", "near", "clutter_matched", "violations", "contradicted", "clutter_contradicted")


def candidate(rng, is_right):
    """Draw evidence: a right placement meets more, and misses less, than a wrong one, by and large."""
    met, missing = (
        rng.normal(0.8, 0.1) if is_right else rng.normal(0.5, 0.1),
        rng.normal(0.03 if is_right else 0.12, 0.03),
    )
    values = (met, met, met, missing, 0.1, 0.1)
    shares = {name: float(np.clip(value, 0.0, 1.0)) for name, value in zip(SHARES, values, strict=True)}
    contradictions = dict.fromkeys(("on_floor", "beside", "corners_missed", "corners_denied"), shares["violations"])
    fixed = {"judged": 300.0, "clutter": 200.0, "overlap": 0.5, "iou": 0.3, "support": 0.5, "handicap": 0.0}
    return {
        **fixed,
        **shares,
        **contradictions,
        "mirror_log_odds": None,
        "slack_cells": 0.1,
        "is_at_limit": False,
        "surface_matched": 0.5,
    }


def drawn_row(rng, *, is_found=True, place="p", **more):
    grades = ["fine" if is_found else "off", "off", "coarse"]
    return {
        "suite": "standard",
        "place": place,
        "related": is_found,
        "overlap": 0.5 if is_found else None,
        "candidates": [[0]] * 3,
        "evidence": [candidate(rng, grade == "fine") for grade in grades],
        "grades": grades,
        "residual_px": 0.1,
        "extent_px": 500.0,
        "info": {"split": "train", "family": "office", "pose_source": "truth", **more},
    }


@pytest.fixture(scope="module")
def rows():
    rng = np.random.default_rng(0)
    return [drawn_row(rng, is_found=k % 3 != 0, place=f"p{k % 20}") for k in range(120)]


def test_the_fit_tells_right_from_wrong(rows):
    graded = GradedCandidates.from_rows(rows)

    choices = graded.rigid_choices()
    weights = fit_odds(graded).rigid

    assert choices.loss(weights) < 0.7 * choices.loss(np.zeros(len(RIGID_TERMS)))
    odds = choices.log_odds(weights)
    assert np.median(odds[graded.is_right]) > 0 > np.median(odds[graded.is_there & ~graded.is_right])


def test_no_weight_is_against_its_sign(rows):
    weights = fit_odds(GradedCandidates.from_rows(rows))

    for terms, fitted in ((RIGID_TERMS, weights.rigid), (BENT_TERMS, weights.bent)):
        for name, weight in zip(terms, fitted, strict=True):
            assert name == "one" or (weight <= 0 if name in AGAINST else weight >= 0)


def test_nearly_right_candidates_are_left_out(rows):
    graded = GradedCandidates.from_rows(rows)

    assert graded.is_there.sum(axis=1).tolist() == [2] * len(rows)
    assert graded.is_right.sum() == 80


@pytest.mark.parametrize("change", [{"residual_px": 5.0}, {"info": {"truth": "by eye"}}])
def test_of_bent_pairs_only_what_is_wrong_is_learnt_as_rigid(rows, change):
    graded = GradedCandidates.from_rows([{**row, **change} for row in rows])

    assert graded.is_right.any()
    assert not graded.without_bent().is_right.any()
    assert graded.without_bent().is_there.sum() < 2 * len(rows)


def test_the_terms_are_those_of_the_method(rows):
    graded = GradedCandidates.from_rows(rows[:1])
    columns = {name: np.array([each[name] for each in rows[0]["evidence"]]) for name in WallAgreement._fields}
    agreements, half = WallAgreement(**columns), np.full(3, 0.5)

    np.testing.assert_array_equal(graded.rigid[0], rigid_terms(agreements, ConfidenceParams()))
    np.testing.assert_array_equal(graded.bent[0], bent_terms(agreements, half, half, ConfidenceParams()))


def test_the_odds_in_use_are_those_of_the_method(rows):
    weights, params = OddsWeights.in_use(), ConfidenceParams()

    assert weights.rigid.tolist() == list(params.rigid)
    assert weights.bent.tolist() == list(params.bent)
    assert weights.log_odds(rows[0]["evidence"]).shape == (3,)


def test_other_splits_rooms_that_are_alike_and_unidentifiable_pairs_are_not_fitted():
    rng = np.random.default_rng(1)
    simulated = [{}, {"split": "test"}, {"family": "hospital"}, {"identifiable": False}]
    real = {**drawn_row(rng), "info": {"split": "test", "variant": "crop"}}

    kept = usable([*(drawn_row(rng, **info) for info in simulated), real])

    assert [row["info"].get("variant", row["info"].get("family")) for row in kept] == ["office", "crop"]


def test_rows_without_evidence_are_refused():
    with pytest.raises(InputError, match="evidence"):
        GradedCandidates.from_rows([{"candidates": [[0]], "evidence": [], "grades": None, "info": {"split": "train"}}])
