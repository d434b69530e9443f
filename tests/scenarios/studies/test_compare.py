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


def test_one_pair_lost_of_a_hundred_is_a_regression_and_one_won_is_none(compared):
    rows = [row(i) for i in range(100)]
    fewer = [row(0, "rejected"), *rows[1:]]

    assert [line.what for line in compared(fewer, rows).regressions] == ["right, accepted"]
    assert compared(rows, fewer).regressions == []


def test_a_larger_error_within_the_tolerance_is_none(compared):
    before, now = ([row(i, e_px=e_px) for i in range(100)] for e_px in (1.0, 1.08))

    assert compared(now, before).regressions == []


def timed(seconds, method="m", count=20):
    """Rows of pairs whose answers take different times."""
    times = [seconds * (1 + 0.3 * (i % 4)) for i in range(count)]
    return [row(i, method=method) | {"seconds": {"cpu": cpu, "wall": 1.0}} for i, cpu in enumerate(times)]


MACHINE = {"processor": "A", "cores": 2, "python": "3.11.7"}
SPEEDS = {
    "6 % slower": (timed(0.106), timed(0.1), ["median CPU s"]),
    "6 % faster": (timed(0.1), timed(0.106), []),
    "4 % slower": (timed(0.104), timed(0.1), []),
    "a machine twice as slow": (
        timed(0.2) + timed(0.06, "keypoints-akaze"),
        timed(0.1) + timed(0.03, "keypoints-akaze"),
        [],
    ),
    "slower on a faster machine": (
        timed(0.06) + timed(0.015, "keypoints-akaze"),
        timed(0.1) + timed(0.03, "keypoints-akaze"),
        ["median CPU s"],
    ),
    "too short to tell": (timed(0.003), timed(0.001), []),
    "one slow answer among many": ([*timed(0.1, count=19), timed(0.4)[19]], timed(0.1), []),
}


@pytest.mark.parametrize(("now", "before", "worse"), SPEEDS.values(), ids=SPEEDS)
def test_five_percent_of_a_speed_ratio_are_a_regression(compared, tmp_path, now, before, worse):
    for name in ("now", "before"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "machine.json").write_text(json.dumps(MACHINE))

    assert [line.what for line in compared(now, before).regressions] == worse


def test_times_of_two_machines_are_compared_by_the_yardstick_only(compared, tmp_path):
    for name, processor in (("now", "A"), ("before", "B")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "machine.json").write_text(json.dumps({**MACHINE, "processor": processor}))

    alone = compared(timed(0.2), timed(0.1))
    assert alone.regressions == []
    assert "Times are not compared: on two machines" in alone.page()

    beside = compared(timed(0.2) + timed(0.03, "keypoints-akaze"), timed(0.1) + timed(0.03, "keypoints-akaze"))
    assert [(line.method, line.difference) for line in beside.regressions] == [("m", "+100.0 % (+100.0 to +100.0)")]
    assert "over that of `keypoints-akaze`" in beside.page()


@pytest.mark.parametrize(("processor", "worse"), [("A", ["right, accepted", "failed"]), ("B", []), (None, [])])
def test_a_timeout_more_is_a_regression_on_one_machine_only(compared, tmp_path, processor, worse):
    for name, found in (("now", processor), ("before", "A")):
        (tmp_path / name).mkdir()
        if found:
            (tmp_path / name / "machine.json").write_text(json.dumps({**MACHINE, "processor": found}))
    before = [row(i) for i in range(9)]
    late = [row(0, "timeout"), *before[1:]]

    comparison = compared(late, before)

    assert [line.what for line in comparison.regressions] == worse
    assert "| failed | 0 (0.0 %) | 1 (11.1 %)" in comparison.page()
    assert ("Timeouts of the run alone, 1 rows, are not counted as worse" in comparison.page()) == (not worse)
    lost = [*late[:1], row(1, "rejected"), row(2, "error"), *late[3:]]
    assert [line.what for line in compared(lost, before).regressions] == ["right, accepted", "failed"]


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
