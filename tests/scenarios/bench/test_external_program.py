import math
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from rectmerge.errors import InputError
from rectmerge.io.map_file import read_map
from scenarios.bench import external_program
from scenarios.bench.asking import ask_within
from scenarios.bench.contenders import Contender
from scenarios.bench.external_program import Program, ProgramError, labelled
from scenarios.bench.rows import score_answer
from scenarios.execution.limits import Limits, stop_children
from tests.scenarios.known_answers import pair

RIGHT = "1 0 4  0 1 2"


@pytest.fixture
def program(tmp_path):
    def write(body, files="{a} {b}"):
        path = tmp_path / "program.py"
        path.write_text(body)
        return Program(command=f"{sys.executable} {path} {files}")

    return write


def row(method, limits=None, **changes):
    the_pair, entry = pair(**changes), Contender(label="mine", method=method)
    return score_answer(the_pair, entry, ask_within(the_pair, entry, limits=limits or Limits(timeout_s=30)))


def test_a_printed_matrix_is_an_accepted_answer(program):
    scored = row(program(f"print('working ...')\nprint('{RIGHT} 0.9')\nprint()"))

    assert (scored["outcome"], scored["verdict"], scored["confidence"]) == ("right-accepted", "accepted", 0.9)
    assert scored["candidates"] == [[[1, 0, 4], [0, 1, 2]]]
    assert scored["errors"]["e_px"] == 0
    assert scored["peak_mb"] > 1
    assert scored["seconds"]["cpu"] > 0.005  # of the program, too


def test_without_a_seventh_number_no_confidence_is_claimed(program):
    assert math.isnan(program(f"print('{RIGHT}')").align(*maps(), scale=(1, 1), rng=None).confidence)


def maps():
    return pair().a, pair().b


def test_a_last_line_rejected_with_status_0_is_a_rejection(program):
    scored = row(program("print('no corners')\nprint('rejected')"))

    assert (scored["outcome"], scored["reason"]) == ("rejected", "the program rejects")


def test_a_crash_is_an_error_and_never_a_rejection(program):
    scored = row(program("print('rejected', flush=True)\nraise RuntimeError"))

    assert scored["outcome"] == "error"
    assert "died with status 1; a program says no by a last line 'rejected' and status 0" in scored["reason"]


def remains(tmp_path, monkeypatch):
    """A folder for temporary files, which is to be empty again."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def is_running(pid):
    """Whether a process is there and no zombie, which only its adoptive parent can bury."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("end", [f"print('{RIGHT}')", "time.sleep(60)", "os.kill(os.getpid(), 9)"])
def test_a_program_leaves_no_file_and_no_process(program, tmp_path, monkeypatch, end):
    stop_children()
    folder = remains(tmp_path, monkeypatch)
    started = tmp_path / "started"
    body = (
        "import os, pathlib, subprocess, sys, tempfile, time\n"
        "pathlib.Path(tempfile.mkdtemp(), 'file').write_text('left')\n"
        "sleeper = [sys.executable, '-c', 'import time; time.sleep(600)']\n"
        "child = subprocess.Popen(sleeper, start_new_session=True, stdout=subprocess.DEVNULL)\n"
        f"pathlib.Path({str(started)!r}).write_text(str(child.pid))\n"
    )
    scored = row(program(body + end), Limits(timeout_s=3 if "sleep" in end else 30))
    assert (scored["outcome"] == "timeout") == ("sleep" in end)
    stop_children()

    assert list(folder.iterdir()) == []
    assert not is_running(int(started.read_text()))


def test_output_without_end_is_an_error(program, monkeypatch):
    monkeypatch.setattr(external_program, "MAX_OUTPUT_BYTES", 2**20)
    endless = program("while True: print('y' * 10000)")

    with pytest.raises(ProgramError, match="printed more than 1 MB"):
        endless.align(*maps(), scale=(1, 1), rng=None)


WRONG = {
    "prints nothing": ("", "error", "got ''"),
    "five numbers": ("print('1 0 4 0 1')", "error", "got '1 0 4 0 1'"),
    "eight numbers": (f"print('{RIGHT} 1 1')", "error", "six finite numbers"),
    "words": ("print('no idea at all, and six words')", "error", "got 'no idea"),
    "the answer not last": (f"print('{RIGHT}')\nprint('done')", "error", "got 'done'"),
    "not a number": ("print('1 0 nan 0 1 2')", "error", "finite"),
    "flat": ("print('1 0 4 1 0 2')", "error", "flattens"),
    "confidence": (f"print('{RIGHT} 7')", "error", "0..1, got 7"),
    "status": (f"print('{RIGHT}')\nraise SystemExit(3)", "error", "died with status 3"),
    "signal": (f"print('{RIGHT}', flush=True)\nimport os; os.kill(os.getpid(), 11)", "error", "signal SIGSEGV"),
    "too long": ("import time; time.sleep(60)", "timeout", "no answer within 0.5 s"),
    "mirrored": ("print('-1 0 40 0 1 2')", "wrong-accepted", ""),
    "sheared": ("print('1 0.5 4 0 1 2')", "wrong-accepted", ""),
}


@pytest.mark.parametrize(("body", "outcome", "reason"), WRONG.values(), ids=WRONG)
def test_a_wrong_program_is_a_row(program, body, outcome, reason):
    limits = Limits(timeout_s=0.5 if outcome == "timeout" else 30)

    scored = row(program(body), limits)

    assert scored["outcome"] == outcome
    assert reason in scored["reason"]


def test_a_mirrored_answer_is_scored_as_printed(program):
    scored = row(program("print('-1 0 64 0 1 2')"))

    assert scored["errors"]["reflected"] is True
    assert scored["grades"] == ["off"]


def test_the_program_gets_images_and_map_server_files(program, tmp_path):
    copy = (
        "import shutil, sys, os\n"
        f"for file in sys.argv[1:]: shutil.copy(file, {str(tmp_path)!r})\n"
        f"folder = os.path.dirname(sys.argv[1]); shutil.copy(folder + '/b.png', {str(tmp_path)!r})\n"
        f"print('{RIGHT}')"
    )
    shown = pair()
    row(program(copy, "{a} {b_yaml}"))

    assert np.array_equal(read_map(tmp_path / "a.png").occupancy, shown.a.occupancy)
    assert np.array_equal(read_map(tmp_path / "b.yaml").occupancy, shown.b.occupancy)
    assert read_map(tmp_path / "b.yaml").resolution is None  # hidden, never a false 1.0


def test_a_program_is_told_a_known_scale_and_fails_where_it_asks_for_one_that_nobody_knows(program):
    asks = program("import sys\nprint(sys.argv[3], '0 4  0', sys.argv[3], '2')", "{a} {b} {scale}")

    assert asks.align(*maps(), scale=(1.25, 1.25), rng=None).trace["matrix"] == [[1.25, 0, 4], [0, 1.25, 2]]
    with pytest.raises(ProgramError, match="--known-scale"):
        asks.align(*maps(), scale=(0.5, 2.0), rng=None)


def test_spaces_and_quotes_in_a_command_are_read_as_by_a_shell(tmp_path):
    script = tmp_path / "my program.py"
    script.write_text(f"import sys\nprint('{RIGHT}' if sys.argv[1] == 'a b' else 'no')")
    method = Program(command=f"{sys.executable} '{script}' 'a b' {{a}} {{b}}")

    assert row(method)["outcome"] == "right-accepted"


@pytest.mark.parametrize(
    ("command", "message"),
    [
        ("true {a}", "must hold {b} or {b_yaml}"),
        ("true", "must hold {a} or {a_yaml}"),
        ("no-such-program {a} {b}", "no program 'no-such-program'"),
        ("true '{a} {b}", "No closing quotation"),
    ],
)
def test_a_command_that_cannot_work_is_refused(command, message):
    with pytest.raises(InputError, match=message):
        Program(command=command)


def test_a_program_is_named_by_its_user_or_its_script(tmp_path):
    (tmp_path / "corners.py").touch()
    script = f"{sys.executable} -S {tmp_path / 'corners.py'} {{a}} {{b}}"

    labels = [Program.parse(text).label for text in (f"mine={script}", script, "true {a} {b}")]

    assert labels == ["mine", "corners", "true"]


def test_labels_are_programs_names_and_differ():
    programs = [Program(command=f"/bin/{name} {{a}} {{b}}") for name in ("cat", "cat", "true")]

    assert list(labelled(programs, ["true"])) == ["cat", "cat-2", "true-2"]
