import json
import math
import re
import shutil

import pytest

from rectmerge.cli.console import run
from rectmerge.cli.main import app
from rectmerge.io.map_file import read_map
from rectmerge.similarity import Similarity
from tests import drawing


def rectmerge(monkeypatch, *words):
    monkeypatch.setattr("sys.argv", ["rectmerge", *map(str, words)])
    return run(app, "rectmerge")


@pytest.fixture(scope="module")
def merged(tmp_path_factory):
    """The folder of a merge of the committed maps."""
    out = tmp_path_factory.mktemp("merged") / "out"
    with pytest.MonkeyPatch.context() as patch:
        assert (
            rectmerge(patch, "merge", drawing.DATA / "building_a.yaml", drawing.DATA / "building_b.yaml", "-o", out)
            == 0
        )
    return out


def decimals(text):
    return [float(word) for word in re.findall(r"-?\d+\.\d+", text)]


@pytest.fixture(scope="module")
def write_units(merged, tmp_path_factory):
    """Write the answer of a merge anew, with the units of both maps."""

    def write(unit_a, unit_b):
        record = json.loads((merged / "alignment.json").read_text())
        for candidate in record["candidates"]:
            candidate["b_to_a"]["unit"], candidate["shared"]["unit"] = unit_a, unit_b
        record["b_to_a"] = record["candidates"][0]["b_to_a"]
        folder = tmp_path_factory.mktemp("units")
        (folder / "alignment.json").write_text(json.dumps(record))
        return folder

    return write


@pytest.mark.parametrize("form", ["ros1", "ros2"])
@pytest.mark.parametrize(
    ("units", "message"),
    [
        (("cells", "cells"), "maps A and B are in cells, not in metres; merge again with --resolution-a METRES and"),
        (("cells", "m"), "map A is in cells, not in metres; merge again with --resolution-a METRES\n"),
        (("m", "cells"), "map B is in cells, not in metres; merge again with --resolution-b METRES\n"),
    ],
)
def test_there_is_no_line_for_tf_in_cells(write_units, monkeypatch, capsys, form, units, message):
    assert rectmerge(monkeypatch, "transform", write_units(*units), "--as", form) == 2

    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.startswith(f"rectmerge: TF is in metres: {message}")


@pytest.mark.parametrize("words", [["--as", "pose"], ["--as", "matrix"], ["--points", "way.csv"]])
def test_what_is_in_cells_is_told_as_such(write_units, tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "way.csv").write_text("x,y\n1,2\n")

    assert rectmerge(monkeypatch, "transform", write_units("cells", "cells"), *words) == 0
    in_cells = capsys.readouterr()
    assert rectmerge(monkeypatch, "transform", write_units("m", "m"), *words) == 0
    in_metres = capsys.readouterr()

    assert in_cells.out == in_metres.out
    assert in_cells.err.startswith("rectmerge: maps A and B are in cells, not in metres; ")
    assert "in cells" not in in_metres.err


def test_a_merge_tells_the_units_of_both_maps(tmp_path, monkeypatch):
    plain = drawing.DATA / "building_b.pgm"
    assert rectmerge(monkeypatch, "merge", drawing.DATA / "building_a.yaml", plain, "-o", tmp_path) == 0

    (first, *_) = json.loads((tmp_path / "alignment.json").read_text())["candidates"]
    assert (first["b_to_a"]["unit"], first["shared"]["unit"]) == ("m", "cells")


def test_a_merge_becomes_a_line_for_tf(merged, monkeypatch, capsys):
    assert rectmerge(monkeypatch, "transform", merged, "--as", "ros2", "--parent", "world") == 0

    shown = capsys.readouterr()
    record = json.loads((merged / "alignment.json").read_text())
    assert "--frame-id world --child-frame-id map_b" in shown.out
    assert decimals(shown.out)[2] == pytest.approx(math.remainder(record["b_to_a"]["angle_rad"], math.tau), abs=1e-6)
    assert "off by" not in shown.err  # the resolutions were right: nothing to tell


def test_a_scale_that_tf_cannot_carry_is_told_with_what_it_costs(merged, tmp_path, monkeypatch, capsys):
    record = json.loads((merged / "alignment.json").read_text())
    record["candidates"][0]["b_to_a"]["scale"] *= 1.02
    record["b_to_a"] = record["candidates"][0]["b_to_a"]
    (tmp_path / "alignment.json").write_text(json.dumps(record))

    assert rectmerge(monkeypatch, "transform", tmp_path, "--as", "pose") == 0
    assert re.search(r"scale of 1\.02\d+, .* off by 0\.0\d\d m RMS", capsys.readouterr().err)


@pytest.fixture(scope="module")
def ten_times(tmp_path_factory):
    """The folder of a merge for which B's resolution was told ten times too large."""
    out = tmp_path_factory.mktemp("ten") / "out"
    maps = [drawing.DATA / f"building_{name}.yaml" for name in "ab"]
    with pytest.MonkeyPatch.context() as patch:
        assert rectmerge(patch, "merge", *maps, "--resolution-b", 0.6, "--candidate", 1, "-o", out) == 0
    return out


RESOLUTIONS = "B's would be 0.06 rather than 0.6, or A's 0.5 rather than 0.05; merge again with the right"


@pytest.mark.parametrize("form", ["ros1", "ros2", "pose"])
@pytest.mark.parametrize("quiet", [[], ["--quiet"]])
def test_a_scale_that_only_a_wrong_resolution_explains_is_not_left_out(ten_times, monkeypatch, capsys, form, quiet):
    assert rectmerge(monkeypatch, "transform", ten_times, "--as", form, *quiet) == 2

    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.startswith(f"rectmerge: map B fits at a scale of 0.1, so one resolution is wrong: {RESOLUTIONS}")
    assert len(shown.err.splitlines()) == 1


@pytest.mark.parametrize("words", [["--as", "matrix"], ["--points", drawing.DATA / "waypoints_b.csv"]])
def test_what_keeps_the_scale_is_told_whatever_it_is_with_a_note(ten_times, monkeypatch, capsys, words):
    assert rectmerge(monkeypatch, "transform", ten_times, *words) == 0

    shown = capsys.readouterr()
    assert shown.out
    assert RESOLUTIONS in shown.err


def test_points_are_carried_to_a_file(merged, monkeypatch, tmp_path):
    (tmp_path / "way.csv").write_text("x,y\n0.5,0.5\n")

    assert (
        rectmerge(monkeypatch, "transform", merged, "--points", tmp_path / "way.csv", "-o", tmp_path / "on_a.csv") == 0
    )

    record = json.loads((merged / "alignment.json").read_text())["b_to_a"]
    placed = Similarity(record["scale"], record["angle_rad"], *record["translation"])
    assert decimals((tmp_path / "on_a.csv").read_text()) == pytest.approx(placed.apply([0.5, 0.5]), abs=1e-6)


def test_a_spreadsheets_mark_is_no_part_of_the_first_heading(merged, monkeypatch, tmp_path, capsys):
    (tmp_path / "way.csv").write_text("x,y\n0.5,0.5\n", encoding="utf-8-sig")

    assert rectmerge(monkeypatch, "transform", merged, "--points", tmp_path / "way.csv") == 0
    assert capsys.readouterr().out.startswith("x,y\n")


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("way.csv", "is an input"),
        ("link.csv", "is an input"),
        ("out/alignment.json", "is an input"),
        ("answer.json", "is an input"),
        ("folder/merged.pgm", "is for a result"),
        ("folder/overlay_7.png", "is for a result"),
        ("picture.csv", "is for a result"),
    ],
)
@pytest.mark.parametrize("named", ["out", "folder", "answer.json"])
def test_points_are_not_written_over_what_is_read_or_was_merged(
    merged, monkeypatch, tmp_path, capsys, named, output, message
):
    shutil.copytree(merged, tmp_path / "out")
    (tmp_path / "way.csv").write_text("x,y\n0.5,0.5\n")
    links = {
        "link.csv": "way.csv",
        "folder": "out",
        "answer.json": "out/alignment.json",
        "picture.csv": "out/overlay.png",
    }
    for link, target in links.items():
        (tmp_path / link).symlink_to(target)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    monkeypatch.chdir(tmp_path)

    assert rectmerge(monkeypatch, "transform", named, "--points", "way.csv", "-o", output) == 2
    assert f"rectmerge: {output}: {message}" in capsys.readouterr().err
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


@pytest.mark.parametrize(
    ("frames", "words", "parent", "child"),
    [
        (("robot1/map", "robot2/map"), [], "robot1/map", "robot2/map"),
        (("robot1/map", "robot2/map"), ["--parent", "world"], "world", "robot2/map"),
        (("map", "map"), [], "map_a", "map_b"),
        (("robot1/map", None), [], "map_a", "map_b"),
        ((None, None), ["--parent", "a b", "--child", "$HOME"], "'a b'", "'$HOME'"),
    ],
)
def test_frames_are_as_named_else_as_bags_say(merged, tmp_path, monkeypatch, capsys, frames, words, parent, child):
    record = json.loads((merged / "alignment.json").read_text())
    for name, frame in zip("ab", frames, strict=True):
        record["inputs"][name]["frame"] = frame
    (tmp_path / "alignment.json").write_text(json.dumps(record))

    assert rectmerge(monkeypatch, "transform", tmp_path, "--as", "ros1", *words) == 0
    assert capsys.readouterr().out.endswith(f" {parent} {child}\n")
    assert rectmerge(monkeypatch, "transform", tmp_path, "--as", "ros2", *words) == 0
    assert capsys.readouterr().out.endswith(f" --frame-id {parent} --child-frame-id {child}\n")


def test_a_merge_of_bags_tells_their_frames(tmp_path, monkeypatch, capsys):
    pytest.importorskip("rosbags")
    from tests.rectmerge import bags

    messages = []
    for name in "ab":
        grid = read_map(drawing.DATA / f"building_{name}.yaml")
        x, y, yaw = grid.origin
        changes = {"cells": grid.occupancy, "resolution": grid.resolution, "at": (x, y, 0.0), "turn": bags.level(yaw)}
        messages.append((f"/{name}/map", bags.GRID, {**changes, "frame": f"{name}/map"}))
    bag = bags.write(tmp_path, "mcap", messages)

    assert rectmerge(monkeypatch, "merge", f"{bag}:/a/map", f"{bag}:/b/map", "-o", tmp_path / "out") == 0
    capsys.readouterr()
    assert rectmerge(monkeypatch, "transform", tmp_path / "out") == 0
    assert capsys.readouterr().out.endswith(" --frame-id a/map --child-frame-id b/map\n")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--parent", ""], "--parent must name a frame, got ''"),
        (["--child", " "], "--child must name a frame, got ' '"),
        (["--child", "a\nb"], r"--child must name a frame, got 'a\nb'"),
        (["--parent", "map_b"], "TF takes no frame to itself, but both are 'map_b'"),
        (["--as", "tf"], "--as"),
        (["--candidate", "99"], "there is no candidate 99"),
        (["-o", "x.csv"], "--points"),
        (["--points", "none.csv"], "none.csv: cannot be read"),
    ],
)
def test_bad_use_is_one_line(merged, monkeypatch, capsys, words, message):
    assert rectmerge(monkeypatch, "transform", merged, *words) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("content", [None, "{", "[]", '{"verdict": "accepted", "candidates": [{}]}'])
def test_a_folder_without_an_answer_is_named(tmp_path, monkeypatch, capsys, content):
    if content is not None:
        (tmp_path / "alignment.json").write_text(content)

    assert rectmerge(monkeypatch, "transform", tmp_path) == 2
    assert "alignment.json" in capsys.readouterr().err


def test_a_no_is_told_with_its_reason_and_a_candidate_can_be_taken(tmp_path, merged, monkeypatch, capsys):
    record = json.loads((merged / "alignment.json").read_text()) | {"verdict": "rejected", "reason": "no wall"}
    count = len(record["candidates"])
    (tmp_path / "alignment.json").write_text(json.dumps(record))

    assert rectmerge(monkeypatch, "transform", tmp_path) == 1
    shown = capsys.readouterr()
    assert shown.err == f"rectmerge: {tmp_path}: rejected, no wall; --candidate K takes one of its {count}\n"
    assert not shown.out
    assert rectmerge(monkeypatch, "transform", tmp_path, "--candidate", "1") == 0


def test_a_merge_of_two_maps_needs_no_name_of_a_map(merged, monkeypatch, capsys):
    assert rectmerge(monkeypatch, "transform", merged, "--map", "b") == 2
    assert "holds two maps; --map is for more" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["building_a.pgm", "building_b.yaml"])
def test_points_are_not_written_over_a_map_of_the_merge(tmp_path, monkeypatch, capsys, name):
    for file in ("building_a.pgm", "building_a.yaml", "building_b.pgm", "building_b.yaml", "waypoints_b.csv"):
        shutil.copy(drawing.DATA / file, tmp_path)
    rectmerge(monkeypatch, "merge", tmp_path / "building_a.yaml", tmp_path / "building_b.yaml", "-o", tmp_path / "out")
    before = (tmp_path / name).read_bytes()

    words = ("transform", tmp_path / "out", "--points", tmp_path / "waypoints_b.csv", "-o", tmp_path / name)
    assert rectmerge(monkeypatch, *words) == 2
    assert "is an input, and would be replaced" in capsys.readouterr().err
    assert (tmp_path / name).read_bytes() == before
