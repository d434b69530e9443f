import json

import numpy as np
import pytest

from rectmerge.cli import console
from rectmerge.io.map_file import read_map
from scenarios.bench.run import read_rows
from scenarios.cli.main import app
from tests.marking import some_slow
from tests.sim.carmen_logs import flaser, office_walk, robotlaser, write_log
from tests.sim.small_worlds import wall_distance

WALK = office_walk()


@pytest.fixture
def log(tmp_path):
    return write_log(tmp_path / "a walk.log", robotlaser(WALK, is_corrected=True))


def rectbench(*words):
    return console.run(app, "rectbench", [str(word) for word in words])


def test_a_log_becomes_a_map(tmp_path, log, capsys):
    status = rectbench("carmen", log, "-o", tmp_path / "map", "--resolution", 0.04, "--quiet")

    shown = capsys.readouterr()
    grid = read_map(tmp_path / "map" / "map.yaml")
    walls = grid.pixel_to_map(np.argwhere(grid.occupied)[:, ::-1].astype(float))
    assert (status, shown.err) == (0, "")
    assert "188 scans with movement, by the log's poses" in shown.out
    assert sorted(path.name for path in (tmp_path / "map").iterdir()) == ["map.pgm", "map.yaml"]
    assert wall_distance(WALK.world, walls).mean() < 0.03


def test_an_earlier_map_is_replaced_only_if_told(tmp_path, log, capsys):
    words = ("carmen", log, "-o", tmp_path / "map")

    assert [rectbench(*words), rectbench(*words), rectbench(*words, "--force")] == [0, 2, 0]
    assert "holds earlier results (map.yaml); --force clears them" in capsys.readouterr().err


@pytest.mark.parametrize("is_corrected", some_slow([True, False], True))
def test_a_log_becomes_a_data_set_that_verify_accepts_and_run_scores(tmp_path, capsys, is_corrected):
    log = write_log(tmp_path / "walk.clf", flaser(WALK, is_corrected=is_corrected))
    words = ("--pairs", 2, "--cut", 0.45, "--shared", 0.1, "--resolution-b", 0.06, "--seed", 3)
    made = rectbench("carmen", log, "-o", tmp_path / "set", *words)
    verified = rectbench("verify", tmp_path / "set", "-q")
    ran = rectbench("run", tmp_path / "set", "-m", "robust", "-o", tmp_path / "run", "-q")

    card = (tmp_path / "set" / "README.md").read_text()
    rows = read_rows(tmp_path / "run")
    assert (made, verified, ran) == (0, 0, 0), capsys.readouterr().err
    assert [row["outcome"] for row in rows] == ["right-accepted"] * 2
    assert "rectbench carmen walk.clf -o DATASET --pairs 2 --resolution 0.05 --cut 0.45 --shared 0.1" in card


@pytest.mark.slow
def test_the_same_words_give_the_same_bytes(tmp_path, log):
    sums = []
    for folder in ("first", "second"):
        rectbench("carmen", log, "-o", tmp_path / folder, "--pairs", 1, "-q")
        sums.append(json.loads((tmp_path / folder / "dataset_info.json").read_text())["checksums"])

    assert sums[0] == sums[1]
    assert any(name.endswith("_b.png") for name in sums[0])


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("--seed", 1), "--seed says how pairs are made: give --pairs N too"),
        (("--cut", 0.2), "--cut says how pairs are made"),
        (("--pairs", 1, "--cut", 2.0), "cut must be 0.1 to 0.9"),
        (("--pairs", 1, "--resolution", 7.0), "resolution must be 0.005 to 1"),
        (("--resolution", 0.0), "resolution must be a positive number"),
        (("--poses", "odometry"), "poses must be one of auto, log, match, got 'odometry'"),
        (("--every", 40), "of 5 scans have movement; a map needs 10"),
    ],
)
def test_bad_words_end_in_one_line(tmp_path, log, capsys, words, complaint):
    status = rectbench("carmen", log, "-o", tmp_path / "out", *words)

    shown = capsys.readouterr()
    assert status == 2
    assert complaint in shown.err
    assert shown.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_no_log_ends_in_one_line(tmp_path, capsys):
    status = rectbench("carmen", write_log(tmp_path / "x.log", b"hello\n"), "-o", tmp_path / "out")

    assert status == 2
    assert "x.log: there is no scan in it" in capsys.readouterr().err


def test_cuts_that_make_no_pair_say_why(tmp_path, capsys):
    far = WALK.poses + np.where(np.arange(len(WALK.poses)) < len(WALK.poses) // 2, 0.0, 100.0)[:, None] * [1, 0, 0]
    log = write_log(tmp_path / "far.log", flaser(WALK.replaced(poses=far), is_corrected=True))
    status = rectbench("carmen", log, "-o", tmp_path / "out", "--pairs", 1)

    assert status == 2
    assert "the parts before and after 0.50 of the log show too few surfaces" in capsys.readouterr().err
