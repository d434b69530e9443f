"""`fleet.json` of an earlier merge of many maps, as `merge --from`, `transform` and `view` read it."""

import json

import pytest

from rectmerge.cli import console
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import write_map
from tests.rectmerge.cli.many import MAPS, rectmerge
from tests.rectmerge.fleet.fleets import fleet

pytestmark = pytest.mark.usefixtures("small_pictures")


def test_answers_asked_with_other_settings_are_not_taken_over(merged_many, tmp_path, capsys):
    words = ("merge", *MAPS, "--from", merged_many, "-o", tmp_path / "out")

    assert rectmerge(*words, "--seed", "5") == console.BAD_INPUT
    assert "its pairs were asked with other seed; give the same, or leave out --from" in capsys.readouterr().err
    assert rectmerge(*words, "--set", "robust.max_candidates=3") == console.BAD_INPUT
    assert "with other fields" in capsys.readouterr().err
    assert rectmerge(*words) == console.YES


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"digests": None}, "not an answer of rectmerge merge"),
        ({"pairs": [{"a": "x"}]}, "there is no"),
        ({"settings": {}}, "there is no 'method'"),
        ({"bridges": [["a"]]}, "not an answer of rectmerge merge"),
    ],
)
def test_a_broken_record_is_named(merged_many, tmp_path, capsys, change, message):
    record = json.loads((merged_many / "fleet.json").read_text()) | change
    (tmp_path / "fleet.json").write_text(json.dumps(record))

    assert rectmerge("merge", *MAPS, "--from", tmp_path, "-o", tmp_path / "out") == console.BAD_INPUT
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("form", ["ros1", "ros2", "pose"])
def test_transform_prints_a_line_for_every_other_map(merged_many, capsys, form):
    assert rectmerge("transform", merged_many, "--as", form) == console.YES

    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2
    for line, name in zip(lines, "bc", strict=True):
        assert f"building_{name}" in line
        assert ("building_a" in line) == (form != "pose")


def test_transform_prints_matrices_and_takes_the_parent_s_name(merged_many, capsys):
    assert rectmerge("transform", merged_many / "fleet.json", "--as", "matrix", "--parent", "world") == console.YES

    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "# building_b in world"
    assert lines[3] == "0 0 1"
    assert len(lines) == 8


def test_transform_of_maps_in_cells_gives_no_line_for_tf(merged_many, tmp_path, capsys):
    record = json.loads((merged_many / "fleet.json").read_text())
    record["placements"]["building_c"]["shared"]["unit"] = "cells"
    (tmp_path / "fleet.json").write_text(json.dumps(record))

    assert rectmerge("transform", tmp_path, "--as", "ros2") == console.BAD_INPUT
    assert "TF is in metres, but the placement of building_c is in cells" in capsys.readouterr().err
    assert rectmerge("transform", tmp_path, "--as", "pose") == console.YES
    assert "the placement of building_c is in cells" in capsys.readouterr().err
    (tmp_path / "dock.csv").write_text("x,y\n0,0\n")
    assert rectmerge("transform", tmp_path, "--map", "building_c", "--points", tmp_path / "dock.csv") == console.YES
    assert "the placement of building_c is in cells" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"components": None}, "not an answer of rectmerge merge"),
        ({"placements": {}}, "there is no 'building_b'"),
        ({"components": [], "left_out": {}}, "no maps belong together"),
        ({"schema": "rectmerge.fleet/0"}, "its schema is 'rectmerge.fleet/0'"),
    ],
)
def test_transform_names_what_is_wrong_with_a_file(merged_many, tmp_path, capsys, change, message):
    record = json.loads((merged_many / "fleet.json").read_text()) | change
    (tmp_path / "fleet.json").write_text(json.dumps(record))

    assert rectmerge("transform", tmp_path) in (console.BAD_INPUT, console.NO)
    assert message in capsys.readouterr().err


def test_transform_of_one_map_carries_its_points_to_the_reference(merged_many, tmp_path, capsys):
    (tmp_path / "dock.csv").write_text("x,y\n0,0\n")

    assert rectmerge("transform", merged_many, "--map", "building_c", "--points", tmp_path / "dock.csv") == console.YES

    x, y = map(float, capsys.readouterr().out.splitlines()[1].split(","))
    place = json.loads((merged_many / "fleet.json").read_text())["placements"]["building_c"]["to_reference"]
    assert [x, y] == pytest.approx(place["translation"], abs=1e-6)
    assert rectmerge("transform", merged_many, "--map", "building_c", "--as", "pose") == console.YES
    assert len(capsys.readouterr().out.splitlines()) == 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--at=0,0",), "holds more than two maps; --map says whose points they are"),
        (("--map", "building_d"), "building_d is no map of this merge; placed are building_b, building_c"),
        (("--map", "building_a"), "building_a has no placement: it is the reference"),
    ],
)
def test_transform_says_which_maps_can_be_named(merged_many, capsys, options, message):
    assert rectmerge("transform", merged_many, *options) == console.BAD_INPUT
    assert message in capsys.readouterr().err


def test_commands_for_two_maps_say_so_where_there_are_more(merged_many, tmp_path, capsys):
    assert rectmerge("transform", merged_many, "--candidate", "1") == console.BAD_INPUT
    assert "holds more than two maps" in capsys.readouterr().err
    assert rectmerge("view", merged_many, "--no-open", "--a", MAPS[0]) == console.BAD_INPUT
    assert "--a and --b are for the merge of two" in capsys.readouterr().err
    assert rectmerge("merge", *MAPS[:2], "--from", merged_many, "-o", tmp_path / "out") == console.BAD_INPUT
    assert "holds more than two maps, but this is for the merge of two" in capsys.readouterr().err


def test_view_writes_the_page_of_the_graph(merged_many, tmp_path, capsys):
    page = tmp_path / "page.html"

    assert rectmerge("view", merged_many, "--no-open", "-o", page) == console.YES

    assert capsys.readouterr().out.strip() == str(page)
    assert "all 3 maps are in one" in page.read_text()


def test_view_names_a_map_that_has_changed_since(saved, tmp_path, capsys):
    made = fleet(1, home=3, other=0)
    files = saved(made)
    assert rectmerge("merge", *files.values(), "-o", tmp_path / "out") == console.YES
    write_map(OccupancyGrid(made.maps["home1"].occupancy[::-1]), files["home1"])

    assert rectmerge("view", tmp_path / "out", "--no-open") == console.YES
    assert "home1 changed since the merge" in capsys.readouterr().err
    files["home1"].unlink()
    assert rectmerge("view", tmp_path / "out", "--no-open") == console.BAD_INPUT
