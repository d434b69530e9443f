import json

import pytest

from rectmerge.errors import InputError
from scenarios.studies.headline import marks_of, write_report


def step(lambda_a=63.0, lambda_b=45.0, lambda_f=180.0, ratio=1.004, cumulative=1.1875, iteration=1, turned=None):
    return {
        "iteration": iteration,
        "cumulative_turn_deg": lambda_f if turned is None else turned,
        "lambda_a_deg": lambda_a,
        "lambda_b_deg": lambda_b,
        "lambda_f_deg": lambda_f,
        "delta_a": [1, 3, 13],
        "delta_b": [2, 3, 19],
        "min_j": 68.0174,
        "ratio": ratio,
        "cumulative_ratio": cumulative,
    }


def row(*steps, ended=True, outcome="right-accepted", seed=0, noise=0, method="paper"):
    return {
        "method": method,
        "suite": "headline",
        "pair_id": f"headline-{seed:04d}-n{noise}",
        "place": f"headline/{seed}",
        "stratum": "required",
        "outcome": outcome,
        "reason": "as made up",
        "trace": {"iterations": list(steps), "ended": ended} if steps else None,
        "info": {"turn_a_deg": 27.0, "turn_b_deg": 225.0},
        "seconds": {"wall": 0.25},
    }


def test_the_papers_own_trace_reaches_every_mark():
    # section IV: Lambda 63.4349 and 45, Lambda_f 180 then 0, ratios 33/32, 38/33 and 1 in three iterations
    marks = marks_of(
        row(
            step(63.4349, 45.0, 180.0, None, 1.0, 1, 180.0),
            step(63.4349, 45.0, 0.0, 33 / 32, 33 / 32, 1, 180.0),
            step(63.4349, 45.0, 0.0, 38 / 33, 38 / 32, 2, 180.0),
            step(63.4349, 45.0, 0.0, 1.0, 38 / 32, 3, 180.0),
        )
    )

    assert marks.residual_deg == pytest.approx(0.4349)
    assert (marks.orientation, marks.quarter_turn, marks.ratio, marks.iterations) == (True, True, True, 3)


@pytest.mark.parametrize(
    ("changed", "missed"),
    [
        ({"lambda_a": 63.51}, "orientation"),
        ({"lambda_b": 44.4}, "orientation"),
        ({"lambda_f": 90.0}, "quarter_turn"),
        ({"lambda_f": 0.0}, "quarter_turn"),
        ({"cumulative": 1.1875 * 1.031}, "ratio"),
        ({"cumulative": 1 / 1.1875}, "ratio"),
    ],
)
def test_each_mark_is_missed_on_its_own(changed, missed):
    marks = marks_of(row(step(**changed)))

    reached = {name: getattr(marks, name) for name in ("orientation", "quarter_turn", "ratio")}
    assert [name for name, hit in reached.items() if not hit] == [missed]


def test_a_residual_is_taken_modulo_a_quarter_turn():
    assert marks_of(row(step(lambda_a=-27.3))).residual_deg == pytest.approx(0.3)


def test_a_loop_that_did_not_end_has_no_iterations():
    assert marks_of(row(step(), step(ratio=1.2), ended=False)).iterations is None


def test_a_row_without_a_trace_misses_every_mark():
    marks = marks_of(row(outcome="error"))

    assert not any((marks.orientation, marks.quarter_turn, marks.ratio, marks.iterations, marks.right))


def write_run(folder, rows):
    folder.mkdir()
    (folder / "results.jsonl").write_text("".join(json.dumps(record) + "\n" for record in rows))
    (folder / "summary.json").write_text("{}")
    (folder / "run.toml").write_text('seed = 0\npairs = 4\n[[methods]]\nlabel = "paper"\nmethod = "paper"\n')
    machine = {"processor": "p", "cores": 2, "system": "s", "python": "3", "packages": {"numpy": "2"}}
    (folder / "machine.json").write_text(json.dumps({**machine, "commit": None, "command": "rectbench run headline"}))
    return folder


def test_the_report_counts_every_row_and_prints_the_trace_of_seed_0(tmp_path):
    rows = [
        row(step()),
        row(step(lambda_f=0.0), step(ratio=1.25), ended=False, outcome="wrong-accepted", seed=1),
        row(outcome="rejected", seed=2),
        row(outcome="error", noise=1),
    ]

    write_report(write_run(tmp_path / "run", rows), tmp_path / "results/README.md")

    text = (tmp_path / "results/README.md").read_text()
    (clean,) = (line for line in text.splitlines() if line.startswith("| paper | 0 | 2 of 3"))
    assert clean.count(" of 3") == 8
    assert "1 in 1" in text
    assert "| paper | 0 | 1 in 1 | 2 of 3 | 1 |" in text
    assert "| 1 | 63.0000 | 45.0000 | 180 | {r1, r3, r13} | {r2, r3, r19} | 68.0174 | 1.0040 | 1.1875 |" in text
    assert "1.2500" not in text  # of seed 1
    assert "headline-0000-n1: error" in text
    assert "reconstruction" in text
    assert "rectbench headline runs/headline -o results/headline/README.md" in text


def test_a_method_without_a_loop_can_be_right():
    assert marks_of({**row(), "trace": {}}).right


def test_a_run_of_an_earlier_version_is_refused(tmp_path):
    old = {**row(), "trace": {"iterations": [{"lambda_f_deg": 0.0}], "ended": True}}

    with pytest.raises(InputError, match="run the suite again"):
        write_report(write_run(tmp_path / "run", [old]), tmp_path / "README.md")


def test_a_method_without_the_papers_loop_has_the_last_marks_only(tmp_path):
    rows = [row(step()), row(method="robust"), row(method="robust", outcome="wrong-accepted", seed=1)]
    run = write_run(tmp_path / "run", rows)
    with (run / "run.toml").open("a") as settings:
        settings.write('[[methods]]\nlabel = "robust"\nmethod = "robust"\n')

    write_report(run, tmp_path / "README.md")

    text = (tmp_path / "README.md").read_text()
    (line,) = (line for line in text.splitlines() if line.startswith("| robust |"))
    assert line.startswith("| robust | 0 | - | - | - | - | 1 of 2 (50 %")
    assert "| 1 of 2 (50 %" in line.removeprefix("| robust | 0 | - | - | - | - | 1 of 2")
    assert "`robust` on headline" not in text


def test_a_run_of_another_suite_is_refused(tmp_path):
    folder = write_run(tmp_path / "run", [{**row(step()), "suite": "smoke"}])

    with pytest.raises(InputError, match="a run of smoke"):
        write_report(folder, tmp_path / "README.md")


def test_a_run_that_is_not_finished_is_refused(tmp_path):
    with pytest.raises(InputError, match="no finished run"):
        write_report(tmp_path, tmp_path / "README.md")


def test_the_report_of_other_seeds_has_a_row_for_every_repair(tmp_path):
    rows = [
        {**row(step(), method=method, seed=50, outcome=outcome), "suite": "headline-test"}
        for method, outcome in (
            ("paper", "rejected"),
            ("paper-repaired", "right-accepted"),
            ("all but specks", "wrong-accepted"),
        )
    ]
    run = write_run(tmp_path / "run", rows)
    with (run / "run.toml").open("a") as settings:
        for label in ("paper-repaired", "all but specks"):
            settings.write(f'[[methods]]\nlabel = "{label}"\nmethod = "paper-repaired"\n')

    write_report(run, tmp_path / "README.md")

    text = (tmp_path / "README.md").read_text()
    assert "| paper-repaired | 1 of 1 | 0 of 1 |" in text
    assert "| all but specks | 0 of 1 | 1 of 1 |" in text
    assert "| all but specks | 0 |" not in text  # no marks of the loop
    assert "`all but specks` on" not in text
    assert "## The trace of headline-0050" in text
    assert "rectbench headline runs/headline-test -o results/headline/README.md" in text
