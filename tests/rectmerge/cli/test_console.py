import logging
import subprocess
import sys
from pathlib import Path

import pytest
import typer

from rectmerge import __version__
from rectmerge.cli import console
from rectmerge.cli.app import App
from rectmerge.errors import MapFileError

ENDS = {
    "returns": (None, 0),
    "no": (typer.Exit(1), 1),
    "ambiguous": (typer.Exit(3), 3),
    "known error": (MapFileError("map.pgm: broken\nover two lines"), 2),
    "bad use": (typer.BadParameter("no such thing"), 2),
    "bug": (ZeroDivisionError("oh"), 70),
    "no memory": (MemoryError(), 70),
    "interrupted": (KeyboardInterrupt(), 130),
}


@pytest.fixture(autouse=True)
def logs(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path


def app_that(end: BaseException | None) -> typer.Typer:
    app = App("Go.")

    @app.command()
    def go() -> None:
        if end is not None:
            raise end

    @app.command()
    def stay() -> None: ...

    return app


@pytest.mark.parametrize("case", ENDS)
def test_every_end_has_its_status(case):
    end, status = ENDS[case]

    assert console.run(app_that(end), "tool", ["go"]) == status


def test_a_known_error_is_one_line_without_a_log(capsys, logs):
    console.run(app_that(ENDS["known error"][0]), "tool", ["go"])

    assert capsys.readouterr().err == "tool: map.pgm: broken over two lines\n"
    assert not list(logs.iterdir())


def test_a_bug_is_one_line_and_a_log_with_the_traceback(capsys, logs):
    console.run(app_that(ENDS["bug"][0]), "tool", ["go"])

    err = capsys.readouterr().err
    (log,) = logs.iterdir()
    assert err == f"tool: internal error: ZeroDivisionError: oh (log: {log})\n"
    assert "Traceback" in log.read_text()


@pytest.mark.parametrize("words", [["go", "--debug"], ["--debug", "go"]])
@pytest.mark.parametrize("case", ["known error", "bug"])
def test_debug_shows_the_traceback(capsys, case, words):
    console.run(app_that(ENDS[case][0]), "tool", words)

    assert "Traceback" in capsys.readouterr().err


def test_a_log_that_cannot_be_written_does_not_hide_the_error(capsys, monkeypatch, logs):
    monkeypatch.setattr("tempfile.tempdir", str(Path(logs, "missing")))

    assert console.run(app_that(ENDS["bug"][0]), "tool", ["go"]) == 70
    assert "ZeroDivisionError" in capsys.readouterr().err


def test_version_is_told_on_stdout(capsys):
    assert console.run(app_that(None), "tool", ["--version"]) == 0
    assert capsys.readouterr().out == f"{__version__}\n"


def test_bad_use_shows_the_usage(capsys):
    assert console.run(app_that(None), "tool", ["go", "--nonsense"]) == 2
    assert "Usage" in capsys.readouterr().err


QUIET = [["go", "--quiet"], ["go", "-q"], ["--quiet", "go"], ["-q", "go"]]


@pytest.mark.parametrize(("words", "shown"), [(["go"], "tool: compiling ...\n"), *((words, "") for words in QUIET)])
def test_what_the_library_notes_goes_to_stderr_unless_quiet(capsys, words, shown):
    app = app_that(None)

    @app.command("go")
    def compile_kernels() -> None:
        logging.getLogger("rectmerge.some.module").info("compiling ...")

    console.run(app, "tool", words)

    assert capsys.readouterr().err == shown


def test_notes_are_shown_by_the_command_only():
    console.run(app_that(None), "tool", ["go"])

    logger = logging.getLogger("rectmerge")
    assert not logger.handlers
    assert not logger.isEnabledFor(logging.INFO)


LOST = """
import ctypes, signal, time, typer
from rectmerge.cli import console
signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background inherits that it is ignored
app = typer.Typer()
@app.command()
def go():
    ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))()
    time.sleep(30)
console.end(app, "tool")
"""


def test_an_interrupt_that_python_would_lose_in_a_callback_is_raised_again():
    ended = subprocess.run([sys.executable, "-c", LOST], capture_output=True, text=True, timeout=20)

    assert (ended.returncode, ended.stderr.strip()) == (130, "tool: interrupted")


@pytest.mark.parametrize("write", [console.say, console.tell])
def test_control_characters_of_files_do_not_reach_the_terminal(write, capsys):
    write("map \x1b]0;title\x07\x1b[2J \u202e \udc80 \u00e4\t1\nnext")

    out, err = capsys.readouterr()
    assert out + err == "map \\x1b]0;title\\x07\\x1b[2J \\u202e \\udc80 \u00e4\t1\nnext\n"
