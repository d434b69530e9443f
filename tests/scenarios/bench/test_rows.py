from dataclasses import dataclass, replace

import numpy as np
import pytest

from rectmerge.aligning import align
from rectmerge.alignment import Alignment, Candidate
from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.bench.asking import ask
from scenarios.bench.contenders import Contender
from scenarios.bench.rows import measure_bend, score_answer, score_answer_and_bend
from tests.rectmerge.elastic.bent_maps import bent_view, large_building, random_displacement
from tests.scenarios.known_answers import Failing, Fixed, contender, grid, pair

BENT_ON = Similarity(0.8, 0.3, 60.0, -40.0)
BEND = random_displacement(1, large_building().shape, spacing=200, size=14)
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


def test_a_bend_is_tried_on_what_merge_would_write():
    the_pair, entry = pair(b=OccupancyGrid(grid().occupancy[2:, 4:])), contender(Fixed(tx=4.3))
    answer = ask(the_pair, entry)

    tried, not_tried = (
        score_answer_and_bend(the_pair, entry, replace(answer, checked=checked))["bend"]
        for checked in ("accepted", "rejected")
    )

    assert not_tried is None
    assert tried == {
        "accepted": False,
        "reason": tried["reason"],
        "e_px": pytest.approx(0.3),
        "double_walls_before": 0.0,
        "double_walls_after": 0.0,
    }
    assert "too few walls" in tried["reason"]


def test_a_bent_pair_is_scored_before_and_after():
    a, b = large_building(), bent_view(large_building(), BENT_ON, BEND, (560, 720))
    at_b = np.argwhere(b.free)[::997, ::-1].astype(float)
    at_a = BEND.apply(BENT_ON.apply(at_b))
    fit = Similarity.fit(at_b, at_a)
    answer = Alignment(
        verdict="accepted", reason="", method="m", candidates=(Candidate.from_pixels(fit, a, b, confidence=0.9),)
    )

    bend = measure_bend(pair(a=a, b=b, control_points=np.hstack([at_a, at_b])), answer)

    assert bend["accepted"], bend["reason"]
    assert bend["e_px"] < 0.5 * np.sqrt(((fit.apply(at_b) - at_a) ** 2).sum(axis=1).mean())
    assert bend["double_walls_after"] < 0.5 * bend["double_walls_before"]
    unrelated = measure_bend(pair(a=a, b=b, related=False), answer)
    assert unrelated == {**bend, "e_px": None}


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
