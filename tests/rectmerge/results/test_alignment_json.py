"""One reader of answers, whichever command takes them up."""

import json

import pytest

from rectmerge.cli import console
from rectmerge.cli import main as cli
from rectmerge.errors import InputError
from rectmerge.results.alignment_json import AlignmentFile
from tests import drawing

A, B = (drawing.DATA / f"building_{name}.yaml" for name in "ab")
TOLD = {"schema": "rectmerge.alignment/1", "verdict": "rejected", "reason": "told so", "method": "told"}


@pytest.fixture(scope="module")
def merged(tmp_path_factory):
    """The folder of a merge of the committed maps."""
    folder = tmp_path_factory.mktemp("merged")
    assert rectmerge("merge", A, B, "-o", folder, "-q") == console.YES
    return folder


def rectmerge(*words):
    return console.run(cli.app, "rectmerge", [str(word) for word in words])


@pytest.mark.parametrize("named", ["", "alignment.json"])
def test_an_answer_is_named_itself_or_by_its_folder(tmp_path, named):
    (tmp_path / "alignment.json").write_text(json.dumps(TOLD))

    answer = AlignmentFile.read(tmp_path / named)

    assert (answer.verdict, answer.reason, answer.folder) == ("rejected", "told so", tmp_path)


def test_whoever_takes_more_than_there_is_names_the_file(tmp_path):
    (tmp_path / "alignment.json").write_text(json.dumps(TOLD))
    answer = AlignmentFile.read(tmp_path)

    with (
        pytest.raises(InputError, match=r"alignment\.json: not an answer .*: there is no 'candidates'; merge again"),
        answer.explain_errors(),
    ):
        answer.record["candidates"]


@pytest.mark.parametrize("content", ["{}", "[]", "3", "", "\ufffe{", "[" * 9999, '{"verdict": "perhaps"}'])
def test_what_is_no_answer_is_refused_in_one_line(tmp_path, content):
    (tmp_path / "alignment.json").write_text(content)

    with pytest.raises(InputError, match=r"alignment\.json: not an answer of rectmerge merge: [^\n]*; merge again$"):
        AlignmentFile.read(tmp_path)


def edited(record, *keys, value):
    """A record with the value at a path of keys replaced."""
    if not keys:
        return value
    copy = dict(record) if isinstance(record, dict) else list(record)
    copy[keys[0]] = edited(record[keys[0]], *keys[1:], value=value)
    return copy


EDITS = {
    "another schema": (("schema",), "rectmerge.alignment/9", "its schema is 'rectmerge.alignment/9'"),
    "a number of the answer": (("b_to_a", "scale"), 2.0, "its b_to_a is not that of its first candidate"),
    "a number of its pixels": (("pixels", 0, 2), 7.0, "its pixels is not that of its first candidate"),
    "no candidate": (("candidates",), [], "not an answer of rectmerge merge"),
    "candidates of text": (("candidates",), "none", "not an answer of rectmerge merge"),
}


@pytest.mark.parametrize(("keys", "value", "message"), EDITS.values(), ids=EDITS)
def test_an_answer_that_was_edited_is_refused(merged, tmp_path, capsys, keys, value, message):
    record = json.loads((merged / "alignment.json").read_text())
    (tmp_path / "alignment.json").write_text(json.dumps(edited(record, *keys, value=value)))

    assert rectmerge("transform", tmp_path) == console.BAD_INPUT
    assert message in capsys.readouterr().err


def test_a_number_of_400_digits_is_refused_in_one_line(merged, tmp_path, capsys):
    record = json.loads((merged / "alignment.json").read_text())
    huge = edited(edited(record, "b_to_a", "scale", value=10**400), "candidates", 0, "b_to_a", "scale", value=10**400)
    (tmp_path / "alignment.json").write_text(json.dumps(huge))

    assert rectmerge("transform", tmp_path) == console.BAD_INPUT
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("name", ["", "none", "n" * 300])
def test_where_there_is_none_the_remedy_is_told(tmp_path, name):
    with pytest.raises(InputError, match=r"alignment\.json: cannot be read: .*; name the folder of a merge"):
        AlignmentFile.read(tmp_path / name)


@pytest.mark.parametrize("named", ["", "alignment.json"])
@pytest.mark.parametrize(
    "words", [("transform", "{}"), ("view", "{}", "--no-open"), ("merge", A, B, "-o", "out", "--from", "{}")]
)
def test_every_command_takes_both_names(merged, tmp_path, monkeypatch, words, named):
    monkeypatch.chdir(tmp_path)

    assert rectmerge(*(merged / named if word == "{}" else word for word in words)) == console.YES
