"""Data sets whose pairs come with the bags of their missions."""

import json
import sys
from dataclasses import replace

import pytest

from rectmerge.cli import console
from rectmerge.errors import InputError
from scenarios.cli.main import app
from scenarios.dataset.generate import generate
from scenarios.dataset.packing import make
from scenarios.dataset.verify import verify
from scenarios.pairs.pair import MissionPairs
from scenarios.suites.mission_source import MissionSource
from scenarios.suites.spec import Scenario
from tests.scenarios.dataset.walked_pairs import SPECS, made
from tests.scenarios.tiny_suite import TinySuite


class WalkedPairs:
    """A pair of the walked office, and the same as if no robot had made it."""

    source_id = "walk"
    pair_ids = ("walk-0", "walk-mirrored")

    def mission_pairs(self):
        pair, source = made()
        pairs = tuple(replace(pair, pair_id=pair_id) for pair_id in self.pair_ids)
        return MissionPairs(log=source.log, pairs=pairs, failed={}, inputs={"walk-0": source})

    def pairs(self):
        raise AssertionError("the mission would be run twice")


def test_rows_name_their_bags_and_mirrored_pairs_have_none():
    package = make(WalkedPairs(), 7, bags="mcap").package

    assert [row["bag"] for row in package.rows] == ["bags/000007", ""]
    bags = {path for path in package.files if "/bags/" in path}
    assert bags == {"test/bags/000007/000007.mcap", "test/bags/000007/metadata.yaml"}
    assert "bag" not in make(WalkedPairs(), 7).package.rows[0]


@pytest.mark.parametrize("kind", ["related", "mirrored"])
def test_missions_tell_what_their_pairs_were_made_from(kind):
    scenario = Scenario(name="office", kind=kind, noise=(1,), a=SPECS[0], b=SPECS[1])
    explored = MissionSource("made", scenario, 3).mission_pairs_from(made()[1].log)

    missions = [(inputs.spec_a, inputs.spec_b, len(inputs.log.a.times)) for inputs in explored.inputs.values()]
    assert len(explored.pairs) == 1
    assert missions == ([(*SPECS, len(explored.pairs[0].poses[0]))] if kind == "related" else [])


def test_bags_that_cannot_be_written_are_refused_in_one_line(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="runs no mission, so there is no bag of it to write"):
        generate(TinySuite(), tmp_path / "set", form="mcap")
    with pytest.raises(InputError, match="format must be one of files, mcap, rosbag1, got 'bag'"):
        generate(TinySuite(), tmp_path / "set", form="bag")
    monkeypatch.setitem(sys.modules, "rosbags", None)
    monkeypatch.delitem(sys.modules, "rosbags.rosbag2", raising=False)
    with pytest.raises(InputError, match=r"pip install 'rectmerge\[ros\]'"):
        generate(TinySuite(), tmp_path / "set", form="mcap")
    assert not (tmp_path / "set").exists()


OFFICE = """title = "Office"
[[scenarios]]
name = "office"
seeds = { count = 1 }
noise = [0, 1]
world = { size_m = [14.0, 10.0], rooms = 6, oblique = 0.0 }
b = { resolution = 0.06 }
"""


@pytest.mark.sim
def test_a_data_set_with_bags_is_whole_and_reproducible(tmp_path, capsys):
    (tmp_path / "office.toml").write_text(OFFICE)
    suite, sets = str(tmp_path / "office.toml"), [tmp_path / "first", tmp_path / "second"]
    for folder in sets:
        words = ["generate", suite, "-o", str(folder), "--format", "mcap", "--quiet"]
        assert console.run(app, "rectbench", words) == console.YES
    first, second = (
        {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()} for folder in sets
    )
    info = json.loads((sets[0] / "dataset_info.json").read_text())

    assert first == second
    assert info["format"] == "mcap"
    assert {name for name in info["checksums"] if name.endswith(".mcap")} == {
        "test/bags/000000/000000.mcap",
        "test/bags/000001/000001.mcap",
    }
    assert verify(sets[0]).faults == ()
    assert "--format mcap" in (sets[0] / "README.md").read_text()
    assert console.run(app, "rectbench", ["generate", suite, "-o", str(sets[0]), "--quiet"]) == console.BAD_INPUT
    assert console.run(app, "rectbench", ["generate", suite, "-o", str(sets[0]), "--quiet", "--force"]) == console.YES
    assert not list(sets[0].rglob("*.mcap"))
