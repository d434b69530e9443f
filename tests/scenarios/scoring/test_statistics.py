import pytest
from hypothesis import given
from hypothesis import strategies as st

from rectmerge.errors import InputError
from scenarios.scoring import statistics
from scenarios.scoring.statistics import clustered_difference, clustered_rate, wilson_interval


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


def test_a_difference_is_paired_and_its_interval_is_by_place():
    before, now = [0.0] * 40 + [1.0] * 40, [1.0] * 20 + [0.0] * 20 + [1.0] * 40
    mean, low, high = clustered_difference(now, before, [str(i) for i in range(80)])
    few = clustered_difference(now, before, [str(i // 20) for i in range(80)])

    assert mean == 0.25
    assert 0.15 < low < 0.25 < high < 0.36
    assert few[0] == 0.25
    assert few[1] == 0.0


def test_the_bootstrap_draws_the_same_however_many_at_a_time(monkeypatch):
    hits, places = [True, False, True] * 7, [str(i % 11) for i in range(21)]
    whole = clustered_rate(hits, places)
    monkeypatch.setattr(statistics, "DRAWN_AT_ONCE", 37)

    assert clustered_rate(hits, places) == whole
