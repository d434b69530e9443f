import json

import numpy as np
import pytest
from PIL import Image

from rectmerge.cli import console
from rectmerge.cli import main as cli
from rectmerge.grid import OccupancyGrid
from rectmerge.io.map_file import write_map
from rectmerge.paper.figures import FIGURES
from tests.rectmerge.paper import plans

WRITTEN = sorted([*FIGURES, "table-1.md", "trace.md", "alignment.json"])


def run(*words):
    return console.run(cli.app, "rectmerge", ["trace", *map(str, words)])


@pytest.fixture
def maps(tmp_path):
    for name, degrees in (("a", 27), ("b", 225)):
        write_map(plans.moved(plans.floor_plan(), degrees)[0], tmp_path / f"{name}.yaml")
    return tmp_path / "a.yaml", tmp_path / "b.yaml"


def test_the_figures_and_tables_of_any_two_maps_are_written(maps, tmp_path, capsys):
    assert run(*maps, "-o", tmp_path / "out") == console.YES

    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == WRITTEN
    table = (tmp_path / "out" / "trace.md").read_text()
    assert table in capsys.readouterr().out
    record = json.loads((tmp_path / "out" / "alignment.json").read_text())
    assert record["verdict"] == "accepted"
    assert len(record["trace"]["iterations"]) == len(table.splitlines()) - 2


@pytest.mark.slow
def test_earlier_figures_are_replaced_only_when_asked(maps, tmp_path, capsys):
    words = (*maps, "-o", tmp_path / "out", "--quiet")

    assert run(*words) == console.YES
    assert run(*words) == console.BAD_INPUT
    assert "--force" in capsys.readouterr().err
    assert run(*words, "--force", "--method", "paper-repaired") == console.YES


def test_a_map_that_a_figure_would_replace_and_a_file_in_place_of_the_folder_are_refused(maps, tmp_path, capsys):
    Image.new("L", (40, 30), 254).save(tmp_path / "figure-02.png")
    (tmp_path / "file").touch()

    assert run(tmp_path / "figure-02.png", maps[1], "-o", tmp_path, "--force") == console.BAD_INPUT
    assert "is an input, and would be replaced" in capsys.readouterr().err
    assert run(*maps, "-o", tmp_path / "file") == console.BAD_INPUT
    assert "is not a folder" in capsys.readouterr().err


def test_a_map_that_misses_a_condition_is_refused_by_naming_it(maps, tmp_path, capsys):
    room = OccupancyGrid(np.pad(np.zeros((30, 40), np.int8), 3, constant_values=100))
    write_map(room, tmp_path / "room.yaml")

    assert run(maps[0], tmp_path / "room.yaml", "-o", tmp_path / "out") == console.NO
    assert "map B has fewer than three rectangles" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_loop_that_does_not_end_is_drawn_with_status_1(maps, tmp_path, capsys):
    write_map(plans.moved(plans.floor_plan(), 225, 1 / 1.1429)[0], tmp_path / "c.yaml")
    words = (maps[0], tmp_path / "c.yaml", "-o", tmp_path / "out", "--set", "paper.max_iterations=1")

    assert run(*words) == console.NO
    assert "rejected: the ratio loop does not end" in capsys.readouterr().out
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == WRITTEN


def test_a_method_without_a_trace_is_refused(maps, tmp_path, capsys):
    assert run(*maps, "-o", tmp_path / "out", "--method", "robust") == console.BAD_INPUT
    assert "paper-repaired" in capsys.readouterr().err
