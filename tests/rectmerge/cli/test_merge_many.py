import json
import re
from dataclasses import dataclass

import numpy as np
import pytest
import yaml

from rectmerge import methods
from rectmerge.cli import console, merge_many
from rectmerge.cli import main as cli
from rectmerge.drawing import many_maps
from rectmerge.drawing import maps as picture
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import read_map, write_map
from tests import drawing
from tests.rectmerge.fleet.fleets import Fleet, Oracle, fleet

MAPS = [drawing.DATA / f"building_{name}.yaml" for name in "abc"]
FILES = {"fleet.json", "transforms.yaml", "graph.png", "merged.yaml", "merged.pgm", "overlay.png", "conflict.png"}
SECOND = {"merged_2.yaml", "merged_2.pgm", "overlay_2.png", "conflict_2.png"}


@dataclass(frozen=True)
class Judge(Oracle):
    """Oracle that needs no check by the default method."""

    def align_by(self, hint, a, b, **asked):
        return self.align(a, b, **asked)


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    for module in (picture, many_maps):
        monkeypatch.setattr(module, "SIDE_PX", 300)


@pytest.fixture
def saved(tmp_path, monkeypatch):
    """Write a fleet's maps to files, and let every method answer from its truth; return the files by name."""

    def save(made: Fleet, **oracle):
        for name, grid in made.maps.items():
            write_map(OccupancyGrid(grid.occupancy, 0.05 * made.poses[name].scale), tmp_path / f"{name}.yaml")
            made.maps[name] = read_map(tmp_path / f"{name}.yaml")
        monkeypatch.setattr(methods, "make_method", lambda name, **fields: Judge(made, **oracle))
        return {name: tmp_path / f"{name}.yaml" for name in made.maps}

    return save


def rectmerge(*words: object) -> int:
    return console.run(cli.app, "rectmerge", [str(word) for word in words])


def names(folder):
    return {path.name for path in folder.iterdir()}


def test_three_maps_become_one(tmp_path, capsys):
    assert rectmerge("merge", *MAPS, "-o", tmp_path / "out") == console.YES

    told = capsys.readouterr().out
    assert told.startswith("all 3 maps are in one")
    assert names(tmp_path / "out") == FILES
    a, merged = read_map(MAPS[0]), read_map(tmp_path / "out" / "merged.yaml")
    assert merged.resolution == a.resolution
    at = np.rint(merged.map_to_pixel(a.pixel_to_map([40, 30]))).astype(int)
    assert merged.free[at[1], at[0]] == a.free[30, 40]
    saved = yaml.safe_load((tmp_path / "out" / "transforms.yaml").read_text())
    (component,) = saved["components"]
    assert component["merged"] == "merged.yaml"
    assert [row["map"] for row in component["transforms"]] == ["building_a", "building_b", "building_c"]
    assert component["transforms"][1]["yaw"] == pytest.approx(-drawing.B_IN_A.angle, abs=2e-3)
    assert component["transforms"][1]["scale"] == pytest.approx(1.0, abs=2e-3)


def test_some_maps_left_out_are_named_and_every_component_is_merged(tmp_path, saved, capsys):
    files = saved(fleet(1, home=4, other=3))
    lonely = fleet(7, home=1, other=0).maps["home0"]
    write_map(OccupancyGrid(lonely.occupancy, 0.05), tmp_path / "lonely.yaml")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Judge, "align", _silent_about(read_map(tmp_path / "lonely.yaml"), Judge.align))
        status = rectmerge("merge", *files.values(), tmp_path / "lonely.yaml", "-o", tmp_path / "out", "--json")

    assert status == console.NO
    assert names(tmp_path / "out") == FILES | SECOND
    record = json.loads(capsys.readouterr().out)
    assert record == json.loads((tmp_path / "out" / "fleet.json").read_text())
    assert record["components"] == [[f"home{k}" for k in range(4)], ["other0", "other1", "other2"]]
    assert record["merged"] == ["merged.yaml", "merged_2.yaml"]
    assert set(record["left_out"]) == {"lonely"}
    assert record["inputs"]["home1"]["path"] == "../home1.yaml"


def _silent_about(lonely, align):
    from rectmerge.alignment import Alignment

    def ask(self, a, b, **asked):
        if any(grid.shape == lonely.shape and (grid.occupancy == lonely.occupancy).all() for grid in (a, b)):
            return Alignment(verdict="rejected", reason="nothing fits", method="oracle")
        return align(self, a, b, **asked)

    return ask


def test_the_reference_keeps_its_frame(tmp_path, saved):
    files = saved(fleet(1, home=4, other=3))

    for given in ("other1", files["other1"]):
        words = ("merge", *files.values(), "-o", tmp_path / "out", "--reference", given, "--force")
        assert rectmerge(*words) == console.NO

        record = json.loads((tmp_path / "out" / "fleet.json").read_text())
        assert record["merged"] == ["merged_2.yaml", "merged.yaml"]
        assert record["components"][1] == ["other1", "other0", "other2"]
        merged, reference = read_map(tmp_path / "out" / "merged.yaml"), read_map(files["other1"])
        assert merged.resolution == pytest.approx(reference.resolution)


def test_all_or_nothing_writes_no_map_of_some(tmp_path, saved):
    files = saved(fleet(1, home=4, other=1))

    assert rectmerge("merge", *files.values(), "-o", tmp_path / "out", "--all-or-nothing") == console.NO

    assert names(tmp_path / "out") == {"fleet.json", "transforms.yaml", "graph.png"}


def test_nothing_but_ambiguous_pairs_is_ambiguous(tmp_path, saved, capsys):
    made = fleet(3, home=3, other=0, side=180)
    pairs = frozenset({("home0", "home1"), ("home0", "home2"), ("home1", "home2")})
    blind = saved(made, doubts=pairs - {("home0", "home2")}, blind=frozenset({("home0", "home2")}))

    assert rectmerge("merge", *blind.values(), "-o", tmp_path / "out") == console.AMBIGUOUS

    assert "none of 3 maps is sure to belong to another" in capsys.readouterr().out
    assert "merged.yaml" not in names(tmp_path / "out")


def test_a_merge_of_two_clears_that_of_many_and_keeps_its_files(tmp_path):
    out = tmp_path / "out"
    assert rectmerge("merge", *MAPS, "-o", out) == console.YES
    assert rectmerge("merge", *MAPS[:2], "-o", out) == console.BAD_INPUT

    assert rectmerge("merge", *MAPS[:2], "-o", out, "--force") == console.YES

    assert names(out) == {"alignment.json", "overlay.png", "conflict.png", "merged.yaml", "merged.pgm"}


BAD = {
    "a guess": (["--guess", "0,0,0"], "--guess is for two maps"),
    "no earlier merge": (["--from", "nowhere"], "nowhere: is no fleet.json, nor a folder that holds one"),
    "a resolution": (["--resolution-b", "0.1"], "--resolution-b is for two maps"),
    "cells of B": (["--output-resolution", "b"], "--output-resolution b is for two maps"),
    "a reference that is none": (["--reference", "d"], "--reference d is none of the maps: building_a, building_b"),
    "a map given twice": ([str(MAPS[0])], "building_a.yaml: is given twice"),
    "no such rule": (["--rule", "loudest"], "'loudest' is not one of"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_nothing_is_written(tmp_path, capsys, case):
    words, message = BAD[case]

    assert rectmerge("merge", *MAPS, *words, "-o", tmp_path / "out") == console.BAD_INPUT

    told = capsys.readouterr().err
    assert message in told
    assert len(told.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_options_for_many_maps_are_refused_for_two(tmp_path, capsys):
    for option in (["--reference", "building_b"], ["--all-or-nothing"]):
        assert rectmerge("merge", *MAPS[:2], *option, "-o", tmp_path / "out") == console.BAD_INPUT
        assert f"{option[0]} is for more than two maps" in capsys.readouterr().err


def test_maps_with_one_name_go_by_their_paths(tmp_path, saved):
    files = saved(fleet(1, home=3, other=0))
    (tmp_path / "below").mkdir()
    for suffix in (".yaml", ".pgm"):
        (tmp_path / f"home0{suffix}").rename(tmp_path / "below" / f"home1{suffix}")
    yaml_file = tmp_path / "below" / "home1.yaml"
    yaml_file.write_text(yaml_file.read_text().replace("home0.pgm", "home1.pgm"))

    rectmerge("merge", yaml_file, files["home1"], files["home2"], "-o", tmp_path / "out")

    record = json.loads((tmp_path / "out" / "fleet.json").read_text())
    assert record["maps"] == [str(yaml_file), str(files["home1"]), str(files["home2"])]


def test_workers_give_the_same_answer(merged, tmp_path):
    assert rectmerge("merge", *MAPS, "--workers", "2", "-o", tmp_path / "out") == console.YES

    one, two = (json.loads((folder / "fleet.json").read_text()) for folder in (merged, tmp_path / "out"))
    assert one["placements"] == two["placements"]


def test_progress_names_the_pairs_asked_and_the_time_left(tmp_path, saved, monkeypatch, capsys):
    files = saved(fleet(1, home=4, other=0))
    monkeypatch.setattr(merge_many, "PROGRESS_SECONDS", 0.0)

    rectmerge("merge", *files.values(), "-o", tmp_path / "out")

    told = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"rectmerge: 1 of about 6 pairs asked, about \d+ s left", told[0])


def test_a_map_is_added_by_asking_only_its_own_pairs(tmp_path, saved):
    made = fleet(1, home=5, other=0)
    files = saved(made)
    first, out, grown = list(files.values())[:4], tmp_path / "out", tmp_path / "grown"
    assert rectmerge("merge", *first, "-o", out) == console.YES
    method = Judge(made)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(methods, "make_method", lambda name, **fields: method)
        patch.setattr("rectmerge.method_fields.field_values", lambda method: _fields_of(out))
        assert rectmerge("merge", *files.values(), "--from", out, "-o", grown) == console.YES

    assert method.asked
    assert all("home4" in pair for pair in method.asked)
    before, after = (json.loads((folder / "fleet.json").read_text()) for folder in (out, grown))
    for name, placement in before["placements"].items():
        assert np.array(after["placements"][name]["pixels"]) == pytest.approx(np.array(placement["pixels"]), abs=1e-9)
    assert after["changes"] == {}


def _fields_of(folder):
    return json.loads((folder / "fleet.json").read_text())["settings"]["fields"]


def test_answers_asked_with_other_settings_are_not_taken_over(merged, tmp_path, capsys):
    words = ("merge", *MAPS, "--from", merged, "-o", tmp_path / "out")

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
def test_a_broken_record_is_named(merged, tmp_path, capsys, change, message):
    record = json.loads((merged / "fleet.json").read_text()) | change
    (tmp_path / "fleet.json").write_text(json.dumps(record))

    assert rectmerge("merge", *MAPS, "--from", tmp_path, "-o", tmp_path / "out") == console.BAD_INPUT
    assert message in capsys.readouterr().err


@pytest.fixture(scope="module")
def merged(tmp_path_factory):
    out = tmp_path_factory.mktemp("many") / "out"
    assert rectmerge("merge", *MAPS, "-o", out, "-q") == console.YES
    return out


@pytest.mark.parametrize("form", ["ros1", "ros2", "pose"])
def test_transform_prints_a_line_for_every_other_map(merged, capsys, form):
    assert rectmerge("transform", merged, "--as", form) == console.YES

    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2
    for line, name in zip(lines, "bc", strict=True):
        assert f"building_{name}" in line
        assert ("building_a" in line) == (form != "pose")


def test_transform_prints_matrices_and_takes_the_parent_s_name(merged, capsys):
    assert rectmerge("transform", merged / "fleet.json", "--as", "matrix", "--parent", "world") == console.YES

    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "# building_b in world"
    assert lines[3] == "0 0 1"
    assert len(lines) == 8


def test_transform_of_maps_in_cells_gives_no_line_for_tf(merged, tmp_path, capsys):
    record = json.loads((merged / "fleet.json").read_text())
    record["placements"]["building_c"]["shared"]["unit"] = "cells"
    (tmp_path / "fleet.json").write_text(json.dumps(record))

    assert rectmerge("transform", tmp_path, "--as", "ros2") == console.BAD_INPUT
    assert "TF is in metres, but the placement of building_c is in cells" in capsys.readouterr().err
    assert rectmerge("transform", tmp_path, "--as", "pose") == console.YES
    assert "the placement of building_c is in cells" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"components": None}, "not an answer of rectmerge merge"),
        ({"placements": {}}, "there is no 'building_b'"),
        ({"components": [], "left_out": {}}, "no maps belong together"),
    ],
)
def test_transform_names_what_is_wrong_with_a_file(merged, tmp_path, capsys, change, message):
    record = json.loads((merged / "fleet.json").read_text()) | change
    (tmp_path / "fleet.json").write_text(json.dumps(record))

    assert rectmerge("transform", tmp_path) in (console.BAD_INPUT, console.NO)
    assert message in capsys.readouterr().err


def test_commands_for_two_maps_say_so_where_there_are_more(merged, tmp_path, capsys):
    assert rectmerge("transform", merged, "--candidate", "1") == console.BAD_INPUT
    assert "holds more than two maps" in capsys.readouterr().err
    assert rectmerge("view", merged, "--no-open", "--a", MAPS[0]) == console.BAD_INPUT
    assert "--a and --b are for the merge of two" in capsys.readouterr().err
    assert rectmerge("merge", *MAPS[:2], "--from", merged, "-o", tmp_path / "out") == console.BAD_INPUT
    assert "holds more than two maps, but this is for the merge of two" in capsys.readouterr().err


def test_view_writes_the_page_of_the_graph(merged, tmp_path, capsys):
    page = tmp_path / "page.html"

    assert rectmerge("view", merged, "--no-open", "-o", page) == console.YES

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
