import json
import re
import subprocess
import sys
from importlib.metadata import EntryPoint

import pytest

from rectmerge import methods
from rectmerge.cli import console
from rectmerge.errors import InputError
from scenarios.bench.plan import plan_run
from scenarios.bench.run import read_rows
from scenarios.cli.main import app
from tests.scenarios.dataset.test_reader import ROW, UNRELATED, write


@pytest.fixture(autouse=True)
def registry(monkeypatch):
    points = {
        name: EntryPoint(name=name, value=f"tests.scenarios.known_answers:{name.title()}", group=methods.GROUP)
        for name in ("fixed", "failing")
    }
    monkeypatch.setattr(methods, "available", lambda: points)


@pytest.fixture
def dataset(tmp_path):
    return str(write(tmp_path / "set", [ROW, {**UNRELATED, "pair_id": "q"}]))


def rectbench(*words):
    return console.run(app, "rectbench", [str(word) for word in words])


def test_run_scores_a_data_set_and_ends_with_yes(tmp_path, dataset, capsys):
    status = rectbench("run", dataset, "--method", "fixed", "--set", "fixed.tx=5", "-o", tmp_path / "run", "--quiet")

    shown = capsys.readouterr()
    rows = read_rows(tmp_path / "run")
    assert status == 0
    # ROW's truth is a shift by (5, 0); the method always answers (5, 2)
    assert [(row["pair_id"], row["errors"] and row["errors"]["e_px"]) for row in rows] == [
        ("p", pytest.approx(2.0)),
        ("q", None),
    ]
    assert "right: accepted and right" in shown.out
    assert shown.err == ""


def test_run_prints_the_summary_as_json(tmp_path, dataset, capsys):
    rectbench("run", dataset, "--method", "fixed", "-o", tmp_path / "run", "--json")

    shown = capsys.readouterr()
    assert json.loads(shown.out) == json.loads((tmp_path / "run/summary.json").read_text())
    assert shown.err == ""  # no terminal, no progress


def test_failures_are_shown_in_the_table(tmp_path, dataset, capsys):
    status = rectbench("run", dataset, "-m", "failing", "-o", tmp_path / "run", "-q")

    assert status == console.NO  # not one answer
    assert "0 (0 %" in capsys.readouterr().out
    assert {row["outcome"] for row in read_rows(tmp_path / "run")} == {"error"}


BAD = {
    "no such suite": (["nowhere"], "nowhere"),
    "folder without rows": ([".."], "not a data set"),
    "no such method": (["{dataset}", "-m", "none"], "unknown method 'none'"),
    "no such field": (["{dataset}", "-m", "fixed", "--set", "fixed.nope=1"], "no field 'nope'"),
    "setting of nobody": (["{dataset}", "-m", "fixed", "--set", "other.tx=1"], "no contender is called 'other'"),
    "no limit": (["{dataset}", "-m", "fixed", "--timeout", "0"], "limits must be > 0"),
    "no place for a map": (["{dataset}", "--method-command", "true {a}"], "must hold {b} or {b_yaml}"),
    "no such program": (
        ["{dataset}", "--method-command", "nowhere/prog {a} {b}"],
        "there is no program",
    ),
    "two places to work": (["{dataset}", "--workers", "2", "--cluster", "tcp://x:1"], "exclude each other"),
    "no setting": (["{dataset}", "-m", "fixed", "--set", "tx"], "METHOD.FIELD=VALUE"),
}


@pytest.mark.parametrize(("words", "message"), BAD.values(), ids=BAD)
def test_bad_input_is_one_line_and_status_2(tmp_path, dataset, capsys, words, message):
    words = [str(tmp_path) if word == ".." else word.replace("{dataset}", dataset) for word in words]

    status = rectbench("run", *words, "-o", tmp_path / "run")

    error = capsys.readouterr().err
    assert status == 2
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "run").exists()


def test_a_finished_run_run_again_says_so_and_shows_its_summary(tmp_path, dataset, capsys):
    words = ("run", dataset, "-m", "fixed", "-o", tmp_path / "run", "--json")
    rectbench(*words)
    before, summary = (tmp_path / "run/results.jsonl").read_bytes(), capsys.readouterr().out

    assert rectbench(*words) == 0
    assert capsys.readouterr() == (summary, "rectbench: nothing is left to do\n")
    assert (tmp_path / "run/results.jsonl").read_bytes() == before


def test_a_folder_that_holds_another_run_is_refused_unless_forced(tmp_path, dataset, capsys):
    words = ("run", dataset, "-m", "fixed", "-o", tmp_path / "run", "-q")
    other = (*words, "--seed", "3")

    assert [rectbench(*words), rectbench(*other), rectbench(*other, "--force")] == [0, 2, 0]
    assert "another seed); --force clears it" in capsys.readouterr().err


def test_a_comparison_ends_with_no_on_a_regression(tmp_path, dataset, capsys):
    for name, words in (("old", ["--set", "fixed.tx=5", "--set", "fixed.verdict=rejected"]), ("new", [])):
        rectbench("run", dataset, "-m", "fixed", *words, "-o", tmp_path / name, "-q")
    capsys.readouterr()

    assert rectbench("compare", tmp_path / "new", tmp_path / "old") == 1
    assert "**Regression**: fixed, required: wrong, accepted; fixed, unrelated" in capsys.readouterr().out
    assert rectbench("compare", tmp_path / "old", tmp_path / "new/results.jsonl") == 0
    assert rectbench("compare", tmp_path / "old", tmp_path / "nowhere") == 2


def test_a_program_is_put_to_the_pairs_beside_a_method(tmp_path, dataset):
    program = tmp_path / "shift.py"
    program.write_text("print('1 0 5  0 1 0  0.5')")
    command = f"{sys.executable} {program} {{a}} {{b}}"

    status = rectbench("run", dataset, "--method-command", command, "-m", "fixed", "-o", tmp_path / "run", "-q")

    outcomes = {(row["method"], row["pair_id"]): row["outcome"] for row in read_rows(tmp_path / "run")}
    assert status == 0
    assert outcomes["shift", "p"] == "right-accepted"
    assert len(outcomes) == 4


def test_a_run_whose_folder_is_removed_in_the_middle_ends_in_one_line(tmp_path, dataset, capsys):
    program = tmp_path / "remove.py"
    program.write_text(f"import shutil; shutil.rmtree({str(tmp_path / 'run')!r}, True); print('rejected')")
    command = f"{sys.executable} {program} {{a}} {{b}}"

    assert rectbench("run", dataset, "--method-command", command, "-o", tmp_path / "run", "-q") == console.BAD_INPUT
    assert re.fullmatch(r"rectbench: [^\n]*run[^\n]* cannot be read: [^\n]*\n", capsys.readouterr().err)


def test_a_run_of_errors_alone_ends_with_no_and_the_first_reason(tmp_path, dataset, capsys):
    command = f"broken={sys.executable} -S -c 'raise SystemExit(3)' {{a}} {{b}}"

    assert rectbench("run", dataset, "--method-command", command, "-o", tmp_path / "run") == console.NO
    assert (
        "every answer failed, the first by: error: ProgramError: broken died with status 3" in capsys.readouterr().err
    )


def test_h_is_help(capsys):
    for words in (["-h"], ["run", "-h"]):
        assert rectbench(*words) == 0
        assert "Usage: rectbench" in capsys.readouterr().out


def test_help_loads_nothing_heavy():
    code = (
        "import sys, scenarios.cli.main\n"
        "heavy = {'numpy', 'cv2', 'numba', 'pybullet', 'matplotlib', 'shapely'} & set(sys.modules)\n"
        "sys.exit(str(sorted(heavy)) if heavy else 0)"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert ended.returncode == 0, ended.stderr


@pytest.mark.parametrize(("word", "named"), [("worlds", "office"), ("suites", "headline")])
def test_worlds_and_suites_are_listed(capsys, word, named):
    assert rectbench(word, "--quiet") == 0
    assert named in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["ofice", "-o", "x.png"], "no family 'ofice'"),
        (["office"], "-o PICTURE.png"),
        (["-o", "x.png"], "name a family or a file"),
        (["--seed", "1"], "name a family or a file"),
    ],
)
def test_a_world_that_cannot_be_drawn_is_one_line_and_status_2(tmp_path, monkeypatch, capsys, words, message):
    monkeypatch.chdir(tmp_path)

    assert rectbench("worlds", *words) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.sim
def test_a_world_is_drawn_and_told(tmp_path, capsys):
    assert rectbench("worlds", "office", "--seed", "2", "-o", tmp_path / "office.png") == 0

    shown = capsys.readouterr()
    assert "office, seed 2" in shown.out
    assert str(tmp_path / "office.png") in shown.out
    assert shown.err == ""
    assert (tmp_path / "office.png").exists()


def test_a_folder_that_is_no_data_set_does_not_hide_a_suite_of_its_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "smoke").mkdir()
    write(tmp_path / "headline", [ROW])

    assert plan_run("smoke", ["fixed"]).about["title"] == "Smoke"
    assert plan_run("headline", ["fixed"]).about == {"dataset": str(tmp_path / "headline")}


def test_cell_noise_is_asked_of_suites_not_of_data_sets(tmp_path):
    write(tmp_path / "set", [ROW])

    plan = plan_run("smoke", ["fixed"], cell_noise=True)
    assert plan.about["version"] == 1
    assert plan.sources[0].pair_ids == ("upright-0000-n0", "upright-0000-ncells-1")
    assert plan_run("smoke", ["fixed"]).about["version"] == 2
    with pytest.raises(InputError, match="generate it with --cell-noise"):
        plan_run(str(tmp_path / "set"), ["fixed"], cell_noise=True)


def test_a_run_of_one_split_is_named_after_its_data_set(tmp_path, dataset):
    rectbench("run", f"{dataset}/test", "-m", "fixed", "-o", tmp_path / "run", "-q")

    assert json.loads((tmp_path / "run/summary.json").read_text())["suite"] == "set"
    assert {row["suite"] for row in read_rows(tmp_path / "run")} == {"set"}
