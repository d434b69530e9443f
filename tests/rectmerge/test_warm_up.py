import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from rectmerge.aligning import align
from rectmerge.cli import console
from rectmerge.cli import main as cli
from rectmerge.elastic.unbend import unbend
from rectmerge.similarity import Similarity
from rectmerge.warm_up import SHIFT_CELLS, WarmUp, small_building, warm_up
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
# In a process of its own, where no other test has used a kernel. A kernel that a command uses for types for which the
# warm-up did not would have been compiled, were it not for the cache.
RUN_AFTER_A_WARM_UP = """
import json, sys
from rectmerge import _kernels
from rectmerge._kernels.compiling import kernels_of
from rectmerge.cli import console
from rectmerge.cli.main import app
from rectmerge.warm_up import warm_up

compiled = warm_up().compiled
said = []
for words in json.loads(sys.argv[1]):
    ready = {kernel: len(kernel.signatures) for kernel in kernels_of(_kernels)}
    status = console.run(app, "rectmerge", words)
    said.append([status, [kernel.__name__ for kernel, count in ready.items() if len(kernel.signatures) > count]])
print(json.dumps([compiled, said]), file=sys.stderr)
"""


def python(code, *words, **environment):
    done = subprocess.run(
        [sys.executable, "-c", code, *words], env=os.environ | environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done


@pytest.mark.slow
def test_a_second_warm_up_compiles_nothing_and_reports_no_progress():
    warm_up()
    calls = []

    assert warm_up(lambda *counts: calls.append(counts)).compiled == 0
    assert calls == []


def test_the_drawn_building_is_one_that_the_methods_accept():
    for method in ("robust", "paper"):  # else they end early, and leave kernels out
        assert align(*small_building(), method=method), method
    a, _ = small_building()
    assert unbend(a, a, Similarity(tx=SHIFT_CELLS, ty=SHIFT_CELLS))


@pytest.mark.slow  # all kernels are loaded, and seven commands run
def test_no_command_compiles_after_a_warm_up(tmp_path):
    for suffix in (".yaml", ".pgm"):
        shutil.copy(drawing.DATA / f"building_a{suffix}", tmp_path)
    names = {
        "A": str(drawing.DATA / "building_a.yaml"),
        "B": str(drawing.DATA / "building_b.yaml"),
        "C": str(tmp_path / "building_a.yaml"),
    }
    lines = [[names.get(word, word).replace("OUT", str(tmp_path / "out")) for word in c.split()] for c in COMMANDS]
    warm_up()

    compiled, said = json.loads(python(RUN_AFTER_A_WARM_UP, json.dumps(lines)).stderr.splitlines()[-1])

    assert compiled == 0  # all came from the cache that this process has filled
    for command, (status, anew) in zip(COMMANDS, said, strict=True):
        assert status in (console.YES, console.NO, console.AMBIGUOUS), command
        assert anew == [], command


@pytest.mark.parametrize(
    ("done", "said"),
    [
        (WarmUp(7, 12.3, Path("cache")), "compiled in 12 s of processor time; kept in cache"),
        (WarmUp(0, 0.1, Path("cache")), "nothing was left to compile; kept in cache"),
        (WarmUp(7, 12.3, None), "not kept: no cache can be written; NUMBA_CACHE_DIR may name one"),
        (WarmUp(0, 0.0, None), "nothing was left to compile"),
    ],
)
def test_the_command_says_what_was_compiled_and_where_it_is_kept(monkeypatch, capsys, done, said):
    monkeypatch.setattr("rectmerge.warm_up.warm_up", lambda progress: done)

    assert console.run(cli.app, "rectmerge", ["warm-up"]) == console.YES

    assert capsys.readouterr().out.rstrip().endswith(said)


def test_the_cache_is_where_numba_is_told_to_keep_it(tmp_path):
    code = "from rectmerge._kernels import compiling, runs; print(compiling.cache_folder(runs.interval_end))"

    assert Path(python(code, NUMBA_CACHE_DIR=str(tmp_path)).stdout).is_relative_to(tmp_path)


def test_where_compilation_is_switched_off_nothing_is_left_to_compile():
    code = "from rectmerge.warm_up import is_first_merge, warm_up; print(is_first_merge(), warm_up().compiled)"

    assert python(code, NUMBA_DISABLE_JIT="1").stdout == "False 0\n"
