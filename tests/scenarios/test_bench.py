import json
import signal
import time
import tomllib
from dataclasses import dataclass

import pytest

from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from rectmerge.methods import align
from scenarios.bench import read_rows, run
from scenarios.executors import OutOfTimeError, Workers, completed, time_limit
from scenarios.rows import Contender, answer, row_of, rows_of_source
from tests.scenarios.made import Failing, Fixed, Source, grid, pair

CONTRACT = {
    *("task_id", "pair_id", "suite", "place", "method", "outcome", "verdict", "confidence", "candidates", "errors"),
    *("overlap", "seconds", "peak_mb", "reason"),
}


def contender(method=None, label="one"):
    return Contender(label=label, method=method or Fixed())


def outcomes(rows):
    return [(row["pair_id"], row["method"], row["outcome"]) for row in rows]


def row(method, the_pair=None, **options):
    one, the_pair = contender(method), the_pair or pair()
    return row_of(the_pair, one, answer(the_pair, one, **options))


def test_a_right_answer_is_a_full_row():
    scored = row(Fixed(tx=4.3))

    assert set(scored) >= CONTRACT
    assert (scored["outcome"], scored["verdict"], scored["confidence"]) == ("right-accepted", "accepted", 0.75)
    assert scored["errors"]["e_px"] == pytest.approx(0.3)
    assert scored["errors"]["e_over_l"] == pytest.approx(0.3 / (40**2 + 60**2) ** 0.5)
    assert scored["candidates"] == [[[1.0, 0.0, 4.3], [0.0, 1.0, 2.0]]]
    assert scored["seconds"]["wall"] > 0
    assert scored["task_id"] == "made/p0/one"


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
        (Failing(how="hang"), True, "timeout"),
    ],
)
def test_outcome_of_a_row(method, related, expected):
    assert row(method, pair(related=related), timeout_s=0.1)["outcome"] == expected


def test_a_method_is_warmed_up_once_on_a_building_that_it_can_merge():
    seen = []

    @dataclass(frozen=True)
    class Watching(Fixed):
        def align(self, a, b, **options):
            seen.append((a, b))
            return super().align(a, b, **options)

    the_pair, one = pair(), contender(Watching())
    for _ in range(2):
        answer(the_pair, one)

    assert [a is the_pair.a for a, _ in seen] == [False, True, True]
    assert align(*seen[0], method="paper")  # all that a method compiles lies behind a yes


def test_an_error_keeps_its_reason_and_its_traceback():
    scored = row(Failing())

    assert scored["reason"] == "ZeroDivisionError: no rectangles at all"
    assert "in align" in scored["log"]
    assert scored["verdict"] is None


def test_a_pair_that_cannot_be_made_is_an_error_of_every_contender():
    rows = rows_of_source(Source(fails=True), suite="made", contenders=[contender(), contender(label="two")])

    assert outcomes(rows) == [
        ("m0-related", "one", "right-accepted"),
        ("m0-related", "two", "right-accepted"),
        ("m0-unrelated", "one", "error"),
        ("m0-unrelated", "two", "error"),
    ]
    assert "the robot fell over" in rows[-1]["reason"]
    assert rows[0].keys() == rows[-1].keys()


def test_a_pair_that_cannot_be_scored_is_an_error():
    class Unknown(Source):
        def pairs(self):
            yield pair("m0-related", a=OccupancyGrid(0 * grid().occupancy - 1))

    rows = rows_of_source(Unknown(), suite="made", contenders=[contender()])

    assert [row["outcome"] for row in rows] == ["error", "error"]
    assert "no known cell" in rows[0]["reason"]
    assert "ended without it" in rows[1]["reason"]


def test_a_run_writes_its_folder(tmp_path):
    seen = []

    summary = run(
        [Source(), Source(source_id="m1")],
        [contender(), contender(Fixed(verdict="rejected"), "shy")],
        tmp_path / "run",
        suite="made",
        seed=5,
        about={"scenarios": [{"size": (3, 4), "canvas": None}]},
        command="rectbench run made",
        on_rows=seen.extend,
    )

    rows = read_rows(tmp_path / "run")
    settings = tomllib.loads((tmp_path / "run/run.toml").read_text())
    machine = json.loads((tmp_path / "run/machine.json").read_text())
    assert {path.name for path in (tmp_path / "run").iterdir()} == {
        *("run.toml", "machine.json", "results.jsonl", "summary.json")
    }
    assert len(rows) == len(seen) == summary["rows"] == 8
    assert json.loads((tmp_path / "run/summary.json").read_text()) == summary
    assert summary["methods"]["one"]["required"]["right_accepted"]["k"] == 2
    assert summary["methods"]["one"]["unrelated"]["wrong_accepted"]["k"] == 2
    assert summary["methods"]["shy"]["unrelated"]["outcomes"] == {"rejected": 2}
    assert settings["seed"] == 5
    assert settings["scenarios"] == [{"size": [3, 4]}]
    assert settings["methods"][1] == {
        "label": "shy",
        "method": "fixed",
        "set": {"verdict": "rejected", "tx": 4.0, "confidence": 0.75},
    }
    assert machine["command"] == "rectbench run made"
    assert rows[0]["trace"]["ratio"] is None  # strict JSON has no infinity


def test_same_seed_same_rows_and_another_seed_reaches_the_method(tmp_path):
    def draws(name, seed):
        run([Source()], [contender()], tmp_path / name, suite="made", seed=seed)
        return [row["trace"]["draw"] for row in read_rows(tmp_path / name)]

    assert draws("a", 1) == draws("b", 1) != draws("c", 2)


def test_an_earlier_run_is_refused_and_cleared_only_with_force(tmp_path):
    run([Source()], [contender()], tmp_path, suite="made")
    (tmp_path / "notes.txt").write_text("mine")

    with pytest.raises(InputError, match="--force"):
        run([Source()], [contender()], tmp_path, suite="made")
    run([Source()], [contender(label="new")], tmp_path, suite="made", force=True)

    assert {row["method"] for row in read_rows(tmp_path)} == {"new"}
    assert (tmp_path / "notes.txt").exists()


def test_an_interrupted_run_leaves_no_results_under_their_final_name(tmp_path):
    def interrupt(rows):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run([Source()], [contender()], tmp_path, suite="made", on_rows=interrupt)

    assert (tmp_path / "results.jsonl.part").read_text().count("\n") == 2
    with pytest.raises(InputError, match="no finished run"):
        read_rows(tmp_path)
    with pytest.raises(InputError, match="--force"):
        run([Source()], [contender()], tmp_path, suite="made")


def test_labels_differ(tmp_path):
    with pytest.raises(InputError, match="labels must differ"):
        run([Source()], [contender(), contender()], tmp_path, suite="made")


def test_results_do_not_overwrite_a_file(tmp_path):
    (tmp_path / "file").write_text("mine")

    with pytest.raises(InputError, match="is a file"):
        run([Source()], [contender()], tmp_path / "file", suite="made")


@pytest.mark.slow
def test_a_killed_worker_costs_only_the_rows_of_the_method_that_died(tmp_path):
    contenders = [
        contender(),
        contender(Failing(how="killed"), "killed"),
        contender(Failing(how="exit"), "gone"),
    ]
    workers = Workers(2)
    try:
        run([Source(), Source(source_id="m1")], contenders, tmp_path, suite="made", executor=workers)
    finally:
        workers.shutdown()

    rows = read_rows(tmp_path)
    assert len(rows) == 12
    for label, expected in (("killed", {"out-of-memory"}), ("gone", {"error"})):
        assert {row["outcome"] for row in rows if row["method"] == label} == expected
    assert {row["outcome"] for row in rows if row["method"] == "one"} == {"right-accepted", "wrong-accepted"}
    assert any("status 7" in row["reason"] for row in rows)


def test_work_without_an_executor_is_done_in_order():
    assert [(item, future.result()) for item, future in completed(None, abs, [-3, 2])] == [(-3, 3), (2, 2)]


def test_a_time_limit_ends_with_its_body():
    with pytest.raises(OutOfTimeError, match=r"0.05 s"), time_limit(0.05):
        time.sleep(30)
    with time_limit(0.01):
        before = signal.getitimer(signal.ITIMER_REAL)[0]

    assert before > 0
    assert signal.getitimer(signal.ITIMER_REAL)[0] == 0
