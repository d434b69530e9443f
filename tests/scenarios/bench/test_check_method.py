import sys

import pytest

from rectmerge.cli import console
from rectmerge.methods import make_method
from scenarios.bench.check_method import check_method
from scenarios.bench.mistakes import MISTAKES
from scenarios.cli import main as cli
from scenarios.pairs.drawn_pairs import VIEWS
from tests.scenarios.mistaken_methods import Mistaken, Restless, Torn, fail, leave


def name_of(value):
    return getattr(value, "name", None)


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES, ids=name_of)
def test_a_method_that_makes_a_mistake_hears_its_name(mistake):
    checked = check_method("mine", Mistaken(mistake=mistake.name))

    assert list(checked.complaints) == [f"{mistake.advice} ({mistake.name})"]


@pytest.mark.slow
def test_a_right_method_hears_nothing_and_sees_every_pair():
    heard = []

    checked = check_method("mine", Mistaken(), on_answer=heard.append)

    assert checked.complaints == []
    assert heard == list(VIEWS)
    assert all(line.startswith(name) for name, line in zip(VIEWS, checked.as_text().splitlines()[2:], strict=False))
    assert checked.as_text().endswith("all is well")


@pytest.mark.parametrize(
    ("method", "complaint"),
    [
        (Mistaken(misbehaves=fail), "error: ZeroDivisionError: no corners"),
        pytest.param(Restless(), "two calls with the same seed differ", marks=pytest.mark.slow),
        pytest.param(Torn(), "`pixels` and `b_to_a` of a candidate differ", marks=pytest.mark.slow),
        pytest.param(Mistaken(confidence=90.0), "probability, 0..1, but it says 90", marks=pytest.mark.slow),
        pytest.param(Mistaken(verdict="rejected"), "it does not accept every pair", marks=pytest.mark.slow),
        pytest.param(Mistaken(mistake="lost"), "by no mistake that is known here", marks=pytest.mark.slow),
    ],
    ids=name_of,
)
def test_what_is_odd_is_said(method, complaint):
    (said,) = check_method("mine", method).complaints

    assert complaint in said


@pytest.mark.slow  # a process is started eighteen times
def test_a_process_that_exits_is_said():
    (said,) = check_method("mine", Mistaken(misbehaves=leave)).complaints

    assert "died with status 7" in said


@pytest.mark.slow  # the method compiles
@pytest.mark.parametrize(("name", "is_fine"), [("robust", True), ("paper", False)])
def test_registered_methods_are_checked(name, is_fine):
    checked = check_method(name, make_method(name))

    assert (not checked.complaints) == is_fine
    assert all(asked.alignment is not None for asked in checked.answers)


def rectbench(*words):
    return console.run(cli.app, "rectbench", ["check-method", *words, "--quiet"])


def test_a_program_that_exits_oddly_is_said_with_status_1(capsys):
    assert rectbench("--method-command", f"{sys.executable} -S -c 'raise SystemExit(3)' {{a}} {{b}}") == console.NO

    shown = capsys.readouterr()
    assert "died with status 3" in shown.out
    assert shown.err == ""


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "name a registered method"),
        (("robust", "--method-command", "true {a} {b}"), "name a registered method"),
        (("no-such-method",), "unknown method"),
        (("--method-command", "true"), "must hold {a}"),
    ],
)
def test_bad_use_is_refused(words, message, capsys):
    assert rectbench(*words) == console.BAD_INPUT
    assert message in capsys.readouterr().err
