"""One reader of answers, whichever command takes them up."""

import json

import pytest

from rectmerge.cli import console
from rectmerge.cli import main as cli
from rectmerge.errors import InputError
from rectmerge.results.alignment_json import AlignmentFile
from tests import drawing

A, B = (drawing.DATA / f"building_{name}.yaml" for name in "ab")
TOLD = {"verdict": "rejected", "reason": "told so", "method": "told"}


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
