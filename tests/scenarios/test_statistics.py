import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.errors import InputError
from scenarios.statistics import clustered_rate, mean_of_places, summarise, wilson_interval


def row(outcome="right-accepted", *, place="h", stratum="required", bent=False, e_px=1.0, wall=0.5, confidence=0.8):
    failed = outcome in ("error", "timeout", "out-of-memory")
    right = outcome == "right-accepted"
    return {
        "method": "m",
        "outcome": outcome,
        "place": place,
        "stratum": stratum,
        "bent": bent,
        "verdict": None if failed else "accepted",
        "confidence": None if failed else confidence,
        "grades": None if failed else ["right" if right else "off"],
        "errors": None if failed else {"e_px": e_px},
        "seconds": None if failed else {"wall": wall, "cpu": wall},
    }


def test_wilson_agrees_with_published_figures():
    # Newcombe, Stat. Med. 17 (1998), table I: 81 of 263 and 0 of 20, Wilson without continuity correction
    assert wilson_interval(81 / 263, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson_interval(0.0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)


@given(st.lists(st.tuples(st.booleans(), st.sampled_from("abcd")), min_size=1, max_size=30))
def test_the_interval_holds_the_rate_and_stays_in_range(rows):
    rate = clustered_rate([hit for hit, _ in rows], [place for _, place in rows])

    assert 0 <= rate.low <= rate.k / rate.n <= rate.high <= 1
    assert rate.n == len(rows)


def test_rows_of_one_place_do_not_narrow_the_interval():
    few = clustered_rate([True, False] * 5, list("aabbccddee"))
    same = clustered_rate(([True] * 10 + [False] * 10) * 5, [f"{i}" for i in range(10) for _ in range(10)])
    independent = clustered_rate([True, False] * 50, [str(i) for i in range(100)])

    assert few.n == 10
    assert independent.high - independent.low < 0.25 < same.high - same.low


def test_no_success_in_many_trials_is_not_certainty():
    rate = clustered_rate([False] * 50, [str(i) for i in range(50)])

    assert (rate.k, rate.n, rate.low) == (0, 50, 0.0)
    assert 0.05 < rate.high < 0.1


def test_one_place_says_little_however_often_it_is_run():
    rate = clustered_rate([True] * 40, ["home"] * 40)

    assert rate.low < 0.3


def test_nothing_is_nothing_of_nothing():
    rate = clustered_rate([], [])

    assert (rate.value, rate.low, rate.high, str(rate)) == (None, 0.0, 1.0, "0 of 0")


def test_lengths_must_agree():
    with pytest.raises(InputError, match="2 rows, 1 places"):
        clustered_rate([True, False], ["a"])


def test_places_weigh_the_same_in_their_mean():
    assert mean_of_places([True, True, True, False], ["a", "a", "a", "b"]) == pytest.approx(0.5)


def test_failures_stay_in_every_n():
    rows = [row(), row("error"), row("timeout"), row("out-of-memory"), row("rejected")]

    required = summarise(rows)["m"]["required"]

    assert required["n"] == 5
    assert required["right_accepted"]["n"] == 5
    assert sum(required["outcomes"].values()) == 5


def test_a_row_without_an_answer_counts_as_the_worst_error_in_the_median():
    rows = [row(e_px=1.0), row(e_px=3.0), row("error")]

    assert summarise(rows)["m"]["required"]["median_e_px"] == 3.0
    assert summarise(rows)["m"]["required"]["median_e_px_right"] == 2.0
    assert summarise([row(), row("error")])["m"]["required"]["median_e_px"] is None


def test_bent_rows_are_shown_apart_and_counted_in_their_stratum():
    summary = summarise([row(), row(bent=True), row(stratum="unrelated", outcome="wrong-accepted")])["m"]

    assert {name: part["n"] for name, part in summary.items()} == {"required": 2, "bent": 1, "unrelated": 1}


def test_brier_score_of_known_answers():
    rows = [row(confidence=0.8), row("wrong-accepted", confidence=0.4)]

    assert summarise(rows)["m"]["required"]["brier"] == pytest.approx(np.mean([0.2**2, 0.4**2]))
