import math

import pytest

from rectmerge.errors import InputError
from scenarios.leaderboard.page import page, prediction
from scenarios.leaderboard.plans import REAL, stages
from scenarios.leaderboard.prediction import kendall_tau, matched_overlap, tau_interval
from scenarios.report.reading import Provenance, Runs, TrackResults


def row(method, pair_id, outcome, *, suite="standard", overlap=0.4, stratum="required"):
    is_right = outcome == "right-accepted"
    return {
        "method": method,
        "pair_id": pair_id,
        "suite": suite,
        "place": pair_id,
        "outcome": outcome,
        "stratum": stratum,
        "overlap": overlap,
        "verdict": "accepted",
        "confidence": 0.9 if is_right else 0.4,
        "grades": ["right" if is_right else "off"],
        "errors": {"e_px": 0.5 if is_right else 50.0, "e_over_l": 0.001 if is_right else 0.1},
        "seconds": {"cpu": 0.1, "wall": 0.1},
        "peak_mb": 100.0,
    }


def track_results(suite, right):
    """Each method right on its first so many of ten pairs, the last of them of little overlap."""
    rows = [
        row(
            method,
            f"p{k}",
            "right-accepted" if k < count else "wrong-accepted",
            suite=suite,
            overlap=0.4 if k < 9 else 0.2,
        )
        for method, count in right.items()
        for k in range(10)
    ]
    return TrackResults(suite, "unknown scale", rows)


def runs(*tracks):
    return Runs(list(tracks), [Provenance("rectbench run", "0123456789abcdef", "a machine")], {})


def test_tau_is_what_counting_pairs_by_hand_gives():
    assert kendall_tau([1, 2, 3, 4], [1, 3, 2, 4]) == pytest.approx(4 / 6)
    assert math.isnan(kendall_tau([1, 1], [1, 2]))


def test_equal_rankings_agree_and_opposite_ones_do_not():
    simulated = track_results("standard", {"one": 9, "two": 5, "three": 1})

    same = prediction([simulated, track_results("real_maps", {"one": 8, "two": 4, "three": 0})])
    opposite = prediction([simulated, track_results("real_maps", {"one": 0, "two": 4, "three": 8})])

    assert "**1.00**" in same
    assert "**-1.00**" in opposite
    assert "| one | real | 0 of 1 | 8 of 9 | - | - |" in same


def test_the_interval_of_tau_holds_the_tau_and_is_the_same_again():
    simulated = track_results("standard", {"one": 9, "two": 6, "three": 5, "four": 1})
    real = track_results("real_maps", {"one": 8, "two": 4, "three": 6, "four": 2})
    low, high = tau_interval([simulated], [real])

    assert -1 <= low < kendall_tau([9, 6, 5, 1], [8, 4, 6, 2]) <= high <= 1
    assert tau_interval([simulated], [real]) == (low, high)


def test_the_interval_of_methods_that_are_equal_is_unknown():
    equal = track_results("standard", {"one": 10, "two": 10})

    assert all(map(math.isnan, tau_interval([equal], [equal])))


def test_overlaps_are_matched_in_bins():
    rates = matched_overlap([track_results("standard", {"one": 10})])["one"]

    assert [(rate.k, rate.n) for rate in rates] == [(1, 1), (9, 9), (0, 0), (0, 0)]


def test_without_real_pairs_the_page_says_that_nothing_is_predicted():
    text = page(runs(track_results("standard", {"one": 9, "two": 5})))

    assert "Unknown" in text
    assert text.index("| one | 9 of 10") < text.index("| two | 5 of 10")
    assert "Commit 0123456789ab; a machine." in text


def test_the_stages_are_both_tracks_of_standard_and_the_real_sets_where_they_are(tmp_path):
    for name in REAL:
        (tmp_path / "maps" / name).mkdir(parents=True)
        (tmp_path / "maps" / name / "metadata.jsonl").write_text("{}\n")

    assert [stage.run_name for stage in stages(tmp_path, None)][:3] == ["standard", "standard-known", "headline"]
    assert [stage.run_name for stage in stages(tmp_path, tmp_path / "maps", ["smoke"])] == ["smoke", *REAL]


def test_what_is_not_there_is_refused_before_anything_runs(tmp_path):
    with pytest.raises(InputError, match="there is no real_maps"):
        stages(tmp_path, tmp_path, ["smoke"])
    with pytest.raises(InputError, match="no suite 'nope'"):
        stages(tmp_path, None, ["nope"])
