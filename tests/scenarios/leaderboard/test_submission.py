import json
import math
import re
import shutil
import sys

import pytest

from rectmerge.errors import InputError
from scenarios.bench.contenders import Contender
from scenarios.bench.external_program import Program
from scenarios.bench.run import read_rows
from scenarios.dataset.dataset_id import measure_dataset_id
from scenarios.dataset.reader import open_dataset
from scenarios.leaderboard.page import leaderboard
from scenarios.leaderboard.submission import hash_of_rows, read_submission, submission_of
from scenarios.report.reading import Runs, TrackResults
from tests.scenarios.known_answers import Failing, run_pairs

TRACK = ("tiny", "unknown scale")


@pytest.fixture(scope="module")
def content(finished):
    """The plain content of a submission."""
    return json.loads(json.dumps(submission_of(finished / "run").to_json_dict()))


@pytest.fixture
def written(tmp_path, content):
    """A function that writes a submission with some of its content changed."""

    def write(change=lambda content: None, name="mine.json"):
        changed = json.loads(json.dumps(content))
        change(changed)
        (tmp_path / name).write_text(json.dumps(changed))
        return tmp_path / name

    return write


def test_a_submission_tells_what_was_run_on_what_and_where(finished, content):
    machine = json.loads((finished / "run/machine.json").read_text())

    assert (content["schema"], content["status"]) == ("rectmerge.submission/1", "self-reported")
    assert content["data_set"] == {"name": "tiny", "id": measure_dataset_id(finished / "tiny"), "secret_sha256": None}
    assert content["machine"]["processor"] == machine["processor"]
    assert content["machine"]["packages"] == machine["packages"]
    assert {method["label"]: method["set"]["aside"] for method in content["methods"]} == {"good": 0.0, "aside": 20.0}
    assert len(content["rows"]) == 12
    assert all(seconds > 0 for seconds in content["seconds"].values())
    assert "verification" not in content
    assert str(finished) not in json.dumps(content)  # no names of folders


def test_neither_the_command_of_a_program_nor_the_reason_of_a_failure_names_a_folder(finished, tmp_path):
    script = tmp_path / "failing.py"
    script.write_text("raise SystemExit(3)")
    program = Program.parse(f"mine={sys.executable} {script} {{a}} {{b}}")
    contenders = [Contender(label="mine", method=program), Contender(label="bad", method=Failing())]
    about = {"dataset": str(finished / "tiny")}
    run_pairs(open_dataset(finished / "tiny")[:1], contenders, tmp_path / "run", suite="tiny", about=about)
    results = tmp_path / "run/results.jsonl"
    results.write_text(results.read_text().replace("no rectangles", f"{tmp_path}/secret is gone"))
    assert str(tmp_path) in results.read_text()

    content = submission_of(tmp_path / "run").to_json_dict()

    text = json.dumps(content)
    assert str(tmp_path) not in text
    assert sys.executable not in text
    assert {method["label"]: (method["method"], method["set"]) for method in content["methods"]} == {
        "mine": ("command", {}),
        "bad": ("failing", {"how": "raise"}),
    }
    assert {row["outcome"] for row in content["rows"]} == {"error"}
    (tmp_path / "mine.json").write_text(text)
    assert read_submission(tmp_path / "mine.json").as_rows()[0]["reason"] == ""


def test_the_table_is_made_again_from_the_file_alone(finished, written):
    (track_results,) = Runs.read([finished / "run"]).tracks
    again = TrackResults(*TRACK, read_submission(written()).as_rows())

    assert leaderboard(again, {}) == leaderboard(track_results, {})
    assert "| good | 3 of 3 (100 %" in leaderboard(again, {})


def test_the_order_of_rows_does_not_change_their_hash_but_any_value_does(finished):
    rows = read_rows(finished / "run")

    assert hash_of_rows(rows) == hash_of_rows(rows[::-1])
    assert hash_of_rows(rows) != hash_of_rows([{**rows[0], "confidence": 0.76}, *rows[1:]])


def test_a_run_whose_data_set_is_gone_or_another_is_refused(finished, tmp_path):
    run = shutil.copytree(finished / "run", tmp_path / "run")
    record = (run / "run.toml").read_text()

    (run / "run.toml").write_text(record.replace(str(finished / "tiny"), str(tmp_path / "gone")))
    with pytest.raises(InputError, match="its data set is no longer where it was"):
        submission_of(run)

    (run / "run.toml").write_text(record.replace(str(finished / "tiny"), str(finished / "tiny/train")))
    with pytest.raises(InputError, match="does not hold rooms-0001-"):
        submission_of(run)


def set_at(*path, value):
    """Return a change of a submission: a value put at a path."""

    def change(content):
        for key in path[:-1]:
            content = content[key]
        content[path[-1]] = value

    return change


def drop(*path):
    """Return a change of a submission: a key left out."""

    def change(content):
        for key in path[:-1]:
            content = content[key]
        del content[path[-1]]

    return change


BAD = {
    "no schema": (drop("schema"), "schema: missing"),
    "another schema": (set_at("schema", value="rectmerge.submission/9"), "schema: must be one of"),
    "no data set": (drop("data_set"), "data_set: missing"),
    "no id": (drop("data_set", "id"), "data_set.id: missing"),
    "an unknown key": (set_at("data_set", "colour", value="red"), "data_set: unknown key 'colour'"),
    "a seed of text": (set_at("seed", value="0"), "seed: must be a whole number"),
    "no limit": (set_at("limits", "timeout_s", value=0), "limits: limits must be > 0"),
    "cores of text": (set_at("machine", "cores", value="two"), "machine.cores: must be a whole number"),
    "methods of nothing": (set_at("methods", value=3), "methods: must be a table or a list"),
    "no label": (drop("methods", 1, "label"), "methods[1].label: missing"),
    "one label twice": (set_at("methods", 1, "label", value="good"), "methods: two have the same label"),
    "another status": (set_at("status", value="certified"), "status: must be one of"),
    "verified by its own word": (set_at("status", value="verified"), "verification: must be there where"),
    "no rows": (set_at("rows", value=[]), "rows: there are none"),
    "a row of text": (set_at("rows", 3, value="right"), "rows[3]: must be a table"),
    "a row without outcome": (drop("rows", 2, "outcome"), "rows[2].outcome: missing"),
    "an outcome of its own": (set_at("rows", 2, "outcome", value="splendid"), "rows[2].outcome: must be one of"),
    "an error below zero": (
        set_at("rows", 2, "errors", value={"e_px": -1, "e_over_l": 0.0}),
        "rows[2].e_px must be a number from 0",
    ),
    "an error without its share of L": (
        set_at("rows", 2, "errors", value={"e_px": 1.0}),
        "rows[2].errors.e_over_l: missing",
    ),
    "an error of its own": (
        set_at("rows", 2, "errors", value={"e_px": 1.0, "e_over_l": 0.0, "e_cm": 5.0}),
        "rows[2].errors: unknown key 'e_cm'",
    ),
    "seconds without cpu": (set_at("rows", 2, "seconds", value={"wall": 1.0}), "rows[2].seconds.cpu: missing"),
    "seconds of text": (
        set_at("rows", 2, "seconds", value={"cpu": "fast"}),
        "rows[2].seconds.cpu: must be a number, got 'fast'",
    ),
    "a confidence in percent": (set_at("rows", 2, "confidence", value=95), "rows[2]: confidence must lie in 0..1"),
    "a confidence of text": (set_at("rows", 2, "confidence", value="high"), "rows[2].confidence: must be a number"),
    "no number as confidence": (set_at("rows", 2, "confidence", value=math.nan), "rows[2]: confidence must lie in"),
    "a verdict of its own": (set_at("rows", 2, "verdict", value="yes"), "rows[2].verdict: must be one of 'accepted'"),
    "a grade of its own": (set_at("rows", 2, "grades", value=["A"]), "rows[2].grades[0]: must be one of 'fine'"),
    "grades of a number": (set_at("rows", 2, "grades", value=1), "rows[2].grades: must be a table or a list"),
    "related as a word": (set_at("rows", 2, "related", value="yes"), "rows[2].related: must be true or false"),
    "an overlap of text": (set_at("rows", 2, "overlap", value="0.5"), "rows[2].overlap: must be a number"),
    "a flat candidate": (set_at("rows", 2, "candidates", value=[[[1, 0, 0]]]), "rows[2]: candidates must be 2x3"),
    "a column of its own": (set_at("rows", 2, "colour", value="red"), "rows[2]: unknown key 'colour'"),
    "a log": (set_at("rows", 2, "log", value="at /home/me"), "rows[2]: unknown key 'log'"),
    "a version of text": (
        set_at("rows", 2, "info", value={"suite_version": "two"}),
        "rows[2].info.suite_version: must be a whole number",
    ),
    "a method of nobody": (set_at("rows", 0, "method", value="other"), "rows[0].method: 'other' is not among methods"),
    "a row changed": (set_at("rows", 0, "confidence", value=1.0), "rows_sha256: is not that of the rows"),
}


@pytest.mark.parametrize(("change", "message"), BAD.values(), ids=BAD)
def test_a_bad_submission_is_one_line_that_names_file_and_key(written, change, message):
    path = written(change)

    with pytest.raises(InputError, match=re.escape(f"{path}: {message}")) as refused:
        read_submission(path)
    assert "\n" not in str(refused.value)


def test_what_is_no_json_is_refused(tmp_path):
    (tmp_path / "mine.json").write_text("{")

    with pytest.raises(InputError, match=r"mine\.json: not JSON"):
        read_submission(tmp_path / "mine.json")
    with pytest.raises(InputError, match=r"none\.json: cannot be read"):
        read_submission(tmp_path / "none.json")
