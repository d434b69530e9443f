import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rectmerge.alignment import SCHEMA
from rectmerge.errors import InputError
from rectmerge.io.map_file import read_map
from rectmerge.results.alignment_json import AlignmentFile
from rectmerge.results.inputs import Input, inputs_json_dict, saved_inputs
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


def inputs_in(named, **instead):
    return saved_inputs(AlignmentFile.read(named), **instead)


def write_answer(folder, levels=None, **options):
    folder.mkdir(parents=True, exist_ok=True)
    names = ("building_a.yaml", "b/building_b.pgm")
    a, b = (Input(given=name, path=Path(name), greys=levels or {}, **options) for name in names)
    record = {"schema": SCHEMA, "verdict": "rejected", "reason": "told so", "inputs": inputs_json_dict(folder, a, b)}
    (folder / "alignment.json").write_text(json.dumps(record))
    return record["inputs"]


def test_paths_are_told_from_the_folder_and_name_nothing_of_the_machine(maps):
    inputs = write_answer(maps / "results" / "out", levels=LEVELS, strict=True, dialect="ros1", resolution=0.1)

    assert inputs["a"] == {
        "given": "building_a.yaml",
        "path": "../../building_a.yaml",
        "free": None,
        "occupied": None,
        "unknown": None,
        "dialect": "ros1",
        "strict_thresholds": True,
        "resolution": 0.1,
        "metres_per_cell": None,
        "frame": None,
    }
    assert inputs["b"]["path"] == "../../b/building_b.pgm"
    assert {name: inputs["b"][name] for name in LEVELS} == LEVELS


def test_they_are_found_from_anywhere_and_after_all_moved_together(maps, monkeypatch):
    write_answer(maps / "out")
    shutil.move(maps, maps.parent / "elsewhere")
    monkeypatch.chdir("/")

    a, b = inputs_in(maps.parent / "elsewhere" / "out")

    assert a.path.samefile(maps.parent / "elsewhere" / "building_a.yaml")
    assert b.path.samefile(maps.parent / "elsewhere" / "b" / "building_b.pgm")


@pytest.mark.parametrize("named", ["out", "out/alignment.json", "link.json"])
def test_a_folder_or_an_answer_behind_a_link_is_no_obstacle(maps, named):
    (maps / "deep" / "er").mkdir(parents=True)
    (maps / "out").symlink_to(maps / "deep" / "er")
    (maps / "link.json").symlink_to(maps / "out" / "alignment.json")
    write_answer(maps / "out")

    assert inputs_in(maps / named)[0].path == maps / "building_a.yaml"


def test_they_are_read_as_the_merge_read_them(maps):
    with Image.open(maps / "b" / "building_b.pgm") as image:
        turned = 255 - np.asarray(image)
    Image.fromarray(turned).save(maps / "b" / "building_b.pgm")
    write_answer(maps / "out", levels={"free": 1, "occupied": 255, "unknown": 50})

    a, b = (map_input.read() for map_input in inputs_in(maps / "out"))

    assert (a.occupancy == read_map(drawing.DATA / "building_a.yaml").occupancy).all()
    assert (b.occupancy == read_map(drawing.DATA / "building_b.yaml").occupancy).all()


def test_a_map_that_moved_is_named_with_the_remedy_and_can_be_named_anew(maps):
    write_answer(maps / "out")
    moved = shutil.move(maps / "b" / "building_b.pgm", maps / "other.pgm")

    with pytest.raises(InputError, match=r"building_b\.pgm: map B .* no longer there; .*--b FILE"):
        inputs_in(maps / "out")

    _, b = inputs_in(maps / "out", b=moved)
    assert b.read().shape == read_map(drawing.DATA / "building_b.yaml").shape


@pytest.mark.parametrize("inputs", [None, 3, {"a": {"path": "x"}}, {"a": []}])
def test_an_answer_that_names_no_maps_is_refused_with_the_remedy(tmp_path, inputs):
    record = {"schema": SCHEMA, "verdict": "rejected", "reason": "told so", "inputs": inputs}
    (tmp_path / "alignment.json").write_text(json.dumps(record))

    with pytest.raises(InputError, match=r"alignment\.json: does not say where map A lies; .*--a FILE"):
        inputs_in(tmp_path)
