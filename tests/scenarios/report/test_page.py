import base64
import gzip
import json
import re
import shutil

import pytest

from rectmerge.errors import InputError
from scenarios.report.page import write_report
from scenarios.report.reading import Runs
from scenarios.report.standings import standings, tie
from tests.scenarios.known_answers import Source, run_pairs
from tests.scenarios.report.conftest import METHODS


def held_by(page):
    packed = re.search(r'id="gallery-data">(.*?)</script>', page, re.DOTALL).group(1)
    return json.loads(gzip.decompress(base64.b64decode(packed)))


def test_the_page_holds_everything_and_asks_for_nothing(report_run, tmp_path):
    count = write_report([report_run], tmp_path / "report.html")

    page = (tmp_path / "report.html").read_text()
    assert count == len(held_by(page)["answers"]) == 18
    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    assert "@import" not in page
    assert page.count("<svg") == page.count("</svg>") >= 4
    assert "<b>as told" not in page  # what methods say is not markup


def test_the_worst_answers_come_first_and_lie_where_the_method_put_them(report_run, tmp_path):
    write_report([report_run], tmp_path / "report.html")

    held = held_by((tmp_path / "report.html").read_text())
    first = held["answers"][0]
    assert (first["method"], first["outcome"]) == ("bad", "wrong-accepted")
    assert first["matrix"] == [1, 0, 27, 0, 1, 4]
    assert held["pairs"][first["pair"]]["a"].startswith("data:image/png;base64,")
    outcomes = [answer["outcome"] for answer in held["answers"]]
    assert outcomes.index("rejected") > max(k for k, answer in enumerate(outcomes) if answer == "wrong-accepted")


def test_the_leaderboard_counts_what_the_rows_say(report_run):
    (track_results,) = Runs.read([report_run]).tracks

    lines = {line.label: line for line in standings(track_results)}
    assert next(iter(lines)) == "good"
    assert (lines["good"].right.k, lines["good"].right.n, lines["good"].merged.k) == (3, 3, 3)
    assert (lines["bad"].right.k, lines["bad"].wrong, lines["bad"].best) == (0, 3, 0)
    assert (lines["bad-tuned"].right.k, lines["bad-tuned"].best, lines["bad-tuned"].merged.k) == (0, 3, 0)
    assert (lines["bad"].aurc, lines["good"].aurc) == (1.0, 0.5)


@pytest.mark.parametrize(("labels", "tied"), [("good", ""), ("good bad", ""), ("good good", "3 of 3 right"), ("", "")])
def test_a_tie_of_all_methods_is_said(report_run, labels, tied):
    (track_results,) = Runs.read([report_run]).tracks
    lines = {line.label: line for line in standings(track_results)}

    said = tie([lines[label] for label in labels.split()])

    assert tied in said
    assert bool(said) == bool(tied)


BROKEN = {
    "no run.toml": ("run.toml", None, "run.toml: cannot be read"),
    "a broken run.toml": ("run.toml", "seed = [", "run.toml: cannot be read"),
    "no machine.json": ("machine.json", None, "machine.json: cannot be read"),
    "a machine.json of something else": ("machine.json", "{}", "machine.json: is not that of a run: there is no"),
    "a machine.json of text": ("machine.json", '"x"', "machine.json: cannot be read"),
    "a row without an id": ("results.jsonl", '{"suite": "s"}\n', "results.jsonl:1: not a row of a run: pair_id"),
}


@pytest.mark.parametrize(("name", "content", "message"), BROKEN.values(), ids=BROKEN)
def test_a_run_that_is_broken_is_refused_with_its_file(report_run, tmp_path, name, content, message):
    run = shutil.copytree(report_run, tmp_path / "run")
    (run / name).unlink()
    if content is not None:
        (run / name).write_text(content)

    with pytest.raises(InputError, match=re.escape(message)):
        Runs.read([run])


def test_a_run_without_its_maps_has_no_gallery(tmp_path):
    run_pairs([Source()], METHODS[:1], tmp_path / "run", suite="made")

    write_report([tmp_path / "run"], tmp_path / "report.html")

    page = (tmp_path / "report.html").read_text()
    assert 'id="gallery"' not in page
    assert held_by(page) == {"pairs": {}, "answers": []}


def test_latex_has_a_line_for_every_method(report_run, tmp_path):
    write_report([report_run], tmp_path / "r.html", table=tmp_path / "t.tex")

    text = (tmp_path / "t.tex").read_text()
    lines = [line for line in text.splitlines() if " & " in line]
    assert [line.split(" & ")[0].strip() for line in lines] == ["method", "good", "bad-tuned", "bad"]
    assert {line.count("&") for line in lines} == {8}
    assert not re.search(r"(?<!\\)%", text)


def test_earlier_reports_are_kept_and_runs_are_not_counted_twice(report_run, tmp_path):
    (tmp_path / "r.html").write_text("mine")

    with pytest.raises(InputError, match="--force"):
        write_report([report_run], tmp_path / "r.html")
    with pytest.raises(InputError, match="in another run as well"):
        write_report([report_run, report_run], tmp_path / "other.html")
    with pytest.raises(InputError, match="no finished run"):
        write_report([tmp_path], tmp_path / "other.html")

    assert (tmp_path / "r.html").read_text() == "mine"
    assert not (tmp_path / "other.html").exists()
