import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rectmerge.errors import InputError
from rectmerge.inputs import inputs_of, read_inputs, read_told, told_inputs
from rectmerge.mapfile import read_map
from tests import drawing

LEVELS = {"free": 254, "occupied": 0, "unknown": 205}


@pytest.fixture
def maps(tmp_path, monkeypatch):
    """A folder with both maps, B as a plain image in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    for name in ("building_a.yaml", "building_a.pgm"):
        shutil.copy(drawing.DATA / name, tmp_path)
    (tmp_path / "b").mkdir()
    shutil.copy(drawing.DATA / "building_b.pgm", tmp_path / "b")
    return tmp_path


def write_answer(folder, **options):
    folder.mkdir(parents=True, exist_ok=True)
    told = {"inputs": told_inputs(folder, "building_a.yaml", Path("b/building_b.pgm"), **options)}
    (folder / "alignment.json").write_text(json.dumps(told))
    return told["inputs"]


def test_paths_are_told_from_the_folder_and_name_nothing_of_the_machine(maps):
    told = write_answer(maps / "results" / "out", levels=LEVELS, strict=True)

    assert told["a"] == {
        "given": "building_a.yaml",
        "path": "../../building_a.yaml",
        "free": None,
        "occupied": None,
        "unknown": None,
        "strict_thresholds": True,
    }
    assert told["b"]["path"] == "../../b/building_b.pgm"
    assert {name: told["b"][name] for name in LEVELS} == LEVELS


def test_they_are_found_from_anywhere_and_after_all_moved_together(maps, monkeypatch):
    write_answer(maps / "out")
    shutil.move(maps, maps.parent / "elsewhere")
    monkeypatch.chdir("/")

    a, b = read_inputs(maps.parent / "elsewhere" / "out")

    assert a.samefile(maps.parent / "elsewhere" / "building_a.yaml")
    assert b.samefile(maps.parent / "elsewhere" / "b" / "building_b.pgm")


def test_a_folder_behind_a_link_is_no_obstacle(maps):
    (maps / "deep" / "er").mkdir(parents=True)
    (maps / "out").symlink_to(maps / "deep" / "er")
    write_answer(maps / "out")

    assert read_inputs(maps / "out")[0] == maps / "building_a.yaml"


def test_they_are_read_as_the_merge_read_them(maps):
    with Image.open(maps / "b" / "building_b.pgm") as image:
        turned = 255 - np.asarray(image)
    Image.fromarray(turned).save(maps / "b" / "building_b.pgm")
    write_answer(maps / "out", levels={"free": 1, "occupied": 255, "unknown": 50})

    a, b = (one.read() for one in inputs_of(read_told(maps / "out"), maps / "out"))

    assert (a.occupancy == read_map(drawing.DATA / "building_a.yaml").occupancy).all()
    assert (b.occupancy == read_map(drawing.DATA / "building_b.yaml").occupancy).all()


def test_a_map_that_moved_is_named_with_the_remedy_and_can_be_named_anew(maps):
    write_answer(maps / "out")
    moved = shutil.move(maps / "b" / "building_b.pgm", maps / "other.pgm")

    with pytest.raises(InputError, match=r"building_b\.pgm: map B .* no longer there; .*--b FILE"):
        read_inputs(maps / "out")

    _, b = inputs_of(read_told(maps / "out"), maps / "out", b=moved)
    assert b.read().shape == read_map(drawing.DATA / "building_b.yaml").shape


@pytest.mark.parametrize(
    "content", ["{}", '{"inputs": 3}', '{"inputs": {"a": {"path": "x"}}}', "[]", "", "\ufffe{", "[" * 9999]
)
def test_an_answer_that_names_no_maps_is_refused_in_one_line(tmp_path, content):
    (tmp_path / "alignment.json").write_text(content)

    with pytest.raises(InputError, match=r"alignment\.json: (does not say|not an answer)"):
        read_inputs(tmp_path)


def test_a_folder_without_an_answer_is_refused(tmp_path):
    with pytest.raises(InputError, match="name the folder of a merge"):
        read_inputs(tmp_path)
