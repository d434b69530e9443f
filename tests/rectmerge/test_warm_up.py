import os
import shutil
import subprocess
import sys

import pytest

from rectmerge import _kernels
from rectmerge._kernels.compiling import kernels_of
from rectmerge.aligning import align
from rectmerge.elastic.unbend import unbend
from rectmerge.similarity import Similarity
from rectmerge.warm_up import SHIFT_CELLS, small_building, warm_up
from tests import drawing

COMMANDS = (
    "merge A B -o OUT --certify --certify-seconds 1",
    "view OUT --no-open",
    "inspect A -o OUT/rectangles.png",
    "check A B --pixels=1.05,0.58,70,20",
    "merge A B -o OUT --method paper --force",
    "merge A B -o OUT --unbend always --force",
    "merge A B C -o OUT --force",
)


@pytest.mark.slow
def test_a_second_warm_up_compiles_nothing_and_reports_no_progress():
    warm_up()
    calls = []

    assert warm_up(lambda *counts: calls.append(counts)).compiled == 0
    assert calls == []
    assert [k.py_func.__name__ for k in kernels_of(_kernels) if len(k.signatures) > 1] == []  # each compiled once


def test_the_drawn_building_is_one_that_the_methods_accept():
    for method in ("robust", "paper"):  # else they end early, and leave kernels out
        assert align(*small_building(), method=method), method
    a, _ = small_building()
    assert unbend(a, a, Similarity(tx=SHIFT_CELLS, ty=SHIFT_CELLS))


@pytest.mark.slow  # compiles everything anew, half a minute of processor time
def test_the_first_merge_compiles_in_one_wait_and_no_command_after_a_warm_up(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    for suffix in (".yaml", ".pgm"):
        shutil.copy(drawing.DATA / f"building_a{suffix}", tmp_path)
    names = {
        "C": tmp_path / "building_a.yaml",
        "A": drawing.DATA / "building_a.yaml",
        "B": drawing.DATA / "building_b.yaml",
        "OUT": tmp_path / "out",
    }

    def run(line):
        words = [str(names.get(word, word)).replace("OUT", str(names["OUT"])) for word in line.split()]
        code = "from rectmerge.cli.main import main; main()"
        done = subprocess.run([sys.executable, "-c", code, *words], env=environment, capture_output=True, text=True)
        assert done.returncode in (0, 1, 3), done.stderr
        return done

    first = run("merge A B -o OUT-first").stderr

    assert first.count("compiling inner loops") == 1
    assert "inner loops compiled, about" in first
    assert "compiling" not in run("merge A B -o OUT-first --unbend always --force").stderr

    warmed = run("warm-up")

    assert "compiled in" in warmed.stdout
    assert str(tmp_path / "cache") in warmed.stdout
    for line in COMMANDS:
        assert "compiling" not in run(line).stderr, line
    assert "nothing was left to compile" in run("warm-up").stdout
