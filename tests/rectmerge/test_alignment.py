import json

import numpy as np
import pytest

from rectmerge.alignment import Alignment, Candidate, ScaleReport
from rectmerge.similarity import Similarity
from tests import drawing

KEYS = {
    *(
        "schema",
        "verdict",
        "method_verdict",
        "checked",
        "reason",
        "confidence",
        "method",
        "b_to_a",
        "pixels",
        "scale",
        "overlap",
        "conflict",
    ),
    *("quality", "candidates", "seconds"),
}


@pytest.fixture
def candidate() -> Candidate:
    a = drawing.building(resolution=0.05, origin=(-3.0, 2.0, 0.3))
    b = drawing.building(resolution=0.10)
    return Candidate.from_pixels(Similarity(2.0, 0.1, 3, 4), a, b, confidence=0.9, covariance=np.eye(4))


@pytest.mark.parametrize("verdict", ["ambiguous", "rejected"])
def test_only_an_accepted_answer_is_true_and_has_a_placement(candidate, verdict):
    yes = Alignment(verdict="accepted", reason="fits", method="m", candidates=(candidate,))
    no = Alignment(verdict=verdict, reason="does not fit", method="m", candidates=(candidate,))

    assert yes
    assert yes.b_to_a is candidate.b_to_a
    assert yes.pixels is candidate.pixels
    assert not no
    assert no.b_to_a is None
    assert no.pixels is None
    assert no.candidates == (candidate,)


def test_the_headline_tells_the_verdict_and_the_confidence_in_a_candidate(candidate):
    both = (candidate, candidate)

    yes = Alignment(verdict="accepted", reason="fits", method="m", candidates=both)
    no = Alignment(verdict="ambiguous", reason="two fit", method="m", candidates=both)

    assert yes.headline() == "accepted, confidence 0.90"
    assert no.headline(2) == "ambiguous: candidate 2 of 2, confidence 0.90"


def test_json_has_the_keys_that_programs_rely_on(candidate):
    answer = Alignment(
        verdict="accepted",
        reason="fits",
        method="m",
        candidates=(candidate,),
        unit="m",
        scale=ScaleReport(found=2.0, expected=2.0, source="resolution"),
    )

    data = json.loads(json.dumps(answer.as_dict(), allow_nan=False))

    assert set(data) == KEYS
    assert data["scale"] == {"found": 2.0, "expected": 2.0, "from": "resolution"}
    assert data["b_to_a"]["unit"] == "m"
    assert np.shape(data["pixels"]) == (2, 3)
    assert np.shape(data["candidates"][0]["covariance"]) == (4, 4)


def test_json_of_a_no_has_no_placement_but_its_candidates(candidate):
    data = Alignment(verdict="rejected", reason="no", method="m", candidates=(candidate,)).as_dict()

    assert data["b_to_a"] is None
    assert data["pixels"] is None
    assert data["candidates"][0]["b_to_a"]["scale"] == pytest.approx(1.0)  # 2 cells of 0.05 m are one of 0.10 m


def test_json_of_a_no_without_candidates_measures_nothing():
    data = Alignment(verdict="rejected", reason="empty", method="m").as_dict()

    assert (data["overlap"], data["conflict"], data["candidates"]) == (None, None, [])


def test_a_candidate_measures_how_the_maps_agree():
    grid = drawing.building()

    measured = Candidate.from_pixels(Similarity(), grid, grid, confidence=0.5)

    assert (measured.overlap, measured.conflict) == (1.0, 0.0)
