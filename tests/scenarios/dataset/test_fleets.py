import json

import numpy as np
import pytest

from rectmerge.errors import DatasetError
from scenarios.dataset.fleets import FLEETS, read_fleets
from scenarios.dataset.generate import generate
from scenarios.dataset.reader import open_dataset
from scenarios.dataset.verify import verify
from tests.scenarios.dataset.drawn_fleet import DrawnFleets
from tests.scenarios.dataset.folders import rows_of

pytestmark = pytest.mark.usefixtures("no_picture")


@pytest.fixture(scope="module")
def made(tmp_path_factory, no_picture):
    folder = tmp_path_factory.mktemp("made") / "drawn"
    generate(DrawnFleets(), folder)
    return folder


def test_a_fleet_on_disk_names_its_maps_and_all_its_pairs(made):
    fleets = read_fleets(made)

    assert [fleet.fleet_id for fleet in fleets] == ["drawn-0000", "drawn-0001"]
    assert [fleet.is_growing for fleet in fleets] == [False, True]
    for fleet, source in zip(fleets, DrawnFleets().sources(), strict=True):
        drawn = source.made()
        assert fleet.places == drawn.place
        assert set(fleet.pairs) == set(source.pair_ids)
        for name, grid in fleet.grids().items():
            assert np.array_equal(grid.occupancy, drawn.maps[name].occupancy)
        rows = fleet.rows()
        assert len(rows) == 10
        assert rows["home0", "home1"].related
        assert not rows["home0", "other1"].related


def test_pair_methods_find_every_pair_in_files_that_the_pairs_share(made):
    assert len(open_dataset(made)) == 20
    assert len(list((made / "test" / "maps").glob("*.png"))) == 10
    assert {row["map_a_file_name"] for row in rows_of(made, "test")} <= {
        f"maps/drawn-000{k}_{i}.png" for k in range(2) for i in range(5)
    }
    assert verify(made).faults == ()


def test_the_checksums_cover_the_fleets(made):
    info = json.loads((made / "dataset_info.json").read_text())

    assert f"test/{FLEETS}" in info["checksums"]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("{", r"fleets.jsonl:1: not a fleet"),
        ('{"fleet_id": "x"}', r"fleets.jsonl:1: not a fleet"),
        ('{"fleet_id": "x", "maps": {"a": "a.png"}, "places": {"a": "p"}, "pairs": []}', "two maps or more"),
        ('{"fleet_id":"x","maps":{"a":"../a.png","b":"b.png"},"places":{"a":"p","b":"p"},"pairs":[]}', "leads out"),
    ],
)  # fmt: skip
def test_a_broken_line_is_named(tmp_path, line, message):
    (tmp_path / "metadata.jsonl").write_text("{}\n")
    (tmp_path / FLEETS).write_text(line + "\n")

    with pytest.raises(DatasetError, match=message):
        read_fleets(tmp_path)


def test_a_data_set_without_fleets_is_refused(tmp_path):
    (tmp_path / "metadata.jsonl").write_text("{}\n")

    with pytest.raises(DatasetError, match="no data set of fleets"):
        read_fleets(tmp_path)


def test_a_pair_without_a_row_is_named(made, tmp_path):
    fleet = read_fleets(made)[0]
    line = {"fleet_id": "x", "maps": fleet.maps, "places": fleet.places, "pairs": ["gone"]}
    folder = tmp_path / "broken"
    folder.mkdir()
    (folder / "metadata.jsonl").write_text((made / "test" / "metadata.jsonl").read_text())
    (folder / FLEETS).write_text(json.dumps(dict(line)) + "\n")

    with pytest.raises(DatasetError, match="some pairs have no row"):
        read_fleets(folder)[0].rows()
