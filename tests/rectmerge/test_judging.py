from dataclasses import dataclass

import numpy as np
import pytest

import rectmerge as rm
from rectmerge import judging
from rectmerge.aligning import align
from rectmerge.alignment import Alignment, Candidate
from rectmerge.errors import InputError
from rectmerge.methods import make_method
from rectmerge.similarity import Similarity
from tests import drawing


@dataclass(frozen=True)
class Certain:
    """Accepts one placement, whatever the maps show."""

    pixels: Similarity
    name: str = "certain"

    def align(self, a, b, *, scale, rng: np.random.Generator) -> Alignment:
        candidate = Candidate.from_pixels(self.pixels, a, b, confidence=1.0)
        return Alignment(
            verdict="accepted", reason="of course", method=self.name, candidates=(candidate,), confidence=1.0
        )


@pytest.fixture(scope="module")
def maps():
    return tuple(rm.read_map(drawing.DATA / f"building_{name}.yaml") for name in "ab")


def confirmed(maps, pixels):
    method = Certain(pixels)
    return judging.confirm(*maps, align(*maps, method=method), method=method)


def test_a_right_answer_of_another_method_is_accepted_by_the_judge(maps):
    answer = confirmed(maps, drawing.B_IN_A)

    assert (answer.verdict, answer.method_verdict, answer.checked) == ("accepted", "accepted", "accepted")
    assert answer.pixels == drawing.B_IN_A
    assert answer.confidence == answer.candidates[0].confidence > 0.85


@pytest.mark.parametrize(
    "pixels",
    [
        pytest.param(Similarity(1.15, -1.0, 30.0, 80.0), id="elsewhere"),
        pytest.param(
            Similarity(drawing.B_IN_A.scale, drawing.B_IN_A.angle, drawing.B_IN_A.tx + 9, drawing.B_IN_A.ty),
            id="nine cells beside the truth",
        ),
        pytest.param(Similarity(1e6), id="at a scale that nobody could mean"),
    ],
)
def test_a_wrong_answer_is_not_and_stays_the_best_candidate(maps, pixels):
    answer = confirmed(maps, pixels)

    assert not answer
    assert answer.checked == answer.verdict
    assert answer.method_verdict == "accepted"
    assert answer.candidates[0].pixels == pixels
    assert answer.confidence < 0.5
    assert "certain says accepted" in answer.reason
    assert "the check says" in answer.reason


def test_a_method_that_judges_itself_is_not_asked_twice(maps, monkeypatch):
    method = make_method("robust")
    answer = align(*maps, method=method)
    monkeypatch.setattr(judging, "check", None)

    assert answer
    assert judging.confirm(*maps, answer, method=method) is answer


def test_a_refusal_is_not_judged(maps, monkeypatch):
    refused = Alignment(verdict="rejected", reason="no", method="certain")
    monkeypatch.setattr(judging, "check", None)

    assert judging.confirm(*maps, refused, method=Certain(Similarity())) is refused


def test_check_takes_an_answer(maps):
    judged = rm.check(*maps, align(*maps, method=Certain(drawing.B_IN_A)))

    assert judged.verdict == "accepted"
    assert judged.method == "robust"


def test_check_refuses_an_answer_without_candidates(maps):
    with pytest.raises(InputError, match="no candidate"):
        rm.check(*maps, Alignment(verdict="rejected", reason="too little", method="certain"))
