from dataclasses import dataclass, replace

import pytest

from rectmerge.aligning import align
from rectmerge.similarity import Similarity
from scenarios.bench.asking import ask
from scenarios.bench.contenders import Contender
from scenarios.bench.rows import score_answer
from tests.scenarios.known_answers import Failing, Fixed, contender, pair

CONTRACT = {
    *("task_id", "pair_id", "suite", "place", "method", "outcome", "verdict", "confidence", "candidates", "errors"),
    *("overlap", "seconds", "peak_mb", "reason"),
}


def row(method, the_pair=None):
    entry, the_pair = contender(method), the_pair or pair()
    return score_answer(the_pair, entry, ask(the_pair, entry))


def test_a_right_answer_is_a_full_row():
    scored = row(Fixed(tx=4.3))

    assert set(scored) >= CONTRACT
    assert (scored["outcome"], scored["verdict"], scored["confidence"]) == ("right-accepted", "accepted", 0.75)
    assert scored["errors"]["e_px"] == pytest.approx(0.3)
    assert scored["errors"]["e_over_l"] == pytest.approx(0.3 / (40**2 + 60**2) ** 0.5)
    assert scored["candidates"] == [[[1.0, 0.0, 4.3], [0.0, 1.0, 2.0]]]
    assert scored["seconds"]["wall"] > 0


@dataclass(frozen=True)
class Telling(Fixed):
    """Rejects, and says between which scales it was to search."""

    def align(self, a, b, *, scale, rng):
        return replace(super().align(a, b, scale=scale, rng=rng), verdict="rejected", reason=f"{scale}")


@pytest.mark.parametrize(
    ("knows_scale", "changes", "bounds"),
    [
        (False, {}, (0.5, 2.0)),
        (True, {"pixels": Similarity(1.25)}, (1.25, 1.25)),
        (True, {"related": False, "info": {"resolution_a": 0.04, "resolution_b": 0.05}}, (1.25, 1.25)),
        (True, {"related": False, "info": {"resolution_a": 0.04, "resolution_b": None}}, (0.5, 2.0)),
    ],
)
def test_a_contender_that_knows_the_scale_is_told_it(knows_scale, changes, bounds):
    entry, the_pair = Contender(label="one", method=Telling(), knows_scale=knows_scale), pair(**changes)

    scored = score_answer(the_pair, entry, ask(the_pair, entry))

    assert scored["reason"] == str(bounds)
    assert scored["knows_scale"] is knows_scale


@pytest.mark.parametrize(
    ("method", "related", "expected"),
    [
        (Fixed(), True, "right-accepted"),
        (Fixed(tx=9.0), True, "wrong-accepted"),
        (Fixed(), False, "wrong-accepted"),
        (Fixed(verdict="ambiguous"), True, "ambiguous-with-truth"),
        (Fixed(verdict="ambiguous", tx=9.0), True, "ambiguous-without-truth"),
        (Fixed(verdict="rejected"), True, "rejected"),
        (Failing(), True, "error"),
        (Failing(how="memory"), True, "out-of-memory"),
        (Failing(how="opencv memory"), True, "out-of-memory"),
    ],
)
def test_outcome_of_a_row(method, related, expected):
    assert row(method, pair(related=related))["outcome"] == expected


def test_a_method_is_warmed_up_once_on_a_building_that_it_can_merge():
    seen = []

    @dataclass(frozen=True)
    class Watching(Fixed):
        def align(self, a, b, **options):
            seen.append((a, b))
            return super().align(a, b, **options)

    the_pair, entry = pair(), contender(Watching())
    for _ in range(2):
        ask(the_pair, entry)

    assert [a is the_pair.a for a, _ in seen] == [False, True, True]
    assert align(*seen[0], method="paper")  # all that a method compiles lies behind a yes


def test_an_error_keeps_its_reason_and_its_traceback():
    scored = row(Failing())

    assert scored["reason"] == "ZeroDivisionError: no rectangles at all"
    assert "in align" in scored["log"]
    assert scored["verdict"] is None
