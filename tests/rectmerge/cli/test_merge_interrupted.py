"""A merge of many maps that is interrupted, and the same command again."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest

from rectmerge import methods
from rectmerge.cli import console
from rectmerge.fleet.journal import JOURNAL_NAME
from tests.rectmerge.cli.many import MAPS, Judge, rectmerge
from tests.rectmerge.fleet.fleets import fleet

pytestmark = pytest.mark.usefixtures("small_pictures")
ANSWERED = 3  # pairs, when it is interrupted


class Interrupted(Judge):
    """Method that is interrupted after some answers."""

    def align(self, a, b, **asked):
        answer = super().align(a, b, **asked)
        if len(set(self.asked)) > ANSWERED:
            raise KeyboardInterrupt
        return answer


def count_asked(record):
    return len([pair for pair in record["pairs"] if pair["alignment"]])


def compared(record):
    """Return a record without what a clock has measured, and with numbers as text has them to ten digits."""
    if isinstance(record, dict):
        return {key: compared(value) for key, value in record.items() if key != "seconds"}
    if isinstance(record, list):
        return [compared(value) for value in record]
    return float(f"{record:.10g}") if isinstance(record, float) else record


def result(folder):
    return compared(json.loads((folder / "fleet.json").read_text()))


@pytest.fixture
def merge(tmp_path, saved, monkeypatch):
    """Merge a fleet by a method into a folder of this name; the function returns the folder."""
    made = fleet(1, home=4, other=2)
    files = saved(made)

    def run(method, name="out", *options, maps=None):
        monkeypatch.setattr(methods, "make_method", lambda name, **fields: method(made))
        monkeypatch.setattr("rectmerge.method_fields.field_values", lambda method: {})  # not what it is asked
        rectmerge("merge", *(maps or files.values()), "-o", tmp_path / name, *options)
        return tmp_path / name

    run.made, run.files = made, files
    return run


def test_an_interrupted_merge_goes_on_where_it_was(merge, capsys):
    whole = result(merge(Judge, "whole"))
    folder = merge(Interrupted)
    assert {each.name for each in folder.iterdir()} == {JOURNAL_NAME}
    assert "the same command goes on where this one stopped" in capsys.readouterr().err
    asked = []
    again = merge(lambda made: Judge(made, asked=asked))

    assert result(again) == whole
    assert len(set(asked)) == count_asked(whole) - ANSWERED
    assert f"goes on with an interrupted merge; answered pairs: {ANSWERED}" in capsys.readouterr().err
    assert not (folder / JOURNAL_NAME).exists()


def test_answers_of_other_settings_are_asked_anew(merge):
    merge(Interrupted)
    asked = []
    folder = merge(lambda made: Judge(made, asked=asked), "out", "--seed", "5")

    assert len(set(asked)) == count_asked(result(folder))


def test_answers_about_a_map_that_has_changed_are_asked_anew(merge):
    folder = merge(Interrupted)
    lines = (folder / JOURNAL_NAME).read_text().splitlines(keepends=True)
    changed = {digest for line in lines[1:] for digest in json.loads(line)["pair"]}
    (folder / JOURNAL_NAME).write_text("".join(line.replace(min(changed), "0" * 16) for line in lines))
    about = sum(min(changed) in line for line in lines)
    asked = []
    merge(lambda made: Judge(made, asked=asked))

    assert 0 < about < ANSWERED
    assert len(set(asked)) == count_asked(result(folder)) - ANSWERED + about


def test_a_line_that_was_cut_off_counts_as_not_written(merge):
    whole = result(merge(Judge, "whole"))
    folder = merge(Interrupted)
    text = (folder / JOURNAL_NAME).read_text()
    (folder / JOURNAL_NAME).write_text(text[:-20])

    assert result(merge(Judge)) == whole


@pytest.mark.parametrize("text", ["{", "[]\n", "nonsense\n"])
def test_a_file_that_is_no_journal_is_named(merge, capsys, text):
    folder = merge(Interrupted)
    lines = (folder / JOURNAL_NAME).read_text().splitlines(keepends=True)
    (folder / JOURNAL_NAME).write_text(lines[0] + text + "\n")
    capsys.readouterr()
    merge(Judge)

    told = capsys.readouterr().err.strip()
    assert told.startswith(f"rectmerge: {folder / JOURNAL_NAME}: not the journal of a merge")
    assert told.endswith("remove it to begin anew")
    assert "\n" not in told


@pytest.mark.slow
def test_a_killed_merge_goes_on_where_it_was(tmp_path, merged_many, capsys):
    code = "from rectmerge.cli.main import main; main()"
    command = [sys.executable, "-c", code, "merge", *map(str, MAPS), "-o", str(tmp_path / "out")]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    journal = tmp_path / "out" / JOURNAL_NAME
    while process.poll() is None and (not journal.exists() or journal.read_text().count("\n") < 2):
        time.sleep(0.005)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    was_cut = journal.exists()  # unless it was faster than this test

    assert rectmerge("merge", *MAPS, "-o", tmp_path / "out", "--force") == console.YES
    assert ("answered pairs: " in capsys.readouterr().err) is was_cut
    assert result(tmp_path / "out")["placements"] == result(merged_many)["placements"]
    assert not journal.exists()
