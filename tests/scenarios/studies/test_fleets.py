import json

import pytest

from rectmerge.errors import InputError
from rectmerge.fleet.map_sample import digest
from scenarios.dataset.fleets import read_fleets
from scenarios.dataset.generate import generate
from scenarios.studies import fleet_entrants as entrants
from scenarios.studies import fleets
from scenarios.studies.fleet_entrants import Remembered
from scenarios.studies.fleets import fleets_of, study_fleets
from tests.rectmerge.fleet.fleets import Oracle
from tests.scenarios.dataset.drawn_fleet import DrawnFleet, DrawnFleets


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "drawn"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("scenarios.dataset.writer.picture", lambda folder: b"a picture")
        generate(DrawnFleets(), folder)
    return folder


def oracle_of(name, maps):
    """Return a method that knows the truth of the maps, under any name."""
    drawn = (DrawnFleet(seed=seed).made() for seed in range(2))
    made = next(fleet for fleet in drawn if digest(fleet.maps["home0"]) == digest(maps["home0"]))
    return Remembered(Oracle(made, noise=0.0), maps)


def test_a_study_puts_every_entrant_to_every_fleet_and_goes_on_where_it_ended(dataset, tmp_path, monkeypatch):
    monkeypatch.setattr(entrants, "method_of", oracle_of)
    found, done = read_fleets(dataset), []
    study_fleets(found[:1], tmp_path / "out", on_done=done.append)
    asked = []
    measure = fleets.measure_fleet
    monkeypatch.setattr(fleets, "measure_fleet", lambda fleet: asked.append(fleet.fleet_id) or measure(fleet))

    study_fleets(found, tmp_path / "out", command="rectbench fleets x", on_done=done.append)

    assert asked == ["drawn-0001"]
    assert done == [0, 1, 1, 1]
    lines = [json.loads(line) for line in (tmp_path / "out" / "results.jsonl").read_text().splitlines()]
    assert [line["fleet_id"] for line in lines] == ["drawn-0000", "drawn-0001"]
    scores = lines[0]["entrants"]
    assert list(scores) == [
        "joint", "tree of robust", "tree of keypoints", "joint, lied to", "tree of robust, lied to"
    ]  # fmt: skip
    assert scores["joint"]["wrong_maps"] == 0
    assert [pair["outcome"] for pair in scores["joint"]["pairs"]].count("right") >= 3
    assert "joint, one by one" in lines[1]["entrants"]
    page = (tmp_path / "out" / "README.md").read_text()
    assert "rectbench fleets x" in page
    assert "## drawn, drawn: 2 fleets of 5 maps" in page
    assert "| joint | " in page


def test_data_sets_of_one_name_are_refused(dataset):
    with pytest.raises(InputError, match="different names, got drawn, drawn"):
        fleets_of([dataset, dataset])
