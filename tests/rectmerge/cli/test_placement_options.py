"""`merge` with a person's help, and `check`: as people type them."""

import json

import numpy as np
import pytest

import rectmerge as rm
from rectmerge.cli import console
from rectmerge.cli import main as cli
from rectmerge.cli.placement_options import PlacementOptions, parse_guess, parse_pixels
from tests import drawing

A, B = (str(drawing.DATA / f"building_{name}.yaml") for name in "ab")


def run(*words):
    return console.run(cli.app, "rectmerge", [str(word) for word in words])


@pytest.fixture(scope="module")
def alignment():
    return rm.align(rm.read_map(A), rm.read_map(B))


def record(folder):
    return json.loads((folder / "alignment.json").read_text())


def as_text(pixels):
    (a, _, tx), (b, _, ty) = pixels.matrix.tolist()
    return f"{a},{b},{tx},{ty}"


def test_a_placement_by_hand_is_merged_exactly_and_the_reason_says_what_the_walls_say(tmp_path, alignment):
    pixels = rm.Similarity(
        alignment.pixels.scale, alignment.pixels.angle, alignment.pixels.tx + 1.25, alignment.pixels.ty
    )

    status = run("merge", A, B, "-o", tmp_path, f"--pixels={as_text(pixels)}")

    assert status == console.YES
    assert np.allclose(record(tmp_path)["pixels"], pixels.matrix)
    assert record(tmp_path)["reason"].startswith("placed by hand; the walls say: accepted, ")
    assert (tmp_path / "merged.yaml").exists()


def test_a_wrong_placement_by_hand_is_merged_as_well_but_not_praised(tmp_path):
    assert run("merge", A, B, "-o", tmp_path, "--pixels", "1,0,-20,5") == console.YES

    assert "the walls say: rejected" in record(tmp_path)["reason"]
    assert record(tmp_path)["confidence"] < 0.1


def test_an_earlier_answer_places_maps_that_have_grown(tmp_path, alignment, capsys):
    run("merge", A, B, "-o", tmp_path / "first")
    grid = rm.read_map(B)
    grown = np.pad(grid.occupancy, ((7, 0), (0, 5)), constant_values=-1)  # rows above and columns to the right
    rm.write_map(rm.OccupancyGrid(grown, grid.resolution, grid.origin), tmp_path / "grown.yaml")

    run("merge", A, B, "-o", tmp_path / "again", "--from", tmp_path / "first")
    assert "is a merge of" not in capsys.readouterr().err
    run("merge", A, tmp_path / "grown.yaml", "-o", tmp_path / "second", "--from", tmp_path / "first")
    assert f"is a merge of {A} and {B}; its placement is taken for other maps" in capsys.readouterr().err

    b_to_a = record(tmp_path / "second")["b_to_a"]
    assert b_to_a["translation"] == pytest.approx([alignment.b_to_a.tx, alignment.b_to_a.ty], abs=1e-6)
    assert record(tmp_path / "second")["reason"].startswith("placed as an earlier merge did; the walls say: accepted, ")


@pytest.mark.slow
def test_a_candidate_is_chosen_of_an_earlier_answer_that_said_no(tmp_path, capsys):
    run("merge", A, B, "-o", tmp_path / "no", "--scale", "1.5")
    assert run("merge", A, B, "-o", tmp_path / "out", "--from", tmp_path / "no" / "alignment.json") == console.BAD_INPUT
    assert "--candidate" in capsys.readouterr().err

    assert run("merge", A, B, "-o", tmp_path / "out", "--from", tmp_path / "no", "--candidate", 2) == console.YES

    wanted = record(tmp_path / "no")["candidates"][1]["pixels"]
    assert np.allclose(record(tmp_path / "out")["pixels"], wanted)
    assert record(tmp_path / "out")["reason"].startswith("placed as candidate 2 of an earlier merge; the walls say: ")


def test_a_candidate_is_chosen_of_the_same_search(tmp_path):
    assert run("merge", A, B, "-o", tmp_path, "--candidate", 2) == console.YES

    answer = record(tmp_path)
    assert answer["reason"].startswith("candidate 2, chosen by hand; unaided the verdict is: accepted")
    assert answer["confidence"] == answer["candidates"][0]["confidence"] < 0.5


def test_a_guess_is_taken_in_the_frame_of_a(tmp_path, alignment):
    at = alignment.b_to_a

    assert run("merge", A, B, "-o", tmp_path, f"--guess={at.tx + 0.3},{at.ty},{at.angle}") == console.YES


def test_resolutions_may_be_told(tmp_path, capsys):
    images = [name.replace(".yaml", ".pgm") for name in (A, B)]

    assert run("merge", *images, "-o", tmp_path, "--resolution-a", 0.05, "--resolution-b", 0.06) == console.YES

    answer = record(tmp_path)
    assert answer["scale"]["expected"] == pytest.approx(1.2)
    assert answer["b_to_a"]["unit"] == "m"
    assert answer["inputs"]["b"]["resolution"] == 0.06
    assert "resolution 0.05 m as given" in capsys.readouterr().err


def test_a_check_says_what_merge_says_and_how_to_go_on(capsys, alignment):
    status = run("check", A, B, "--pixels", as_text(alignment.pixels))

    out = capsys.readouterr().out
    assert status == console.YES
    assert out.startswith("accepted: ")
    assert "--pixels=1.05" in out


def test_a_check_of_a_wrong_placement_ends_with_status_1_and_writes_json(capsys):
    status = run("check", A, B, "--pixels", "1,0,-20,5", "--json")

    answer = json.loads(capsys.readouterr().out)
    assert status == console.NO
    assert answer["verdict"] == "rejected"
    assert answer["moved_cells"] is not None


def test_a_check_that_finds_nothing_near_calls_nothing_exact_and_says_what_is_better(capsys, alignment):
    assert run("check", A, B, "--pixels", "1,0,-20,5") == console.NO

    out = capsys.readouterr().out
    assert "made exact" not in out
    assert "to merge" not in out
    assert "not exact   nothing fits near there" in out
    (better,) = [line for line in out.splitlines() if line.startswith("  better")]
    assert np.allclose(parse_pixels(better.partition("--pixels=")[2]).matrix, alignment.pixels.matrix, atol=0.5)


def test_a_check_of_a_rough_placement_that_fits_says_that_it_was_moved(capsys):
    assert run("check", A, B, "--pixels", "1.0,0.7,75,14") == console.YES

    out = capsys.readouterr().out
    assert "made exact" not in out
    assert "cells of A, to where the walls agree" in out
    assert "better" not in out


BAD = {
    "three numbers": (["--pixels", "1,2,3"], "'1,2,3' is not a,b,tx,ty"),
    "words": (["--guess", "left,up,0"], "is not x,y,yaw"),
    "not a number": (["--guess", "nan,0,0"], "is not x,y,yaw"),
    "two helps": (["--guess", "0,0,0", "--pixels", "1,0,0,0"], "--guess and --pixels exclude each other"),
    "a chosen hand": (["--candidate", "1", "--pixels", "1,0,0,0"], "--pixels and --candidate exclude each other"),
    "mirrored": (["--pixels", "1,0,0,0,-1,0"], "not a rotation with uniform scale"),
    "nothing": (["--pixels", "0,0,5,5"], "scale must be > 0"),
    "a slip in the scale": (
        ["--pixels", "5000,0,70,20"],
        "scale of 5000 cells of A per cell of B, far beyond 1.176 to 1.224",
    ),
    "no candidate": (["--candidate", "99"], "there is no candidate 99"),
    "no answer": (["--from", "nowhere"], "nowhere"),
    "no resolution": (["--resolution-a", "-1"], "--resolution-a: -1.0 is not a positive number of metres per cell"),
    "no resolution of B": (
        ["--resolution-b", "nan"],
        "--resolution-b: nan is not a positive number of metres per cell",
    ),
    "no dialect": (["--dialect", "ros3"], "ros3"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_help_is_refused_before_anything_is_written(tmp_path, capsys, case):
    words, message = BAD[case]

    assert run("merge", A, B, "-o", tmp_path / "out", *words) == console.BAD_INPUT
    assert message in " ".join(capsys.readouterr().err.replace("│", " ").split())
    assert not (tmp_path / "out").exists()


def test_an_answer_in_cells_does_not_place_maps_in_metres(tmp_path, capsys):
    images = [name.replace(".yaml", ".pgm") for name in (A, B)]
    run("merge", *images, "-o", tmp_path / "cells")

    assert run("merge", A, B, "-o", tmp_path / "out", "--from", tmp_path / "cells") == console.BAD_INPUT
    assert "places map B in cells, but map A is in m" in capsys.readouterr().err


def test_numbers_are_read_as_they_are_printed():
    assert parse_guess("1,-2.5,3e-1") == (1.0, -2.5, 0.3)
    assert parse_pixels("0.5,-0.25,3,4").matrix.tolist() == [[0.5, 0.25, 3.0], [-0.25, 0.5, 4.0]]
    with pytest.raises(rm.InputError):
        PlacementOptions(guess="0,0,0", pixels="1,0,0,0")
