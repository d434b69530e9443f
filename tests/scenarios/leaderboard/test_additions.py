import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from rectmerge.cli import console
from rectmerge.errors import InputError
from scenarios.cli.main import app
from scenarios.leaderboard.additions import data_set_ids, with_submissions
from scenarios.leaderboard.page import page
from scenarios.leaderboard.submission import hash_of_rows, submission_of
from scenarios.leaderboard.submitted_row import REQUIRED
from scenarios.report.reading import Runs

MINE = Path("mine.json")


@pytest.fixture(scope="module")
def submission(finished):
    return submission_of(finished / "run")


@pytest.fixture(scope="module")
def own(finished):
    return Runs.read([finished / "run"])


@pytest.fixture(scope="module")
def ids(finished, own):
    return data_set_ids([finished / "run"], own)


def with_rows(submission, rows):
    return replace(submission, rows=tuple(rows), rows_sha256=hash_of_rows(rows))


def cells_of(text, label):
    """The cells of a label's line, by heading."""
    heads = re.search(r"^\| method \|.*$", text, re.MULTILINE)[0]
    line = re.search(rf"^\| {re.escape(label)} \|.*$", text, re.MULTILINE)[0]
    return dict(zip(*([cell.strip() for cell in row.split(" | ")] for row in (heads, line)), strict=True))


def test_a_submission_stands_beside_the_others_and_says_whose_word_it_is(own, submission, ids):
    text = page(*with_submissions(own, {MINE: submission}, ids))

    here, mine = cells_of(text, "good"), cells_of(text, "good (mine)")
    assert mine.pop("reported |") == "self-reported |"
    assert here.pop("reported |") == "run here |"
    assert list(mine.values())[1:] == list(here.values())[1:]
    assert "*Reported*" in text


def test_the_page_names_the_data_set_by_its_id_while_that_is_there(own, submission, finished, tmp_path):
    ids = data_set_ids([finished / "run"], own)

    assert ids == {"tiny": submission.data_set.id}
    assert f"Data set `{submission.data_set.id}`." in page(own, {}, ids)
    run = shutil.copytree(finished / "run", tmp_path / "run")
    record = (run / "run.toml").read_text()
    (run / "run.toml").write_text(record.replace(str(finished / "tiny"), str(tmp_path / "gone")))
    assert data_set_ids([run], own) == {}
    assert "Data set" not in page(own, {}, {})


def test_without_submissions_the_page_says_nothing_of_them(own):
    assert "eported" not in page(own)


def test_what_a_submission_lacks_is_a_dash(own, submission, ids):
    bare = with_rows(submission, [{key: row[key] for key in REQUIRED} for row in submission.rows])

    cells = cells_of(page(*with_submissions(own, {MINE: bare}, ids)), "good (mine)")

    assert cells["right and accepted"].startswith("3 of 3")
    lacking = ("area", "best right", "checked: right / wrong", "AURC", "e, cells", "CPU s")
    assert {name: cells[name] for name in lacking} == dict.fromkeys(lacking, "-")


def test_the_area_is_one_for_exact_answers_and_none_for_those_that_are_far_off(own, submission, ids):
    text = page(*with_submissions(own, {MINE: submission}, ids))

    assert 0.9 < float(cells_of(text, "good (mine)")["area"]) <= 1.0
    assert float(cells_of(text, "aside (mine)")["area"]) == 0.0


def test_two_files_of_one_name_and_a_data_set_that_is_gone_are_refused(own, submission, ids):
    other = Path("theirs/mine.json")

    with pytest.raises(InputError, match=r"^theirs/mine\.json: its label '.* \(mine\)' is that of mine\.json too"):
        with_submissions(own, {MINE: submission, other: submission}, ids)
    with pytest.raises(InputError, match=r"mine\.json: data_set\.id: cannot be compared: the leaderboard's tiny is no"):
        with_submissions(own, {MINE: submission}, {})


def test_what_cannot_stand_beside_the_others_is_refused(own, submission, ids):
    assert with_submissions(own, {MINE: submission}, ids)[1] == dict.fromkeys(
        ("good (mine)", "aside (mine)"), "self-reported"
    )
    with pytest.raises(InputError, match=r"mine.json: data_set.id: is of another data set than the leaderboard's tiny"):
        with_submissions(own, {MINE: submission}, {"tiny": "0" * 64})
    with pytest.raises(InputError, match=r"mine.json: rows: of .*, 1 of the 6 pairs of tiny, .* are missing"):
        with_submissions(own, {MINE: with_rows(submission, submission.rows[1:])}, ids)
    elsewhere = with_rows(submission, [{**row, "suite": "other"} for row in submission.rows])
    with pytest.raises(InputError, match=r"mine.json: rows: the leaderboard has no other, unknown scale; it has: tiny"):
        with_submissions(own, {MINE: elsewhere}, ids)


@pytest.mark.slow
@pytest.mark.usefixtures("registry")
def test_from_a_run_to_a_verified_line_of_the_leaderboard(finished, tmp_path, capsys):
    def rectbench(*words):
        return console.run(app, "rectbench", [*map(str, words), "--quiet"])

    told, verified, board = tmp_path / "told.json", tmp_path / "good.json", tmp_path / "board"
    assert rectbench("submit", finished / "run", "-o", told) == console.YES
    assert rectbench("submit", finished / "run", "-o", told) == console.BAD_INPUT
    assert "is there already" in capsys.readouterr().err
    assert rectbench("verify", told) == console.BAD_INPUT
    assert "name its data set" in capsys.readouterr().err
    assert rectbench("verify", told, "--data-set", finished / "tiny", "-o", verified) == console.YES
    assert "12 of 12 rows done again: none of them differ" in capsys.readouterr().out

    shutil.copytree(finished / "run", board / "runs" / "headline")
    words = ("leaderboard", "-o", board, "--finished")
    assert rectbench(*words, "--add", verified) == console.YES
    assert cells_of((board / "README.md").read_text(), "good (good)")["reported |"] == "verified |"

    verified.write_text(json.dumps({**json.loads(verified.read_text()), "seed": "none"}))
    assert rectbench(*words, "--add", verified) == console.BAD_INPUT
    assert f"{verified}: seed: must be a whole number" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.usefixtures("registry")
def test_a_submission_that_differs_ends_with_no_and_writes_nothing(finished, submission, tmp_path, capsys):
    rows = [{**row, "outcome": "rejected"} if not k else row for k, row in enumerate(submission.rows)]
    (tmp_path / "told.json").write_text(json.dumps(with_rows(submission, rows).to_json_dict()))
    words = ["verify", tmp_path / "told.json", "--data-set", finished / "tiny", "-o", tmp_path / "new.json", "-q"]

    assert console.run(app, "rectbench", [*map(str, words)]) == console.NO
    assert "outcome was rejected, is " in capsys.readouterr().out
    assert not (tmp_path / "new.json").exists()
