import json

import numpy as np
import pytest
from PIL import Image

from rectmerge.errors import InputError
from scenarios.execution.files import clear_folder
from scenarios.gallery.demo import OWN_FILES, TILE, combine, run_demo, verdict_in_words


def test_a_combined_picture_keeps_every_picture_in_a_tile_of_one_size():
    wide, tall = np.full((10, 100, 3), (255, 0, 0), np.uint8), np.full((3000, 30, 3), (0, 0, 255), np.uint8)

    picture = combine([(wide, "wide"), (tall, "tall"), (wide, "wide")], columns=2)

    assert picture.shape[1] >= 2 * TILE[0]
    assert picture.shape[0] >= 2 * TILE[1]
    reds, blues = (np.all(picture == color, axis=2).sum() for color in ((255, 0, 0), (0, 0, 255)))
    assert reds == pytest.approx(2 * TILE[0] * TILE[0] / 10, rel=0.05)
    assert blues == pytest.approx(TILE[1] * TILE[1] / 100, rel=0.2)


@pytest.mark.parametrize(
    ("outcome", "words"),
    [("right-accepted", "right"), ("wrong-accepted", "wrong"), ("rejected", "no answer"), ("timeout", "timeout")],
)
def test_an_outcome_is_told_in_words(outcome, words):
    assert verdict_in_words({"outcome": outcome}) == words


def test_clearing_an_earlier_demo_spares_other_pictures(tmp_path):
    for name in ("demo.png", "overlay_paper.png", "score.json", "holiday.png"):
        (tmp_path / name).write_bytes(b"x")

    (tmp_path / "mission").mkdir()
    for name in ("robot_a.slam.tum", "mission.npz", "mine.npz"):
        (tmp_path / "mission" / name).write_bytes(b"x")

    with pytest.raises(InputError, match="--force"):
        clear_folder(tmp_path, OWN_FILES, force=False)
    clear_folder(tmp_path, OWN_FILES, force=True)

    assert [path.name for path in tmp_path.iterdir() if path.is_file()] == ["holiday.png"]
    assert [path.name for path in (tmp_path / "mission").iterdir()] == ["mine.npz"]


@pytest.mark.sim
@pytest.mark.slow
def test_the_demo_runs_the_whole_chain_and_tells_what_it_wrote(tmp_path):
    said = []

    shown = run_demo(tmp_path / "demo", say=said.append)

    heads, cells = shown.table()
    score = json.loads((tmp_path / "demo/score.json").read_text())
    methods = {"paper", "paper-repaired", "robust"}
    assert {row["method"] for row in score["rows"]} == {line[0] for line in cells} == methods
    assert all(len(line) == len(heads) for line in cells)
    assert {path.name for path in (tmp_path / "demo").iterdir()} == {
        *(path.name for path in shown.pictures),
        "score.json",
        "mission",
    }
    assert len(list((tmp_path / "demo/mission").iterdir())) == 10
    needed = {"demo.png", "world.png", "map_a.png", "map_b.png", "rectangles_a.png", "rectangles_b.png"}
    assert needed | {"overlay_truth.png"} <= {path.name for path in shown.pictures}
    for path in shown.pictures:
        with Image.open(path) as picture:
            assert np.asarray(picture).std() > 5  # something is drawn
    assert any("rooms" in line for line in said)
