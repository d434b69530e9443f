import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from rectmerge import methods
from rectmerge.alignment import Alignment, Candidate
from rectmerge.cli import console
from rectmerge.cli import main as cli
from rectmerge.composing.compose import compose
from rectmerge.drawing import maps as picture
from rectmerge.drawing import overlay
from rectmerge.grid import OccupancyGrid, map_frame_to_pixels, pixels_to_map_frame
from rectmerge.io.dialects import Legend
from rectmerge.io.map_file import read_map, write_map
from rectmerge.io.map_yaml import read_header
from rectmerge.results.summary import describe
from rectmerge.similarity import Similarity
from tests import drawing

YES_FILES = {"alignment.json", "overlay.png", "conflict.png", "merged.yaml", "merged.pgm"}
A, B = drawing.DATA / "building_a.yaml", drawing.DATA / "building_b.yaml"


class FixedAnswers:
    """A method that judges itself, and places B where it was drawn, with the verdict it is told."""

    name = "answers"

    def __init__(self, verdict: str, candidates: int = 1) -> None:
        self.verdict, self.candidates = verdict, candidates

    def align_by(self, hint, a: OccupancyGrid, b: OccupancyGrid, **asked) -> Alignment:
        return self.align(a, b, **asked)

    def align(
        self, a: OccupancyGrid, b: OccupancyGrid, *, scale: tuple[float, float], rng: np.random.Generator
    ) -> Alignment:
        found = tuple(
            Candidate.from_pixels(drawing.B_IN_A, a, b, confidence=0.97, evidence={"ratio": float("inf")})
            for _ in range(self.candidates)
        )
        return Alignment(verdict=self.verdict, reason="told so", method=self.name, candidates=found, confidence=0.97)


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch):
    """Draw small: what is written where does not depend on it, and it is faster."""
    monkeypatch.setattr(picture, "SIDE_PX", 300)


@pytest.fixture
def answer(monkeypatch):
    """Make every method give the same answer."""

    def give(verdict: str, candidates: int = 1) -> None:
        monkeypatch.setattr(methods, "make_method", lambda name, **fields: FixedAnswers(verdict, candidates))

    return give


def rectmerge(*words: object) -> int:
    return console.run(cli.app, "rectmerge", [str(word) for word in words])


def write_plain(path: Path) -> None:
    with Image.open(A.with_suffix(".pgm")) as image:
        image.save(path)


def names(folder: Path) -> set[str]:
    return {p.name for p in folder.iterdir()} if folder.exists() else set()


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


@pytest.mark.parametrize(("cells", "size"), [("a", 0.05), ("b", 0.06), ("finer", 0.05), ("0.1", 0.1)])
def test_the_merged_map_has_the_cells_that_were_asked_for(tmp_path, answer, cells, size):
    answer("accepted")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--output-resolution", cells, "--rule", "newest") == 0

    assert read_map(tmp_path / "out" / "merged.yaml").resolution == pytest.approx(size)


@pytest.mark.parametrize(("rule", "shade"), [("log-odds", 82), ("evidence", 50)])
def test_the_shades_of_a_rule_are_read_back_as_they_were_made(tmp_path, answer, capsys, rule, shade):
    answer("accepted")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--rule", rule) == 0

    a, b = read_map(A), read_map(B)
    made = compose([a, b], [None, pixels_to_map_frame(drawing.B_IN_A, a, b)], rule=rule).grid.occupancy
    for dialect in ("nav2", "nav2-2024", "ros1"):
        assert np.array_equal(read_map(tmp_path / "out" / "merged.yaml", dialect=dialect).occupancy, made)
    assert (made == shade).any()
    assert names(tmp_path / "out") == YES_FILES
    assert "mode raw" in capsys.readouterr().out


def test_a_map_without_shades_is_written_as_map_saver_does(tmp_path, answer, capsys):
    answer("accepted")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out") == 0

    assert read_header(tmp_path / "out" / "merged.yaml").legend == Legend()
    with Image.open(tmp_path / "out" / "merged.pgm") as image:
        assert {grey for _, grey in image.getcolors()} == {0, 205, 254}
    assert "mode raw" not in capsys.readouterr().out


def test_by_other_rules_shades_of_the_maps_end_as_walls_or_unknown_which_costmaps_take_right(tmp_path, answer):
    answer("accepted")
    shaded = read_map(A)
    cells = np.where(shaded.occupied, 90, shaded.occupancy).astype(np.int8)
    write_map(OccupancyGrid(cells, shaded.resolution, shaded.origin), tmp_path / "a.yaml", legend=Legend(mode="raw"))

    assert rectmerge("merge", tmp_path / "a.yaml", B, "-o", tmp_path / "out") == 0

    assert read_header(tmp_path / "out" / "merged.yaml").legend == Legend()
    assert read_map(tmp_path / "out" / "merged.yaml").occupied.sum() >= shaded.occupied.sum()


@pytest.mark.parametrize("cells", ["c", "0", "-1", "nan"])
def test_cells_that_cannot_be_are_refused(tmp_path, capsys, cells):
    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--output-resolution", cells) == 2
    assert "a, b, finer or a positive number" in capsys.readouterr().err


def test_a_false_resolution_is_not_written(tmp_path, answer, capsys):
    answer("accepted")
    write_plain(tmp_path / "a.png")

    assert rectmerge("merge", tmp_path / "a.png", B, "-o", tmp_path / "out", "--output-resolution", "finer") == 2

    assert "its resolution is not known" in capsys.readouterr().err
    assert names(tmp_path / "out") == set()


def test_a_no_without_candidates_still_leaves_its_reason(tmp_path, answer):
    answer("rejected", candidates=0)

    assert rectmerge("merge", A, B, "-o", tmp_path / "out") == 1

    assert json.loads((tmp_path / "out" / "alignment.json").read_text())["reason"] == "told so"


def test_json_on_stdout_is_what_the_file_holds(tmp_path, answer, capsys):
    answer("accepted")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--json") == 0

    told = json.loads(capsys.readouterr().out)
    assert told == json.loads((tmp_path / "out" / "alignment.json").read_text())
    assert told["verdict"] == "accepted"
    assert set(told["quality"]) == {"a", "b"}
    assert told["candidates"][0]["evidence"] == {"ratio": None}  # what is not finite is null in JSON
    placed = map_frame_to_pixels(
        Similarity(told["b_to_a"]["scale"], told["b_to_a"]["angle_rad"], *told["b_to_a"]["translation"]),
        read_map(A),
        read_map(B),
    )
    np.testing.assert_allclose(placed.matrix, told["pixels"], atol=1e-6)


def test_results_are_not_replaced_without_force(tmp_path, answer, capsys):
    answer("accepted")
    rectmerge("merge", A, B, "-o", tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    assert rectmerge("merge", A, B, "-o", tmp_path) == 2

    assert "--force" in capsys.readouterr().err
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_force_leaves_no_stale_map_beside_a_new_no_and_nothing_else_is_touched(tmp_path, answer):
    answer("accepted")
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "overlay_old.png").write_text("mine too")
    rectmerge("merge", A, B, "-o", tmp_path)
    answer("rejected")

    assert rectmerge("merge", A, B, "-o", tmp_path, "--force") == 1

    assert names(tmp_path) == {"alignment.json", "overlay_1.png", "notes.txt", "overlay_old.png"}


def test_inputs_in_the_folder_of_the_results_stay_as_they_are(tmp_path, answer):
    answer("accepted")
    for file in (A, A.with_suffix(".pgm"), B, B.with_suffix(".pgm")):
        shutil.copy(file, tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}

    assert rectmerge("merge", tmp_path / A.name, tmp_path / B.name, "-o", tmp_path) == 0

    assert names(tmp_path) == YES_FILES | set(before)
    assert all((tmp_path / name).read_bytes() == data for name, data in before.items())


@pytest.mark.parametrize("as_b", [False, True])
def test_an_input_that_a_result_would_replace_is_refused_even_with_force(tmp_path, answer, capsys, as_b):
    answer("accepted")
    rectmerge("merge", A, B, "-o", tmp_path)
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    merged = tmp_path / "merged.yaml"

    assert rectmerge("merge", *((A, merged) if as_b else (merged, B)), "-o", tmp_path, "--force") == 2

    assert "is an input" in capsys.readouterr().err
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before


def test_bad_input_is_one_line_on_stderr_and_nothing_is_written(tmp_path, capsys):
    (tmp_path / "bad.png").write_bytes(b"not a picture")

    bad, plain = tmp_path / "bad.png", A.with_suffix(".pgm")
    for a, b in ((bad, B), (A, bad), (plain, bad), (A, tmp_path), (tmp_path / "no.yaml", B)):
        assert rectmerge("merge", a, b, "-o", tmp_path / "out") == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.count("\n") == 1
        assert str(tmp_path) in err

    assert names(tmp_path) == {"bad.png"}


@pytest.mark.parametrize(
    "words",
    [
        ("--scale", "wide"),
        ("--scale", "2:1"),
        ("--scale", "0"),
        ("--scale", "nan"),
        ("--scale", "1:2:3"),
        ("--rule", "max"),
        ("--dialect", "ros"),
        ("--resolution-a", "-3"),
        ("--set", "paper.delta_cells"),
        ("--set", "delta_cells=2"),
        ("--set", "other.delta_cells=2"),
        ("--free", "254"),  # both maps are YAML
    ],
)
def test_a_value_that_cannot_be_is_one_line_that_names_the_option(tmp_path, capsys, words):
    assert rectmerge("merge", A, B, "-o", tmp_path / "out", *words) == 2

    (line,) = capsys.readouterr().err.splitlines()
    assert words[0] in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "words",
    [
        ("--method", "paper", "--set", "paper.no_such=2"),
        ("--method", "paper", "--set", "paper.delta_cells=wide"),
        ("--set", "robust.prepare.margin_cells=100000"),
        ("--method", "no-such-method"),
        ("--free", "300"),
        ("--seed", "-1"),
        ("--no-such-option",),
    ],
)
def test_bad_use_exits_2_and_writes_nothing(tmp_path, capsys, words):
    assert rectmerge("merge", A, B, "-o", tmp_path / "out", *words) == 2

    assert capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "out").write_text("mine")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out") == 2
    assert rectmerge("merge", A, B, "-o", tmp_path / "out" / "deeper") == 2
    assert (tmp_path / "out").read_text() == "mine"


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


def test_a_bug_exits_70_with_a_line_and_a_log_and_debug_shows_the_traceback(tmp_path, monkeypatch, capsys):
    def broken(name: str, **fields: object) -> None:
        raise ZeroDivisionError("oh")

    monkeypatch.setattr(methods, "make_method", broken)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)

    assert rectmerge("merge", A, B, "-o", tmp_path / "out") == 70
    (line,) = capsys.readouterr().err.splitlines()
    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--debug") == 70

    assert "ZeroDivisionError: oh" in line
    assert "Traceback" in Path(line.split("log: ")[1].rstrip(")")).read_text()
    assert "Traceback" in capsys.readouterr().err


def test_an_interrupt_exits_130(tmp_path, monkeypatch):
    def interrupted(name: str, **fields: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(methods, "make_method", interrupted)

    assert rectmerge("merge", A, B, "-o", tmp_path) == 130


def test_the_papers_method_merges_two_drawn_maps_from_files(tmp_path, capsys):
    for name, degrees in (("a", 38), ("b", 200)):
        write_map(drawing.tilted(degrees)[0], tmp_path / f"{name}.yaml")

    assert (
        rectmerge("merge", tmp_path / "a.yaml", tmp_path / "b.yaml", "-o", tmp_path / "out", "--method", "paper") == 0
    )

    assert names(tmp_path / "out") == YES_FILES
    assert "-162.0" in capsys.readouterr().out  # 200 - 38, the other way in the map frame


def test_inspect_tells_and_draws(tmp_path, capsys):
    assert rectmerge("inspect", A, "-o", tmp_path / "a.png", "--json") == 0

    told = json.loads(capsys.readouterr().out)
    assert (told["width"], told["height"], told["resolution"]) == (163, 113, 0.05)
    assert told["rectangles"]["count"] == len(drawing.ROOMS) + len(drawing.MORE_ROOMS) + 11  # and the doors
    assert told["rectangles"]["largest"][0] == [12, 12, 60, 38]
    with Image.open(tmp_path / "a.png") as drawn:
        assert drawn.size[0] > 2 * 163


def test_inspect_refuses_to_draw_over_the_map(tmp_path, capsys):
    image = tmp_path / "map.png"
    write_plain(image)
    before = image.read_bytes()

    assert rectmerge("inspect", image, "-o", image) == 2
    assert rectmerge("inspect", A, "-o", tmp_path / "picture.jpg") == 2
    assert image.read_bytes() == before


def test_methods_lists_what_can_be_named_and_set(capsys):
    assert rectmerge("methods") == 0
    text = capsys.readouterr().out
    assert rectmerge("methods", "--json") == 0

    assert f"{methods.DEFAULT_METHOD} (default)" in text
    assert "--set paper.delta_cells=" in text
    assert "--set robust.rank.spreads_cells=1.0,2.0,4.0" in text
    assert set(json.loads(capsys.readouterr().out)["methods"]) == set(methods.available())


@pytest.mark.parametrize("words", [[], ["merge"], ["inspect"]])
def test_h_is_help(capsys, words):
    assert rectmerge(*words, "-h") == 0
    short = capsys.readouterr().out
    assert rectmerge(*words, "--help") == 0

    assert capsys.readouterr().out == short
    assert "Usage: rectmerge" in short


def test_help_and_version_need_no_heavy_package():
    code = (
        "import sys; from rectmerge.cli import console, main\n"
        "assert console.run(main.app, 'rectmerge', ['merge', '--help']) == 0\n"
        "assert console.run(main.app, 'rectmerge', ['--version']) == 0\n"
        "assert not {'numpy', 'cv2', 'numba', 'cattrs', 'yaml', 'PIL'} & set(sys.modules)"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stderr
    assert "--scale" in done.stdout


def test_a_yes_of_any_method_is_certified_when_asked_and_the_verdict_stays(tmp_path, monkeypatch, capsys):
    default = methods.make_method(methods.DEFAULT_METHOD)  # certifies for a method that cannot
    monkeypatch.setattr(methods, "make_method", lambda name: FixedAnswers("accepted") if name == "answers" else default)
    words = ("--method", "answers", "--certify", "--certify-seconds", 0.1)

    assert rectmerge("merge", A, B, "-o", tmp_path / "out", *words) == 0

    assert "  certified   " in capsys.readouterr().out
    told = json.loads((tmp_path / "out" / "alignment.json").read_text())
    assert told["verdict"] == "accepted"
    assert {"certified", "margin", "score", "best_elsewhere", "seconds", "boxes"} <= set(told["certificate"])


def test_another_answer_has_nothing_to_certify(tmp_path, answer, capsys):
    answer("rejected")

    assert rectmerge("merge", A, B, "-o", tmp_path / "out", "--certify") == 1

    assert "certif" not in capsys.readouterr().out
    assert "certificate" not in json.loads((tmp_path / "out" / "alignment.json").read_text())
