import json
import re

import numpy as np
import pytest
import yaml

from rectmerge import methods
from rectmerge.cli import console, merge_many
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import read_map, write_map
from tests import drawing
from tests.rectmerge.cli.answers import names
from tests.rectmerge.cli.many import MAPS, Judge, rectmerge
from tests.rectmerge.fleet.fleets import fleet

pytestmark = pytest.mark.usefixtures("small_pictures")
FILES = {"fleet.json", "transforms.yaml", "graph.png", "merged.yaml", "merged.pgm", "overlay.png", "conflict.png"}
SECOND = {"merged_2.yaml", "merged_2.pgm", "overlay_2.png", "conflict_2.png"}


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


def test_workers_give_the_same_answer(merged_many, tmp_path):
    assert rectmerge("merge", *MAPS, "--workers", "2", "-o", tmp_path / "out") == console.YES

    one, two = (json.loads((folder / "fleet.json").read_text()) for folder in (merged_many, tmp_path / "out"))
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
