"""Data sets of simulated pairs, end to end."""

import pytest

from rectmerge.cli import console
from rectmerge.io.map_file import read_map
from scenarios.bench.run import read_rows
from scenarios.cli.main import app
from scenarios.dataset.generate import generate
from scenarios.dataset.verify import verify
from scenarios.suites.suite import load_suite
from tests.scenarios.dataset.folders import rows_of

pytestmark = pytest.mark.usefixtures("no_picture")

OFFICE = """
title = "One office"
description = "Two pairs, B's resolution known."

[[scenarios]]
name = "office"
noise = [0, 1]
world = { size_m = [14.0, 10.0], rooms = 6, oblique = 0.0, furniture = 0.0 }
mission = { rays = "compiled", max_seconds = 40, a = { lidar = { beams = 180 } }, b = { lidar = { beams = 180 } } }
a = { resolution = 0.06, turn_deg = "random" }
b = { resolution = 0.052, turn_deg = 90.0, turn = "image", hide_resolution = false }
"""


@pytest.mark.sim
def test_a_run_of_a_data_set_gives_the_scores_of_a_run_of_its_suite(tmp_path):
    (tmp_path / "office.toml").write_text(OFFICE)
    suite, dataset = str(tmp_path / "office.toml"), str(tmp_path / "set")

    assert console.run(app, "rectbench", ["generate", suite, "-o", dataset, "-q"]) == 0
    assert verify(dataset).faults == ()
    runs = []
    for k, target in enumerate((suite, dataset)):
        words = ["run", target, "-m", "robust", "-m", "paper", "-o", str(tmp_path / f"run{k}"), "-q"]
        assert console.run(app, "rectbench", words) == 0
        runs.append({(row["pair_id"], row["method"]): row for row in read_rows(tmp_path / f"run{k}")})
    direct, opened = runs

    assert len(direct) == 4
    assert direct.keys() == opened.keys()
    for key, row in direct.items():
        same = (
            "related",
            "stratum",
            "bent",
            "outcome",
            "verdict",
            "confidence",
            "candidates",
            "grades",
            "suite",
            "place",
        )
        assert {name: opened[key][name] for name in same} == {name: row[name] for name in same}
        assert opened[key]["errors"] == pytest.approx(row["errors"], abs=1e-3)
        assert opened[key]["overlap"] == pytest.approx(row["overlap"], abs=1e-6)


@pytest.mark.sim
def test_the_building_is_kept_once_per_mission_with_the_truth_of_its_maps(tmp_path):
    (tmp_path / "office.toml").write_text(OFFICE)
    generate(load_suite(tmp_path / "office.toml"), tmp_path / "set")
    first, second = rows_of(tmp_path / "set", "test")
    world = read_map((tmp_path / "set/test" / first["world"]).with_suffix(".yaml"))

    assert first["world"] == second["world"]
    assert len(list((tmp_path / "set/test/worlds").iterdir())) == 2
    assert world.resolution == 0.05
    assert world.free.sum() * 0.05**2 > 50.0  # square metres
