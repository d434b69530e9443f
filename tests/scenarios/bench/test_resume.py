"""A real `rectbench run` that is killed, interrupted or disturbed, and what the same command makes of it."""

import json
import os
import random
import re
import signal
import sys
import time
from pathlib import Path

import pytest

from scenarios.bench.run import read_rows
from tests.scenarios.command_process import descendants, is_running, start, tiny_pairs

PAIRS = 160
HANGS_S = 120.0  # what has not happened by then never will
SLEEPER = f"import sys, time; time.sleep({3 * HANGS_S})"  # of its own it does not end in time


def timeless(folder):
    rows = [{**row, "seconds": None, "peak_mb": None} for row in read_rows(folder)]
    return sorted(rows, key=lambda row: row["task_id"])


def wait_for(condition):
    ends = time.monotonic() + HANGS_S
    while not (result := condition()):
        assert time.monotonic() < ends
        time.sleep(0.01)
    return result


def ended(pids):
    wait_for(lambda: not any(map(is_running, pids)))
    return True


@pytest.fixture(scope="module")
def pairs(tmp_path_factory):
    return tiny_pairs(tmp_path_factory.mktemp("set") / "set", PAIRS)


@pytest.fixture(scope="module")
def whole(tmp_path_factory, pairs):
    """An undisturbed run of the pairs."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    assert start("run", pairs, "-m", "paper", "-o", folder, "-q").wait() == 0
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_killed_at_random_rows_a_run_ends_with_the_rows_of_an_undisturbed_one(tmp_path, pairs, whole, workers):
    words = ("run", pairs, "-m", "paper", "-o", tmp_path / "cut", "--workers", workers, "-q")
    draw, file = random.Random(workers), tmp_path / "cut/results.jsonl"
    for _ in range(3):
        process, least = start(*words), lines_in(file) + draw.randrange(40)
        wait_for(lambda: lines_in(file) >= least)  # noqa: B023
        below = descendants(process.pid)
        process.kill()
        assert process.wait() == -signal.SIGKILL
        assert ended(below)  # nothing is left that could still write
    again = start(*words)

    assert again.wait() == 0
    assert timeless(tmp_path / "cut") == timeless(whole)
    assert lines_in(file) == PAIRS


def lines_in(file):
    return file.read_bytes().count(b"\n") if file.exists() else 0


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_ctrl_c_ends_everything_and_says_how_to_go_on(tmp_path, pairs, workers):
    command = f"{sys.executable} -c '{SLEEPER}' {{a}} {{b}}"
    words = ("run", pairs, "--method-command", command, "-o", tmp_path / "run", "--workers", workers)
    with (tmp_path / "said").open("wb") as said:
        process = start(*words, stderr=said)
    wait_for(lambda: len(below := descendants(process.pid)) >= 2 * workers and any(map(is_sleeper, below)))
    below = descendants(process.pid)

    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    status = process.wait(HANGS_S)

    assert status == 130
    assert ended(below)
    assert (tmp_path / "said").read_text().splitlines() == [
        f"rectbench: {tmp_path / 'run'} keeps what is done; the same command goes on from there",
        "rectbench: interrupted",
    ]


def is_sleeper(pid):
    try:
        return SLEEPER.encode() in Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return False


@pytest.mark.slow
def test_ctrl_c_leaves_a_cluster_and_says_how_to_go_on(tmp_path, pairs, dask_cluster):
    command = f"{sys.executable} -c '{SLEEPER}' {{a}} {{b}}"
    words = ("run", pairs, "--method-command", command, "-o", tmp_path / "run", "--cluster")
    with (tmp_path / "said").open("wb") as said:
        process = start(*words, dask_cluster.scheduler_address, stderr=said)
    wait_for(lambda: any(map(is_sleeper, descendants(os.getpid()))))

    os.killpg(process.pid, signal.SIGINT)
    status = process.wait(HANGS_S)

    assert status == 130
    assert (tmp_path / "said").read_text().splitlines() == [
        f"rectbench: {tmp_path / 'run'} keeps what is done; the same command goes on from there",
        "rectbench: interrupted",
    ]


SUITE = """
title = "Three small offices"

[[scenarios]]
name = "office"
seeds = { count = 3 }
noise = [0, 1]
world = { size_m = [14.0, 10.0], rooms = 6, oblique = 0.0, furniture = 0.0 }
mission = { rays = "compiled", max_seconds = 20, a = { lidar = { beams = 180 } }, b = { lidar = { beams = 180 } } }
"""


@pytest.mark.slow
@pytest.mark.sim
def test_killed_at_random_moments_a_run_of_a_suite_keeps_the_data_set_and_rows_of_an_undisturbed_one(tmp_path):
    def words(out):
        return "run", tmp_path / "offices.toml", "-m", "paper", "-o", out, "--workers", 2, "-q"

    (tmp_path / "offices.toml").write_text(SUITE)
    assert start(*words(tmp_path / "whole")).wait() == 0
    draw, kills, kept = random.Random(5), 0, tmp_path / "cut/dataset"
    for is_keeping in (True, False, True):
        process, before = start(*words(tmp_path / "cut")), names_in(kept)
        wait_for(lambda: process.poll() is not None or not is_keeping or names_in(kept) - before)  # noqa: B023
        time.sleep(draw.uniform(0.0, 0.02 if is_keeping else 6.0))
        below = descendants(process.pid)
        process.kill()
        if process.wait() == 0:
            break
        kills += 1
        assert ended(below)

    assert kills >= 2
    assert start(*words(tmp_path / "cut")).wait() == 0
    assert timeless(tmp_path / "cut") == timeless(tmp_path / "whole")
    assert names_in(kept) == names_in(tmp_path / "whole/dataset")
    assert all(
        (kept / name).read_bytes() == (tmp_path / "whole/dataset" / name).read_bytes() for name in names_in(kept)
    )


def names_in(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*.*")}


@pytest.mark.slow
def test_a_second_run_into_a_folder_is_refused_while_the_first_lives(tmp_path, pairs):
    words = ("run", pairs, "-m", "paper", "-o", tmp_path / "run")
    first = start(*words)
    wait_for((tmp_path / "run/run.toml").exists)
    os.kill(first.pid, signal.SIGSTOP)
    try:
        with (tmp_path / "said").open("wb") as said:
            assert start(*words, stderr=said).wait() == 2
        assert "another process is writing into it" in (tmp_path / "said").read_text()
    finally:
        first.kill()
    first.wait()

    assert start(*words).wait() == 0
    assert len(read_rows(tmp_path / "run")) == PAIRS


@pytest.mark.slow
def test_progress_is_shown_on_a_terminal_only(tmp_path, pairs):
    ours, theirs = os.openpty()
    words = ("run", pairs, "-m", "paper", "-o", tmp_path / "run", "--json")
    with (tmp_path / "summary").open("wb") as summary:
        process = start(*words, stdout=summary, stderr=theirs)
    os.close(theirs)
    shown = b""
    while True:
        try:
            shown += os.read(ours, 4096)
        except OSError:  # how a terminal ends whose last writer is gone
            break

    os.close(ours)
    assert process.wait() == 0
    assert json.loads((tmp_path / "summary").read_text())["rows"] == PAIRS
    assert f"{PAIRS}/{PAIRS}".encode() in shown
    assert re.search(rb"\d/min", shown)
    assert b"left" in shown


@pytest.mark.slow
def test_the_parents_memory_does_not_grow_with_thousands_of_pairs_and_their_time_only_with_their_number(tmp_path):
    def measured(count):
        pairs = tiny_pairs(tmp_path / f"set{count}", count)
        process = start("run", pairs, "-m", "paper", "-o", tmp_path / f"run{count}", "--workers", 2)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        return used.ru_maxrss / 1024, used.ru_utime + used.ru_stime

    few_mb, few_seconds = measured(200)
    many_mb, seconds = measured(1_400)

    assert many_mb < few_mb + 4  # 3 kB a pair
    assert seconds < 3 * 7 * few_seconds  # of processor time; 49 times as much, were it the square
