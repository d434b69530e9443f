import json
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rectmerge import methods
from rectmerge.alignment import Alignment, Candidate
from rectmerge.drawing import overlay
from rectmerge.grid import map_frame_to_pixels
from rectmerge.io.map_file import read_map, write_map
from rectmerge.results.summary import describe
from rectmerge.similarity import Similarity
from tests import drawing
from tests.rectmerge.cli.answers import YES_FILES, A, B, FixedAnswers, names, rectmerge, write_plain

pytestmark = pytest.mark.usefixtures("small_pictures")


def test_a_yes_writes_the_merged_map_and_exits_0(tmp_path, answer, capsys):
    answer("accepted")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out") == 0

    assert names(tmp_path / "out") == YES_FILES
    merged, a = read_map(tmp_path / "out" / "merged.yaml"), read_map(A)
    assert merged.resolution == a.resolution
    waypoint = a.pixel_to_map([30.0, 30.0])
    col, row = np.rint(merged.map_to_pixel(waypoint)).astype(int)
    assert (merged.occupancy[row : row + 20, col : col + 20] == a.occupancy[30:50, 30:50]).all()
    out = capsys.readouterr().out
    for said in ("accepted: told so", "1.2000 cells of A per cell of B", "-28.65 deg", "merged.yaml"):
        assert said in out


@pytest.mark.parametrize(("verdict", "status"), [("rejected", 1), ("ambiguous", 3)])
def test_another_answer_writes_an_overlay_per_candidate_and_no_map(tmp_path, answer, capsys, verdict, status):
    answer(verdict, candidates=2)

    assert rectmerge("merge", A, B, "-o", tmp_path / "out") == status

    assert names(tmp_path / "out") == {"alignment.json", "overlay_1.png", "overlay_2.png"}
    assert f"{verdict}: told so" in capsys.readouterr().out


@pytest.mark.parametrize(("count", "listed"), [(2, 2), (7, 5)])
def test_another_answer_lists_its_candidates_and_says_how_to_take_one(tmp_path, answer, capsys, count, listed):
    answer("ambiguous", candidates=count)

    rectmerge("merge", A, B, "-o", tmp_path / "out")

    _, _, heads, *rows = capsys.readouterr().out.splitlines()
    assert heads.split() == ["candidate", "confidence", "rotation", "scale", "overlap", "conflict", "picture"]
    for number, row in enumerate(rows[:listed], start=1):
        assert len(row) == len(heads)
        assert row.split()[:6] == [str(number), "0.97", "-28.65", "deg", "1.2000", "99%"]
        assert row.endswith(f" overlay_{number}.png")
    assert "1.2000 cells of A per cell of B by the resolutions" in rows[listed]
    assert "--candidate K --force" in rows[listed + 1]


@pytest.mark.parametrize(("conflict", "is_told"), [(0.28, True), (0.05, False)])
def test_a_yes_with_much_conflict_asks_for_a_look_at_the_pictures(conflict, is_told):
    maps = read_map(A), read_map(B)
    placed = replace(Candidate.from_pixels(drawing.B_IN_A, *maps, confidence=1.0), conflict=conflict)
    yes = Alignment(verdict="accepted", reason="told so", method="m", candidates=(placed,), confidence=1.0)

    assert ("walls stand double" in describe(yes, [Path("out/overlay.png")])) == is_told
    assert "overlay.png" not in describe(yes)  # nothing was drawn


def placed_beside(a, b, **asked) -> Alignment:
    """Accept the truth shifted by twenty cells."""
    pixels = Similarity(drawing.B_IN_A.scale, drawing.B_IN_A.angle, drawing.B_IN_A.tx + 20, drawing.B_IN_A.ty)
    candidate = Candidate.from_pixels(pixels, a, b, confidence=1.0)
    return Alignment(verdict="accepted", reason="sure", method="beside", candidates=(candidate,), confidence=1.0)


def test_a_wrong_yes_of_another_method_writes_no_map_unless_unchecked(tmp_path, monkeypatch, capsys):
    make = methods.make_method
    beside = SimpleNamespace(name="beside", align=placed_beside)
    monkeypatch.setattr(methods, "make_method", lambda name, **fields: beside if name == "beside" else make(name))
    merge = ("merge", A, B, "--method", "beside", "-o", tmp_path / "out")

    assert rectmerge(*merge) == 1
    assert names(tmp_path / "out") == {"alignment.json", "overlay_1.png"}
    record = json.loads((tmp_path / "out" / "alignment.json").read_text())
    assert (record["verdict"], record["method_verdict"], record["checked"]) == ("rejected", "accepted", "rejected")
    assert record["candidates"][0]["pixels"][0][2] == pytest.approx(drawing.B_IN_A.tx + 20)

    assert rectmerge(*merge, "--unchecked", "--force") == 0
    assert names(tmp_path / "out") == YES_FILES
    record = json.loads((tmp_path / "out" / "alignment.json").read_text())
    assert (record["verdict"], record["method_verdict"], record["checked"]) == ("accepted", "accepted", None)


def test_the_pictures_bear_the_verdict(tmp_path, answer, monkeypatch):
    titles = []
    draw = overlay.draw_overlay
    monkeypatch.setattr(overlay, "draw_overlay", lambda *maps, title: titles.append(title) or draw(*maps, title=title))

    for verdict, count in (("accepted", 1), ("ambiguous", 2)):
        answer(verdict, candidates=count)
        rectmerge("merge", A, B, "-o", tmp_path / verdict)

    assert titles == [
        "accepted, confidence 0.97",
        "ambiguous: candidate 1 of 2, confidence 0.97",
        "ambiguous: candidate 2 of 2, confidence 0.97",
    ]


def test_a_no_without_candidates_still_leaves_its_reason(tmp_path, answer):
    answer("rejected", candidates=0)

    assert rectmerge("merge", A, B, "-o", tmp_path / "out") == 1

    assert json.loads((tmp_path / "out" / "alignment.json").read_text())["reason"] == "told so"


def test_json_on_stdout_is_what_the_file_holds(tmp_path, answer, capsys):
    answer("accepted")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--json") == 0

    record = json.loads(capsys.readouterr().out)
    assert record == json.loads((tmp_path / "out" / "alignment.json").read_text())
    assert record["verdict"] == "accepted"
    assert set(record["quality"]) == {"a", "b"}
    assert record["candidates"][0]["evidence"] == {"ratio": None}  # what is not finite is null in JSON
    placed = map_frame_to_pixels(
        Similarity(record["b_to_a"]["scale"], record["b_to_a"]["angle_rad"], *record["b_to_a"]["translation"]),
        read_map(A),
        read_map(B),
    )
    np.testing.assert_allclose(placed.matrix, record["pixels"], atol=1e-6)


def test_the_levels_guessed_for_a_plain_image_are_named_on_stderr(tmp_path, answer, capsys):
    answer("rejected")
    image = tmp_path / "plain.png"
    write_plain(image)
    shutil.copy(A, tmp_path / "plain.yaml")

    rectmerge("merge", image, B, "-o", tmp_path / "out")
    guessed = capsys.readouterr().err
    rectmerge("merge", image, B, "-o", tmp_path / "quiet", "--quiet")

    assert "free 254, occupied 0, unknown 205" in guessed
    assert "plain.yaml beside it is not read" in guessed
    assert capsys.readouterr().err == ""


def test_named_levels_are_used(tmp_path, answer, capsys):
    answer("rejected")
    image = A.with_suffix(".pgm")

    rectmerge("merge", image, B, "-o", tmp_path / "out", "--free", 205, "--unknown", 254)

    assert "free 205, occupied 0, unknown 254" in capsys.readouterr().err


def test_set_reaches_the_method(tmp_path, monkeypatch):
    asked = {}
    monkeypatch.setattr(methods, "make_method", lambda name, **fields: asked.update(fields) or FixedAnswers("rejected"))

    rectmerge(
        "merge",
        A,
        B,
        "-o",
        tmp_path,
        "--set",
        f"{methods.DEFAULT_METHOD}.a=1",
        "--set",
        f"{methods.DEFAULT_METHOD}.b=x=y",
    )

    assert asked == {"a": "1", "b": "x=y"}


def test_the_papers_method_merges_two_drawn_maps_from_files(tmp_path, capsys):
    for name, degrees in (("a", 38), ("b", 200)):
        write_map(drawing.tilted(degrees)[0], tmp_path / f"{name}.yaml")

    assert (
        rectmerge("merge", tmp_path / "a.yaml", tmp_path / "b.yaml", "-o", tmp_path / "out", "--method", "paper") == 0
    )

    assert names(tmp_path / "out") == YES_FILES
    assert "-162.0" in capsys.readouterr().out  # 200 - 38, the other way in the map frame


def test_a_yes_of_any_method_is_certified_when_asked_and_the_verdict_stays(tmp_path, monkeypatch, capsys):
    default = methods.make_method(methods.DEFAULT_METHOD)  # certifies for a method that cannot
    monkeypatch.setattr(methods, "make_method", lambda name: FixedAnswers("accepted") if name == "answers" else default)
    words = ("--method", "answers", "--certify", "--certify-seconds", 0.1)

    assert rectmerge("merge", A, B, "-o", tmp_path / "out", *words) == 0

    assert "  certified   " in capsys.readouterr().out
    record = json.loads((tmp_path / "out" / "alignment.json").read_text())
    assert record["verdict"] == "accepted"
    assert {"certified", "margin", "score", "best_elsewhere", "seconds", "boxes"} <= set(record["certificate"])


def test_another_answer_has_nothing_to_certify(tmp_path, answer, capsys):
    answer("rejected")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--certify") == 1

    assert "certif" not in capsys.readouterr().out
    assert "certificate" not in json.loads((tmp_path / "out" / "alignment.json").read_text())
