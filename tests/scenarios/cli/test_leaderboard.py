import tomllib

import pytest

from rectmerge.cli import console
from scenarios.bench.run import read_rows
from scenarios.cli.main import app
from scenarios.dataset.generate import generate
from scenarios.suites.spec import Seeds
from tests.scenarios.tiny_suite import TinySuite


def leaderboard(*words):
    return console.run(app, "rectbench", ["leaderboard", *map(str, words)])


SUITE = """
title = "A small office"

[[scenarios]]
name = "office"
noise = [1]
world = { size_m = [14.0, 10.0], rooms = 6, oblique = 0.0, furniture = 0.0 }
mission = { rays = "compiled", max_seconds = 20, a = { lidar = { beams = 180 } }, b = { lidar = { beams = 180 } } }
"""


@pytest.fixture
def finished(tmp_path):
    """A folder in which one run of the leaderboard is finished, by one method, and none other begun."""
    (tmp_path / "offices.toml").write_text(SUITE)
    words = ["run", tmp_path / "offices.toml", "--method", "paper", "-o", tmp_path / "runs" / "headline", "--quiet"]
    assert console.run(app, "rectbench", [*map(str, words)]) == console.YES
    return tmp_path


@pytest.mark.sim
@pytest.mark.slow
def test_the_pages_of_what_is_finished_leave_out_the_rest_and_run_nothing(finished):
    assert leaderboard("-o", finished, "--finished") == console.YES

    text = (finished / "README.md").read_text(encoding="utf-8")
    assert text.count("\n## ") == 3  # the run's table, the prediction and how it was made
    assert "paper" in text
    assert (finished / "report.html").is_file()
    assert [path.name for path in (finished / "runs").iterdir()] == ["headline"]
    assert not (finished / "sets").exists()


def test_where_no_run_is_finished_that_is_said(tmp_path, capsys):
    assert leaderboard("-o", tmp_path, "--finished") == console.BAD_INPUT

    assert "no run of the leaderboard is finished" in capsys.readouterr().err
    assert not (tmp_path / "README.md").exists()


def test_a_method_is_tuned_on_the_training_pairs_alone(tmp_path, capsys):
    generate(TinySuite(seeds=Seeds(count=4)), tmp_path / "set")  # two buildings of the split train
    words = ["tune", tmp_path / "set", "-o", tmp_path / "run", "-m", "fourier-mellin", "--budget", 2, "--quiet"]

    assert console.run(app, "rectbench", [*map(str, words)]) == console.YES

    (table,) = tomllib.loads(capsys.readouterr().out)["contenders"]
    assert (table["label"], table["method"]) == ("fourier-mellin-tuned", "fourier-mellin")
    rows = read_rows(tmp_path / "run")
    assert {row["method"] for row in rows} == {"fourier-mellin-0", "fourier-mellin-1"}
    assert {row["info"]["split"] for row in rows} == {"train"}
    assert len(rows) == 8
