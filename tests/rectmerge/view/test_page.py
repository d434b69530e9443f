import json
import re

import numpy as np
import pytest

from rectmerge.grid import OccupancyGrid
from rectmerge.results.alignment_json import AlignmentFile
from rectmerge.results.inputs import Input, saved_inputs
from rectmerge.view.page import html
from rectmerge.view.shown_alignment import ShownAlignment
from tests import drawing


def page_of(folder, **named):
    answer = AlignmentFile.read(folder)
    inputs = saved_inputs(answer, **named)
    return html(ShownAlignment.from_file(answer), inputs, *(map_input.read() for map_input in inputs))


def held_by(page):
    return json.loads(re.search(r'id="answer-data">(.*?)</script>', page, re.DOTALL).group(1))


def test_the_page_holds_everything_and_what_methods_say_is_not_markup(write_answer, tmp_path):
    page = page_of(write_answer(tmp_path))

    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    assert "@import" not in page
    assert "<b>as told" not in page
    assert "&lt;b&gt;as told" in page
    assert "building_b.yaml on building_a.yaml" in page


def test_matrices_are_told_in_full(write_answer, tmp_path):
    folder = write_answer(tmp_path)

    held = held_by(page_of(folder))

    for shown, saved in zip(held["candidates"], AlignmentFile.read(folder).record["candidates"], strict=True):
        assert shown["pixels"] == pytest.approx(np.ravel(saved["pixels"]), rel=1e-14)


def test_the_frames_take_pixels_to_the_map_frame(write_answer, tmp_path):
    folder = write_answer(tmp_path)

    frames = held_by(page_of(folder))["frames"]

    for map_input, frame in zip(saved_inputs(AlignmentFile.read(folder)), (frames["a"], frames["b"]), strict=True):
        m = np.reshape(frame, (2, 3))
        assert m @ [7.0, 3.0, 1.0] == pytest.approx(map_input.read().pixel_to_map([7.0, 3.0]))


def test_without_a_candidate_a_hand_starts_with_one_middle_on_the_other(write_answer, tmp_path):
    held = held_by(page_of(write_answer(tmp_path, verdict="rejected", candidates=0)))

    assert held["candidates"] == []
    start = np.reshape(held["start"], (2, 3))
    assert start[0, 0] == pytest.approx(1.2)  # by the resolutions
    assert start @ [(110 - 1) / 2, (90 - 1) / 2, 1] == pytest.approx([(163 - 1) / 2, (113 - 1) / 2])


def test_what_was_not_measured_is_shown_as_not_known(write_answer, tmp_path):
    folder = write_answer(tmp_path)
    record = json.loads((folder / "alignment.json").read_text())
    record["confidence"] = record["candidates"][0]["confidence"] = None
    (folder / "alignment.json").write_text(json.dumps(record))

    page = page_of(folder)

    assert "<b>no</b> confidence" in page
    assert held_by(page)["candidates"][0]["confidence"] is None


def test_rectangles_are_those_of_the_whole_map(write_answer, tmp_path):
    held = held_by(page_of(write_answer(tmp_path)))

    free = drawing.building().free
    assert held["rectangles"]["a"][0] == [12, 12, 60, 38]
    for x, y, w, h in held["rectangles"]["a"]:
        assert free[y : y + h, x : x + w].all()


def test_commands_read_the_maps_as_the_merge_did(write_answer, tmp_path):
    answer = ShownAlignment.from_file(AlignmentFile.read(write_answer(tmp_path)))
    greys = {"free": 254, "occupied": None, "unknown": 205}
    inputs = [
        Input(given="my a.png", path=tmp_path / "my a.png", greys=greys),
        Input(given="b.yaml", path=tmp_path / "b.yaml", greys=dict.fromkeys(greys), strict=True, resolution=0.1),
    ]

    page = html(answer, inputs, drawing.building(), drawing.building())

    assert held_by(page)["words"] == "'my a.png' b.yaml --strict-thresholds --free=254 --unknown=205 --resolution-b=0.1"


def test_a_map_of_nothing_known_is_shown_as_nothing(write_answer, tmp_path):
    answer = AlignmentFile.read(write_answer(tmp_path))
    empty = OccupancyGrid(np.full((5, 4), -1, np.int8))

    held = held_by(html(ShownAlignment.from_file(answer), saved_inputs(answer), empty, drawing.building()))

    assert held["rectangles"]["a"] == []
    assert held["maps"]["size"][:2] == [1, 1]
