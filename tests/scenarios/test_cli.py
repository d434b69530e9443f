import json
import subprocess
import sys
from importlib.metadata import EntryPoint

import pytest

from rectmerge import console, methods
from scenarios import cli
from scenarios.bench import read_rows
from scenarios.cli import app
from tests.scenarios.test_dataset import ROW, UNRELATED, write


@pytest.fixture(autouse=True)
def registry(monkeypatch):
    points = {
        name: EntryPoint(name=name, value=f"tests.scenarios.made:{name.title()}", group=methods.GROUP)
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
    assert "2/2" in shown.err  # progress


def test_failures_are_shown_in_the_table(tmp_path, dataset, capsys):
    status = rectbench("run", dataset, "-m", "failing", "-o", tmp_path / "run", "-q")

    assert status == 0
    assert "0 (0 %" in capsys.readouterr().out
    assert {row["outcome"] for row in read_rows(tmp_path / "run")} == {"error"}


BAD = {
    "no such suite": (["nowhere"], "nowhere"),
    "folder without rows": ([".."], "not a data set"),
    "no such method": (["{dataset}", "-m", "none"], "unknown method 'none'"),
    "no such field": (["{dataset}", "-m", "fixed", "--set", "fixed.nope=1"], "no field 'nope'"),
    "setting of nobody": (["{dataset}", "-m", "fixed", "--set", "other.tx=1"], "no contender is called 'other'"),
    "no setting": (["{dataset}", "-m", "fixed", "--set", "tx"], "METHOD.FIELD=VALUE"),
}


@pytest.mark.parametrize(("words", "message"), BAD.values(), ids=BAD)
def test_bad_input_is_one_line_and_status_2(tmp_path, dataset, capsys, words, message):
    words = [str(tmp_path) if word == ".." else word.format(dataset=dataset) for word in words]

    status = rectbench("run", *words, "-o", tmp_path / "run")

    error = capsys.readouterr().err
    assert status == 2
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "run").exists()


def test_a_second_run_into_the_same_folder_is_refused(tmp_path, dataset, capsys):
    words = ("run", dataset, "-m", "fixed", "-o", tmp_path / "run", "-q")

    assert [rectbench(*words), rectbench(*words), rectbench(*words, "--force")] == [0, 2, 0]
    assert "--force" in capsys.readouterr().err


def test_help_loads_nothing_heavy():
    code = (
        "import sys, scenarios.cli\n"
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

    assert cli._contest("smoke", ["fixed"], []).about["title"] == "Smoke"
    assert cli._contest("headline", ["fixed"], []).about == {}


def test_a_run_of_one_split_is_named_after_its_data_set(tmp_path, dataset):
    rectbench("run", f"{dataset}/test", "-m", "fixed", "-o", tmp_path / "run", "-q")

    assert json.loads((tmp_path / "run/summary.json").read_text())["suite"] == "set"
    assert {row["suite"] for row in read_rows(tmp_path / "run")} == {"set"}
