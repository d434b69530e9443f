import numpy as np
import pytest

from rectmerge.errors import InputError
from scenarios.studies import trust


def row(outcome="right-accepted", confidence=0.95, *, grade="fine", overlap=0.5, suite="trust", **info):
    verdict = {"r": "accepted", "w": "accepted", "a": "ambiguous"}[outcome[0]]
    return {
        "suite": suite,
        "pair_id": f"test-rigid-0001-{overlap}-n1",
        "place": "house",
        "method": "robust",
        "stratum": "required",
        "overlap": overlap,
        "outcome": outcome,
        "verdict": "rejected" if outcome == "rejected" else verdict,
        "confidence": confidence,
        "grades": [grade],
        "errors": {"e_px": 0.2, "rotation_deg": 0.02, "scale_pct": 0.1},
        "info": {"split": "test", "resolution_a": 0.05, "resolution_b": 0.1, "pose_source": "truth", **info},
    }


WRONG = row("wrong-accepted", 0.97, grade="off", identifiable=False, family="hospital")
ROWS = [row(identifiable=True), WRONG, row("ambiguous-with-truth", 0.5, identifiable=False)]


def test_pairs_that_the_exact_maps_do_not_tell_stand_apart():
    table = trust.overlap_table(ROWS)

    assert "| 0.3 to 1 | identifiable | 1 | 1 of 1" in table
    assert "| 0.3 to 1 | not | 2 | 0 of 2" in table


def test_errors_are_in_cells_of_the_coarser_map():
    assert "| 1 | 0.100 | 0.100 |" in trust.exactness_table(ROWS[:1])


def test_every_wrong_answer_is_listed():
    table = trust.wrong_table(ROWS)

    assert "hospital" in table
    assert "0.970" in table
    assert table.count("\n|") == 2 + 1 - 1
    assert trust.wrong_table(ROWS[:1]) == "None.\n"


@pytest.mark.parametrize(("confidence", "error"), [(0.5, 0.0), (1.0, 0.5), (0.75, 0.25)])
def test_the_calibration_error_is_the_distance_of_confidence_and_truth(confidence, error):
    right = np.tile([0.0, 1.0], 500)

    assert trust.calibration_error(np.full(1000, confidence), right) == pytest.approx(error, abs=0.01)


def test_the_page_holds_all_parts():
    page = trust.page([*ROWS, {**row("rejected", 0.1), "stratum": "unrelated"}], {"runs/trust": "abc"})

    assert "rectbench trust runs/trust" in page
    assert "commit abc" in page
    assert "Brier score" in page
    assert "identifiable" in page


def test_runs_of_other_methods_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(trust, "read_rows", lambda run: [{**ROWS[0], "method": "paper"}])

    with pytest.raises(InputError, match="no rows of robust"):
        trust.write_page([tmp_path], tmp_path / "page.md")
