import json

import numpy as np
import pytest

from rectmerge import methods
from rectmerge.cli import console
from rectmerge.drawing import many_maps
from rectmerge.elastic.transform import BentTransform
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels
from rectmerge.io.map_file import read_map, write_map
from rectmerge.similarity import Similarity
from tests.rectmerge.cli.answers import YES_FILES, A, B, names, rectmerge
from tests.rectmerge.elastic.merges import write_bent_maps
from tests.rectmerge.elastic.test_unbend import bent_case
from tests.rectmerge.fleet.fleets import Fleet, Oracle

pytestmark = pytest.mark.usefixtures("small_pictures")


@pytest.fixture(scope="module")
def bent(tmp_path_factory):
    """Files of two maps that bend against each other, and the words that place B."""
    return write_bent_maps(tmp_path_factory.mktemp("bent"))


def test_bent_maps_are_merged_through_the_bend(bent, tmp_path, capsys):
    a, b, pixels = bent

    assert rectmerge("merge", a, b, pixels, "-o", tmp_path / "never", "--unbend", "never") == 0
    assert rectmerge("merge", a, b, pixels, "-o", tmp_path / "auto") == 0

    assert names(tmp_path / "never") == YES_FILES
    assert names(tmp_path / "auto") == YES_FILES | {"unbend.json"}
    assert "  unbent      bent by up to " in capsys.readouterr().out
    never, auto = (json.loads((tmp_path / name / "alignment.json").read_text()) for name in ("never", "auto"))
    assert "unbent" not in never
    assert auto["b_to_a"] == never["b_to_a"]
    unbent = auto["unbent"]
    assert unbent["accepted"] is True
    assert set(unbent) == {
        "accepted", "reason", "held_back_cost", "t", "walls_before", "walls_after", "largest_move", "stretch"
    }  # fmt: skip
    assert unbent["walls_after"] < unbent["walls_before"]
    walls = [int(read_map(tmp_path / name / "merged.yaml").occupied.sum()) for name in ("never", "auto")]
    assert walls[1] < 0.8 * walls[0]  # no longer each wall twice


def test_the_file_of_the_bend_carries_points_of_b_to_where_they_are(bent, tmp_path):
    a, b, pixels = bent
    rectmerge("merge", a, b, pixels, "-o", tmp_path)
    _, _, cells, true, _ = bent_case(2)
    text = (tmp_path / "unbend.json").read_text()

    moved = BentTransform.from_dict(json.loads(text)).apply(read_map(b).pixel_to_map(cells))

    off = read_map(a).map_to_pixel(moved) - true
    assert len(text) < 50_000
    assert np.sqrt((off**2).sum(axis=1).mean()) < 2.5


@pytest.mark.parametrize("words", [[], ["--unbend", "auto"]])
def test_rigid_maps_give_the_same_files_as_without_the_option(tmp_path, words):
    rectmerge("merge", A, B, "-o", tmp_path / "plain", "--unbend", "never")

    assert rectmerge("merge", A, B, "-o", tmp_path / "auto", *words) == 0

    assert names(tmp_path / "auto") == YES_FILES
    for name in YES_FILES - {"alignment.json"}:
        assert (tmp_path / "auto" / name).read_bytes() == (tmp_path / "plain" / name).read_bytes()
    first, second = (json.loads((tmp_path / name / "alignment.json").read_text()) for name in ("plain", "auto"))
    assert {**first, "seconds": 0} == {**second, "seconds": 0}


def test_always_tries_it_on_rigid_maps_too_and_says_no(tmp_path, capsys):
    assert rectmerge("merge", A, B, "-o", tmp_path, "--unbend", "always") == 0

    assert names(tmp_path) == YES_FILES
    record = json.loads((tmp_path / "alignment.json").read_text())
    assert record["unbent"]["accepted"] is False
    assert f"  unbent      no: {record['unbent']['reason']}" in capsys.readouterr().out


def test_a_second_merge_that_is_not_unbent_takes_the_file_of_the_bend_away(bent, tmp_path):
    a, b, pixels = bent
    rectmerge("merge", a, b, pixels, "-o", tmp_path)

    rectmerge("merge", a, b, pixels, "-o", tmp_path, "--unbend", "never", "--force")

    assert names(tmp_path) == YES_FILES


def test_another_word_is_refused_in_one_line(tmp_path, capsys):
    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--unbend", "maybe") == 2

    assert "--unbend: 'maybe' is not one of auto, never, always" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_refused_alignment_is_not_unbent(tmp_path, answer):
    answer("rejected")

    assert rectmerge("merge", A, B, "-o", tmp_path, "--unbend", "always") == 1

    assert "unbent" not in json.loads((tmp_path / "alignment.json").read_text())


def test_the_similarity_of_the_merge_is_the_placement_that_was_given(bent, tmp_path):
    a, b, pixels = bent
    rectmerge("merge", a, b, pixels, "-o", tmp_path)
    found = json.loads((tmp_path / "alignment.json").read_text())["b_to_a"]

    similarity = Similarity(found["scale"], found["angle_rad"], *found["translation"])

    expected = bent_case(2)[4].matrix
    assert np.allclose(map_frame_to_pixels(similarity, read_map(a), read_map(b)).matrix, expected, atol=1e-6)


def test_of_many_maps_each_is_bent_onto_the_others(tmp_path, capsys, monkeypatch):
    made = Fleet()
    made.add("a", "home", bent_case(2)[0], Similarity())
    for name, seed in (("b", 2), ("c", 3)):
        made.add(name, "home", bent_case(seed)[1], bent_case(seed)[4])
    for name, grid in made.maps.items():
        write_map(OccupancyGrid(grid.occupancy, 0.05 * made.poses[name].scale), tmp_path / f"{name}.yaml")
        made.maps[name] = read_map(tmp_path / f"{name}.yaml")
    monkeypatch.setattr(methods, "make_method", lambda name, **fields: Oracle(made))
    monkeypatch.setattr(many_maps, "SIDE_PX", 300)
    files = [tmp_path / f"{name}.yaml" for name in made.maps]

    for unbend in ("never", "auto"):
        assert rectmerge("merge", *files, "--unchecked", "--unbend", unbend, "-o", tmp_path / unbend) == 0

    told = capsys.readouterr().out
    assert told.count("  unbent      b: bent by up to ") == told.count("  unbent      c: bent by up to ") == 1
    never, auto = (json.loads((tmp_path / name / "fleet.json").read_text())["placements"] for name in ("never", "auto"))
    assert [auto[name]["unbent"]["accepted"] for name in "bc"] == [True, True]
    assert auto == {name: never[name] | ({"unbent": auto[name]["unbent"]} if name != "a" else {}) for name in never}
    walls = [int(read_map(tmp_path / name / "merged.yaml").occupied.sum()) for name in ("never", "auto")]
    assert walls[1] < 0.8 * walls[0]
    cells, true = bent_case(2)[2:4]
    places = made.maps["b"].pixel_to_map(cells)
    np.savetxt(tmp_path / "b.csv", places, delimiter=",", header="x,y", comments="")
    carried = ("--map", "b", "--points", tmp_path / "b.csv", "-o", tmp_path / "on_a.csv")
    assert rectmerge("transform", tmp_path / "auto", *carried) == 0
    moved = np.loadtxt(tmp_path / "on_a.csv", delimiter=",", skiprows=1)[:, :2]
    off = made.maps["a"].map_to_pixel(moved) - true
    assert np.sqrt((off**2).sum(axis=1).mean()) < 2.5
    assert rectmerge("transform", tmp_path / "auto", "--as", "pose") == 0
    assert "b was bent by up to " in capsys.readouterr().err
    x, y = places[0]
    assert rectmerge("transform", tmp_path / "auto", "--as", "matrix", "--map", "b", f"--at={x},{y}") == 0
    shown = capsys.readouterr()
    there = np.array([line.split() for line in shown.out.splitlines()[1:]], float)
    assert np.allclose(there @ [x, y, 1], [*moved[0], 1], atol=1e-6)
    assert "bent" not in shown.err
    (tmp_path / "auto" / "unbend.json").write_text("{}")
    assert rectmerge("transform", tmp_path / "auto", *carried) == console.BAD_INPUT
    assert "unbend.json: not an answer of rectmerge merge: there is no 'maps'" in capsys.readouterr().err
