"""`rectmerge` as a whole: bad input and bad use, bugs, help."""

import subprocess
import sys
from pathlib import Path

import pytest

from rectmerge import methods
from tests.rectmerge.cli.answers import A, B, names, rectmerge

pytestmark = pytest.mark.usefixtures("small_pictures")


def test_bad_input_is_one_line_on_stderr_and_nothing_is_written(tmp_path, capsys):
    (tmp_path / "bad.png").write_bytes(b"not a picture")

    bad, plain = tmp_path / "bad.png", A.with_suffix(".pgm")
    for a, b in ((bad, B), (A, bad), (plain, bad), (A, tmp_path), (tmp_path / "no.yaml", B)):
        assert rectmerge("merge", a, b, "-o", tmp_path / "out") == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.count("\n") == 1
        assert str(tmp_path) in err

    assert names(tmp_path) == {"bad.png"}


@pytest.mark.parametrize(
    "words",
    [
        ("--scale", "wide"),
        ("--scale", "2:1"),
        ("--scale", "0"),
        ("--scale", "nan"),
        ("--scale", "1:2:3"),
        ("--rule", "max"),
        ("--dialect", "ros"),
        ("--resolution-a", "-3"),
        ("--set", "paper.delta_cells"),
        ("--set", "delta_cells=2"),
        ("--set", "other.delta_cells=2"),
        ("--free", "254"),  # both maps are YAML
    ],
)
def test_a_value_that_cannot_be_is_one_line_that_names_the_option(tmp_path, capsys, words):
    assert rectmerge("merge", A, B, "-o", tmp_path / "out", *words) == 2

    (line,) = capsys.readouterr().err.splitlines()
    assert words[0] in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "words",
    [
        ("--method", "paper", "--set", "paper.no_such=2"),
        ("--method", "paper", "--set", "paper.delta_cells=wide"),
        ("--set", "robust.prepare.margin_cells=100000"),
        ("--method", "no-such-method"),
        ("--free", "300"),
        ("--seed", "-1"),
        ("--no-such-option",),
    ],
)
def test_bad_use_exits_2_and_writes_nothing(tmp_path, capsys, words):
    assert rectmerge("merge", A, B, "-o", tmp_path / "out", *words) == 2

    assert capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_bug_exits_70_with_a_line_and_a_log_and_debug_shows_the_traceback(tmp_path, monkeypatch, capsys):
    def broken(name: str, **fields: object) -> None:
        raise ZeroDivisionError("oh")

    monkeypatch.setattr(methods, "make_method", broken)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)

    assert rectmerge("merge", A, B, "-o", tmp_path / "out") == 70
    (line,) = capsys.readouterr().err.splitlines()
    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--debug") == 70

    assert "ZeroDivisionError: oh" in line
    assert "Traceback" in Path(line.split("log: ")[1].rstrip(")")).read_text()
    assert "Traceback" in capsys.readouterr().err


def test_an_interrupt_exits_130(tmp_path, monkeypatch):
    def interrupted(name: str, **fields: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(methods, "make_method", interrupted)

    assert rectmerge("merge", A, B, "-o", tmp_path) == 130


@pytest.mark.parametrize("words", [[], ["merge"], ["inspect"]])
def test_h_is_help(capsys, words):
    assert rectmerge(*words, "-h") == 0
    short = capsys.readouterr().out
    assert rectmerge(*words, "--help") == 0

    assert capsys.readouterr().out == short
    assert "Usage: rectmerge" in short


def test_help_and_version_need_no_heavy_package():
    code = (
        "import sys; from rectmerge.cli import console, main\n"
        "assert console.run(main.app, 'rectmerge', ['merge', '--help']) == 0\n"
        "assert console.run(main.app, 'rectmerge', ['--version']) == 0\n"
        "assert not {'numpy', 'cv2', 'numba', 'cattrs', 'yaml', 'PIL'} & set(sys.modules)"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stderr
    assert "--scale" in done.stdout
