import json

import pytest

from rectmerge.errors import InputError
from scenarios.studies.compare import compare_runs


def row(number, outcome="right-accepted", *, method="m", stratum="required", e_px=1.0, bent=False, identifiable=None):
    return {
        "task_id": f"{number:016x}",
        "pair_id": f"p{number}",
        "suite": "s",
        "reason": "",
        "method": method,
        "place": f"h{number // 2}",
        "stratum": stratum,
        "bent": bent,
        "info": {"identifiable": identifiable},
        "outcome": outcome,
        "errors": None if outcome in ("error", "rejected") else {"e_px": e_px},
    }


@pytest.fixture
def compared(tmp_path):
    def compare(now, before):
        for name, rows in (("now", now), ("before", before)):
            (tmp_path / name).mkdir(exist_ok=True)
            (tmp_path / name / "summary.json").write_text("{}")
            (tmp_path / name / "results.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
        return compare_runs(tmp_path / "now", tmp_path / "before")

    return compare


def test_a_run_does_not_regress_against_itself(compared):
    rows = [row(i, "rejected" if i % 3 else "right-accepted") for i in range(30)]

    same = compared(rows, rows[::-1])

    assert same.regressions == []
    assert same.page().startswith("No regression.")
    assert "| required | 30 | right, accepted | 10 (33.3 %) | 10 (33.3 %) | +0.0 (+0.0 to +0.0) |  |" in same.page()


DAMAGED = {
    "no id": ({"pair_id": None}, "pair_id must be text, got None"),
    "another outcome": ({"outcome": "splendid"}, "outcome must be one of"),
    "an error below zero": ({"errors": {"e_px": -1.0}}, "e_px must be a number from 0"),
    "400 digits": ({"errors": {"e_px": 10**400}}, "e_px must be a number from 0"),
    "text for errors": ({"errors": "none"}, "errors must be of type dict or null"),
}


@pytest.mark.parametrize(("changes", "message"), DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_row_is_refused_with_its_line(compared, changes, message):
    with pytest.raises(InputError, match=f"results.jsonl:2: not a row of a run: {message}"):
        compared([row(0), row(1) | changes], [row(0)])


def test_nesting_without_end_is_refused(compared, tmp_path):
    compared([row(0)], [row(0)])
    (tmp_path / "now/results.jsonl").write_text("[" * 100_000 + "\n")

    with pytest.raises(InputError, match=r"results\.jsonl:1: not JSON"):
        compare_runs(tmp_path / "now", tmp_path / "before")


CHANGES = {
    "fewer right": ([row(0, "rejected")], [row(0)], "right, accepted"),
    "more wrong": ([row(0, "wrong-accepted")], [row(0, "rejected")], "wrong, accepted"),
    "false merge": (
        [row(0, "wrong-accepted", stratum="unrelated")],
        [row(0, "rejected", stratum="unrelated")],
        "wrong, accepted",
    ),
    "more failures": ([row(0, "error")], [row(0, "rejected")], "failed"),
    "less often ambiguous": (
        [row(0, identifiable=False)],
        [row(0, "ambiguous-with-truth", identifiable=False)],
        "ambiguous, with the truth",
    ),
    "larger error": ([row(i, e_px=1.3) for i in range(9)], [row(i) for i in range(9)], "median error, cells"),
}


@pytest.mark.parametrize(("now", "before", "what"), CHANGES.values(), ids=CHANGES)
def test_what_became_worse_is_a_regression_and_its_reverse_is_none(compared, now, before, what):
    rest = [row(i, stratum=before[0]["stratum"]) for i in range(20, 29)] if what != "median error, cells" else []

    assert [line.what for line in compared(now + rest, before + rest).regressions] == [what]
    assert "**worse**" in compared(now + rest, before + rest).page()
    assert what not in [line.what for line in compared(before + rest, now + rest).regressions]


def test_a_change_within_the_tolerance_is_none(compared):
    before = [row(i, e_px=1.0) for i in range(100)]
    now = [row(0, "rejected"), *(row(i, e_px=1.08) for i in range(1, 100))]

    assert compared(now, before).regressions == []


def test_differences_are_of_the_same_pairs_and_the_rest_is_told(compared):
    now, before = [row(i) for i in range(10)], [row(i, "rejected") for i in range(5, 25)]

    comparison = compared(now, before)

    assert comparison.lines[0].n == 5
    assert comparison.notes == [
        "5 of 10 rows of the run have no partner and are left out.",
        "15 of 20 rows of the baseline have no partner and are left out.",
    ]


def test_methods_and_strata_have_their_own_lines(compared):
    rows = [row(0), row(0, method="n"), row(1, stratum="unrelated", outcome="rejected"), row(2, bent=True)]

    lines = {(line.method, line.stratum) for line in compared(rows, rows).lines}

    assert lines == {("m", "required"), ("n", "required"), ("m", "unrelated"), ("m", "bent")}


def test_what_cannot_be_compared_is_refused(compared, tmp_path):
    with pytest.raises(InputError, match="no pair and method in common"):
        compared([row(0)], [row(1)])
    with pytest.raises(InputError, match="no finished run"):
        compare_runs(tmp_path / "nowhere", tmp_path / "before")
    (tmp_path / "now/summary.json").unlink()
    with pytest.raises(InputError, match="no finished run"):
        compare_runs(tmp_path / "now", tmp_path / "before")
    (tmp_path / "now/results.jsonl").write_text('{"task_id": "1"}\n')
    with pytest.raises(InputError, match="not a row of a run"):
        compare_runs(tmp_path / "now/results.jsonl", tmp_path / "before")
