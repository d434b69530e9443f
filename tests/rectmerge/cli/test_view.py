import json
import shutil

import pytest

from rectmerge.cli import view as viewcommand
from rectmerge.cli.console import run
from rectmerge.cli.main import app
from rectmerge.results.folder import ResultFolder


@pytest.fixture(autouse=True)
def opened(monkeypatch):
    """Open nothing; list what would be."""
    pages = []
    monkeypatch.setattr(viewcommand, "_open", pages.append)
    monkeypatch.setenv("DISPLAY", ":0")
    return pages


def rectmerge(*words):
    return run(app, "rectmerge", [str(word) for word in words])


@pytest.mark.parametrize(("verdict", "count"), [("accepted", 1), ("ambiguous", 3), ("rejected", 1), ("rejected", 0)])
def test_every_answer_can_be_looked_at(write_answer, tmp_path, capsys, opened, verdict, count):
    folder = write_answer(tmp_path, verdict=verdict, candidates=count)

    assert rectmerge("view", folder) == 0

    said = capsys.readouterr()
    assert said.out == f"{folder / 'view.html'}\n"
    assert said.err == ""
    assert f'class="answer {verdict}"' in (folder / "view.html").read_text(encoding="utf-8")
    assert opened == [folder / "view.html"]


@pytest.mark.parametrize(("display", "option"), [("", "--open"), (":0", "--no-open")])
def test_nothing_is_opened_without_a_display_or_a_wish(write_answer, tmp_path, monkeypatch, opened, display, option):
    monkeypatch.setenv("DISPLAY", display)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)

    assert rectmerge("view", write_answer(tmp_path), option, "-o", tmp_path / "page.html") == 0

    assert (tmp_path / "page.html").exists()
    assert opened == []


def test_the_page_in_the_folder_is_a_result_that_force_clears(write_answer, tmp_path):
    folder = write_answer(tmp_path)
    rectmerge("view", folder)

    ResultFolder(folder).write({}, {}, None)

    assert [file.name for file in folder.iterdir()] == ["alignment.json"]


def test_maps_that_moved_are_named_anew(write_answer, tmp_path, capsys):
    folder = write_answer(tmp_path)
    (tmp_path / "moved").mkdir()
    for file in tmp_path.glob("building_*"):
        shutil.move(file, tmp_path / "moved")
    moved = tmp_path / "moved"

    assert rectmerge("view", folder) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert rectmerge("view", folder, "--a", moved / "building_a.yaml", "--b", moved / "building_b.yaml") == 0


def test_maps_of_another_size_are_told(write_answer, tmp_path, capsys):
    folder = write_answer(tmp_path)

    assert rectmerge("view", folder, "--a", tmp_path / "building_b.yaml") == 0

    assert "not the maps of the merge" in capsys.readouterr().err


@pytest.mark.parametrize(
    "change",
    [
        {"verdict": "perhaps"},
        {"candidates": 3},
        {"candidates": [{}]},
        {"confidence": "sure"},
        {"inputs": {}},
        {
            "candidates": [
                {"b_to_a": {"scale": 1, "angle_rad": 0, "translation": [0]}, "pixels": [[1, 0, 0], [0, 1, 0]]}
            ]
        },
    ],
)
def test_an_answer_of_garbage_is_one_line(write_answer, tmp_path, capsys, change):
    folder = write_answer(tmp_path)
    record = json.loads((folder / "alignment.json").read_text())
    (folder / "alignment.json").write_text(json.dumps(record | change))

    assert rectmerge("view", folder) == 2

    (line,) = capsys.readouterr().err.splitlines()
    assert "alignment.json" in line
    assert not (folder / "view.html").exists()


def test_a_mirrored_placement_is_refused(write_answer, tmp_path, capsys):
    folder = write_answer(tmp_path)
    record = json.loads((folder / "alignment.json").read_text())
    record["pixels"] = record["candidates"][0]["pixels"] = [[1, 0, 0], [0, -1, 0]]
    (folder / "alignment.json").write_text(json.dumps(record))

    assert rectmerge("view", folder) == 2
    assert "not a rotation" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["map.pgm", "view", "missing/view.html"])
def test_a_page_that_cannot_be_is_refused(write_answer, tmp_path, capsys, name):
    assert rectmerge("view", write_answer(tmp_path), "-o", tmp_path / name) == 2
    assert name in capsys.readouterr().err


def test_a_folder_without_an_answer_is_refused(tmp_path, capsys):
    assert rectmerge("view", tmp_path) == 2
    assert "name the folder of a merge" in capsys.readouterr().err
