import pytest

from scenarios.scoring.bends import BendTally


def row(before=10.0, after=5.0, *, accepted=True, walls=(0.5, 0.1)):
    bend = {
        "accepted": accepted,
        "reason": "as told",
        "e_px": after,
        "double_walls_before": walls[0],
        "double_walls_after": walls[1],
    }
    return {"errors": None if before is None else {"e_px": before}, "bend": bend}


def summary(*rows):
    tally = BendTally()
    for record in rows:
        tally.add(record)
    return tally.summary()


def test_a_change_of_more_than_a_tenth_counts():
    found = summary(row(10, 8.9), row(10, 9.1), row(10, 10.9), row(10, 11.1), row(10, 10, accepted=False))

    assert (found["tried"], found["accepted"], found["better"], found["worse"]) == (5, 4, 1, 1)
    assert (found["median_e_px_before"], found["median_e_px_after"]) == (10.0, 10.0)
    assert (found["mean_double_walls_before"], found["mean_double_walls_after"]) == pytest.approx((0.5, 0.1))


def test_unrelated_pairs_and_rows_without_a_bend_have_no_error():
    found = summary(row(None, None), row(walls=(None, None)), {"errors": {"e_px": 1.0}}, {"errors": None, "bend": None})

    assert (found["tried"], found["accepted"]) == (2, 2)
    assert (found["median_e_px_before"], found["median_e_px_after"]) == (10.0, 5.0)
    assert found["mean_double_walls_before"] == 0.5


def test_nothing_bent_has_no_medians():
    assert summary(row(accepted=False))["median_e_px_before"] is None
