import numpy as np
import pytest

from rectmerge.errors import InputError
from rectmerge.robust.confidence_model import RIGID_TERMS, rigid_terms
from rectmerge.robust.params import ConfidenceParams
from rectmerge.robust.wall_agreement import WallAgreement
from scenarios.studies.calibration import AGAINST, GradedCandidates, fit, loss, report

FIELDS = (
    "judged",
    "matched",
    "near",
    "contradicted",
    "clutter",
    "clutter_matched",
    "clutter_contradicted",
    "violations",
    "overlap",
    "iou",
)


def candidate(rng, right):
    """What speaks for a placement: a right one meets more, and misses less, than a wrong one, by and large."""
    met, missing = rng.normal(0.8, 0.1) if right else rng.normal(0.5, 0.1), rng.normal(0.03 if right else 0.12, 0.03)
    shares = {
        "matched": met,
        "near": met,
        "clutter_matched": met,
        "violations": missing,
        "contradicted": 0.1,
        "clutter_contradicted": 0.1,
    }
    shares = {name: float(np.clip(value, 0.0, 1.0)) for name, value in shares.items()}
    return {"judged": 300.0, "clutter": 200.0, "overlap": 0.5, "iou": 0.3, **shares}


def row(rng, *, is_found=True, **more):
    grades = ["fine" if is_found else "off", "off", "coarse"]
    return {
        "candidates": [[0]] * 3,
        "evidence": [candidate(rng, grade == "fine") for grade in grades],
        "grades": grades,
        "residual_px": 0.1,
        "extent_px": 500.0,
        "info": {"split": "train", "family": "office", **more},
    }


@pytest.fixture
def rows():
    rng = np.random.default_rng(0)
    return [row(rng, is_found=k % 3 != 0) for k in range(120)]


def test_the_fit_tells_right_from_wrong(rows):
    graded = GradedCandidates.from_rows(rows)

    weights = fit(graded)

    assert loss(graded, weights) < 0.7 * loss(graded, np.zeros(len(RIGID_TERMS)))
    odds = graded.terms @ weights
    assert np.median(odds[graded.is_right]) > 0 > np.median(odds[graded.is_there & ~graded.is_right])


def test_no_weight_is_against_its_sign(rows):
    weights = dict(zip(RIGID_TERMS, fit(GradedCandidates.from_rows(rows)), strict=True))

    assert all(weights[name] <= 0 for name in AGAINST)
    assert all(weight >= 0 for name, weight in weights.items() if name not in (*AGAINST, "one"))


def test_nearly_right_candidates_are_left_out(rows):
    graded = GradedCandidates.from_rows(rows)

    assert graded.is_there.sum(axis=1).tolist() == [2] * len(rows)
    assert graded.is_right.sum() == 80


def test_of_bent_pairs_only_what_is_wrong_is_learnt(rows):
    bent = GradedCandidates.from_rows([{**record, "residual_px": 5.0} for record in rows]).without_bent()

    assert not bent.is_right.any()
    assert bent.is_there.sum() < 2 * len(rows)


def test_the_terms_are_those_of_the_method(rows):
    graded = GradedCandidates.from_rows(rows[:1])
    columns = {name: np.array([evidence[name] for evidence in rows[0]["evidence"]]) for name in FIELDS}

    np.testing.assert_array_equal(graded.terms[0], rigid_terms(WallAgreement(**columns), ConfidenceParams()))


def test_the_report_leaves_out_other_splits_and_rooms_that_are_alike(rows):
    rng = np.random.default_rng(1)
    others = [row(rng, split="test"), row(rng, family="hospital")]

    text = report([*rows, *others])

    assert "120 pairs, 80 of them" in text
    assert "rigid = (" in text


def test_rows_without_evidence_are_refused():
    with pytest.raises(InputError, match="evidence"):
        report([{"candidates": [[0]], "evidence": [], "grades": None, "info": {"split": "train"}}])
