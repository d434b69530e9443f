import json
import random

import numpy as np
import pytest

from scenarios.scoring.summary import summarise


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


def test_the_order_of_rows_does_not_matter():
    rows = [row(e_px=i / 7, place=str(i % 5), confidence=1 / (1 + i)) for i in range(20)]
    rows += [{**row("error"), "method": "a"}, row("wrong-accepted"), row(stratum="unrelated", outcome="rejected")]
    mixed = random.Random(1).sample(rows, len(rows))

    assert json.dumps(summarise(mixed)) == json.dumps(summarise(rows))


def test_a_confidence_that_is_not_told_is_left_out_of_the_score():
    required = summarise([row(confidence=None), row("wrong-accepted", confidence=0.5)])["m"]["required"]

    assert required["brier"] == 0.25
    assert required["share_of_answers_not_right"] == 0.5


def test_failures_stay_in_every_n():
    rows = [row(), row("error"), row("timeout"), row("out-of-memory"), row("rejected")]

    required = summarise(rows)["m"]["required"]

    assert required["n"] == 5
    assert required["right_accepted"]["n"] == 5
    assert sum(required["outcomes"].values()) == 5


def test_places_weigh_the_same_in_their_mean_however_many_rows_they_have():
    rows = [row(place="a"), row(place="a"), row(place="a"), row("rejected", place="b")]

    required = summarise(rows)["m"]["required"]

    assert required["right_accepted"]["rate"] == 0.75
    assert required["right_accepted_mean_of_places"] == 0.5


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


def test_required_pairs_that_can_be_told_are_shown_apart_from_those_that_cannot():
    rows = [row(), row("rejected"), row("ambiguous-with-truth"), row()]
    for record, can_be_told in zip(rows, (True, True, False, None), strict=True):
        record["info"] = {"identifiable": can_be_told}
    optional = {**row(stratum="optional"), "info": {"identifiable": True}}
    summary = summarise([*rows, optional, {**row("error"), "info": None}])["m"]

    assert summary["required"]["n"] == 5
    assert (summary["identifiable"]["right_accepted"]["k"], summary["identifiable"]["n"]) == (1, 2)
    assert summary["unidentifiable"]["outcomes"] == {"ambiguous-with-truth": 1}
