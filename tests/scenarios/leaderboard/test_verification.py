import sys
from dataclasses import replace

import pytest

from rectmerge.errors import InputError
from scenarios.bench.contenders import Contender
from scenarios.bench.external_program import Program
from scenarios.dataset.reader import open_dataset
from scenarios.leaderboard.submission import hash_of_rows, submission_of
from scenarios.leaderboard.verification import difference, plan_repetition, repeat
from tests.scenarios.known_answers import run_pairs

pytestmark = pytest.mark.usefixtures("registry")


@pytest.fixture(scope="module")
def submission(finished):
    return submission_of(finished / "run")


def done_again(submission, finished, path, **options):
    return repeat(submission, plan_repetition(submission, path, finished / "tiny", **options))


def changed(submission, number, **changes):
    rows = tuple({**row, **(changes if k == number else {})} for k, row in enumerate(submission.rows))
    return replace(submission, rows=rows, rows_sha256=hash_of_rows(rows))


def test_an_honest_submission_becomes_verified(submission, finished, tmp_path):
    done = done_again(submission, finished, tmp_path / "mine.json")

    assert (done.differences, done.rows) == ((), 12)
    assert (done.verified.status, done.verified.standing) == ("verified", "verified")
    assert done.verified.rows == submission.rows
    assert done.verified.verification.machine.cores >= 1


def test_every_other_pair_verifies_half_and_says_so(submission, finished, tmp_path):
    done = done_again(submission, finished, tmp_path / "mine.json", every=2)

    assert done.verified.standing == "verified, 6 of 12 rows"


def test_a_row_that_is_not_what_the_method_answers_is_named(submission, finished, tmp_path):
    number = next(k for k, row in enumerate(submission.rows) if row["outcome"] == "wrong-accepted")
    row = submission.rows[number]
    embellished = changed(submission, number, outcome="right-accepted", confidence=0.99)

    done = done_again(embellished, finished, tmp_path / "mine.json")

    assert done.verified is None
    (line,) = done.differences
    assert line.startswith(f"{row['method']}, {row['pair_id']}: outcome was right-accepted, is wrong-accepted;")
    assert "confidence was 0.990, is 0.900" in line


@pytest.mark.parametrize(
    ("changes", "differs"),
    [
        ({"confidence": 0.755}, False),
        ({"confidence": 0.80}, True),
        ({"errors": {"e_px": 1.04, "e_over_l": 0.0205}}, False),
        ({"errors": {"e_px": 1.06, "e_over_l": 0.02}}, True),
        ({"errors": {"e_px": 1.0, "e_over_l": 0.0}}, True),
        ({"grades": ["right"] * 9}, True),
        ({"overlap": 0.99}, True),
        ({"errors": None}, True),
        ({"checked_outcome": "error"}, True),
        ({"place": "elsewhere"}, True),
        ({"seconds": {"cpu": 9.0, "wall": 9.0}}, False),
    ],
)
def test_what_counts_as_another_row(submission, changes, differs):
    row = next(row for row in submission.as_rows() if row["outcome"] == "right-accepted")
    row = {**row, "confidence": 0.75, "errors": {"e_px": 1.0, "e_over_l": 0.02}, "overlap": 0.5}

    assert bool(difference(row, {**row, **changes})) == differs


def test_what_was_not_handed_in_is_no_difference(submission):
    (row, *_) = submission.as_rows()

    assert not difference({**row, "confidence": None, "errors": None, "checked_outcome": None, "verdict": None}, row)


def test_another_data_set_and_a_method_that_is_not_here_are_refused(submission, finished, tmp_path):
    other = replace(submission, data_set=replace(submission.data_set, id="0" * 64))
    with pytest.raises(InputError, match=r"is another data set: its id is .*, mine\.json is of 0000000000000000"):
        plan_repetition(other, tmp_path / "mine.json", finished / "tiny")

    methods = (replace(submission.methods[0], method="unheard-of"), *submission.methods[1:])
    with pytest.raises(InputError, match="'unheard-of' is not installed here; if it is a program"):
        plan_repetition(replace(submission, methods=methods), tmp_path / "mine.json", finished / "tiny")


def test_a_program_is_run_by_the_word_of_who_verifies_only(finished, tmp_path):
    marker, program = tmp_path / "was-run", tmp_path / "shift.py"
    program.write_text(f"open({str(marker)!r}, 'w'); print('1 0 7 0 1 4 0.5')")
    command = f"shift={sys.executable} {program} {{a}} {{b}}"
    contenders = [Contender(label="shift", method=Program.parse(command))]
    about = {"dataset": str(finished / "tiny")}
    run_pairs(open_dataset(finished / "tiny")[:1], contenders, tmp_path / "run", suite="tiny", about=about)
    submission = submission_of(tmp_path / "run")
    marker.unlink()

    with pytest.raises(InputError, match="give its command line: --method-command 'shift=PROG"):
        plan_repetition(submission, tmp_path / "mine.json", finished / "tiny")
    assert not marker.exists()

    done = done_again(submission, finished, tmp_path / "mine.json", commands=[command])
    assert marker.exists()
    assert done.verified.standing == "verified"
