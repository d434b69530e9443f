import functools
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rectmerge.errors import InputError
from scenarios.execution.limits import Limits, call_within, stop_children

QUICK = Limits(timeout_s=0.4)


def in_background(seconds):
    """Start a program that outlives its caller."""
    return subprocess.Popen(["sleep", str(seconds)]).pid


def hang_with(notes):
    Path(notes).write_text(f"{os.getpid()} {in_background(60)}")
    time.sleep(60)


def note(notes):
    with Path(notes).open("a") as file:
        file.write("warm ")


def shout(text):
    os.write(1, text.encode())
    return os.getpid()


def is_there(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_call_is_made_elsewhere_and_its_child_is_kept():
    pids = {call_within(Limits(), os.getpid).value for _ in range(3)}

    assert len(pids) == 1
    assert os.getpid() not in pids


def test_what_makes_pairs_does_not_answer():
    answers, makes = (call_within(Limits(), os.getpid, does=does).value for does in ("answers", "makes pairs"))

    assert answers != makes


@pytest.mark.slow
def test_children_do_not_give_every_array_back_to_the_system(monkeypatch):
    stop_children()
    monkeypatch.setenv("MALLOC_TRIM_THRESHOLD_", "65536")  # as dask has it

    assert call_within(Limits(), functools.partial(os.getenv, "MALLOC_TRIM_THRESHOLD_")).value is None
    assert call_within(Limits(), functools.partial(os.getenv, "PATH")).value == os.environ["PATH"]


def test_a_failure_comes_back_with_its_traceback():
    got = call_within(Limits(), functools.partial(int, "seven"))

    assert got.failure == "error"
    assert "invalid literal" in got.reason
    assert "Traceback" in got.log


def test_what_cannot_be_sent_is_a_failure():
    assert call_within(Limits(), lambda: 1).failure == "error"
    assert call_within(Limits(), functools.partial(eval, "lambda: 1")).failure == "error"


@pytest.mark.slow
def test_a_child_that_hangs_is_killed_with_all_that_it_started(tmp_path):
    got = call_within(QUICK, functools.partial(hang_with, tmp_path / "pids"))

    assert (got.failure, got.reason) == ("timeout", "no answer within 0.4 s")
    child, program = map(int, (tmp_path / "pids").read_text().split())
    time.sleep(0.05)
    assert not is_there(child)
    assert not is_there(program)
    assert call_within(QUICK, os.getpid).value not in (None, child)


@pytest.mark.slow
def test_memory_of_programs_counts():
    taken = "import time; kept = bytearray(300_000_000); time.sleep(30)"
    hungry = functools.partial(subprocess.run, [sys.executable, "-c", taken], check=False)

    got = call_within(Limits(timeout_s=20, memory_mb=400), hungry)

    assert (got.failure, got.reason) == ("out-of-memory", "took more than 400 MB")


def test_a_child_is_warmed_up_once(tmp_path):
    warm_up = functools.partial(note, tmp_path / "notes")
    for _ in range(3):
        call_within(Limits(), os.getpid, warm_up=warm_up)

    assert (tmp_path / "notes").read_text() == "warm "


@pytest.mark.slow
def test_a_warm_up_that_hangs_is_left_out_and_costs_no_answer():
    limits, warm_up = Limits(timeout_s=0.1), functools.partial(time.sleep, 600)  # seen to hang where it is waited for

    assert [call_within(limits, os.getpid, warm_up=warm_up).failure for _ in range(3)] == [None] * 3


def test_what_a_call_prints_stays_off_stdout(capfd):
    stop_children()
    call_within(Limits(), functools.partial(shout, "hello"))

    assert capfd.readouterr().out == ""


@pytest.mark.parametrize("wrong", [{"timeout_s": 0}, {"timeout_s": float("nan")}, {"memory_mb": -1}])
def test_limits_are_positive(wrong):
    with pytest.raises(InputError, match="limits must be > 0"):
        Limits(**wrong)
