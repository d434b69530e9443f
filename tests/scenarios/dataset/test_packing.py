from dataclasses import dataclass, replace

import numpy as np
import pytest

from rectmerge.grid import OCCUPIED, UNKNOWN, OccupancyGrid
from scenarios.dataset.packing import make
from scenarios.pairs.map_view import MapSpec
from scenarios.pairs.pair import MissionPairs, make_pair
from tests.scenarios.tiny_suite import Rooms
from tests.sim.small_worlds import office_log


@dataclass(frozen=True)
class Changed:
    """The related pair of a building with something changed."""

    changes: dict

    source_id = "changed"
    pair_ids = ("changed",)

    def pairs(self):
        pair = next(Rooms(seed=1).pairs())
        yield replace(pair, **{"pair_id": "changed", **self.changes})


class Mission:
    """Two pairs of one mission, which took a second try."""

    source_id = "office"
    pair_ids = ("office-0", "office-1")

    def mission_pairs(self):
        log = replace(office_log(), discarded=("they fell",))
        specs = MapSpec(), MapSpec(resolution=0.06, turn_deg=30.0)
        pairs = (make_pair(log, *specs, 1, pair_id=pair_id) for pair_id in self.pair_ids)
        return MissionPairs(log=log, pairs=tuple(pairs), failed={})

    def pairs(self):
        raise AssertionError("the mission would be run twice")


DARK = OccupancyGrid(np.where(np.arange(400).reshape(20, 20) % 7, UNKNOWN, OCCUPIED).astype(np.int8))
UNFIT = {
    "a map without free space": ({"a": DARK}, "cannot be told"),
    "no split": ({"info": {"split": "dev"}}, "split must be one of train, test, got 'dev'"),
    "another id": ({"pair_id": "other"}, "is not in"),
}


@pytest.mark.parametrize(("changes", "reason"), UNFIT.values(), ids=UNFIT)
def test_a_pair_that_would_not_be_read_as_it_is_fails_with_the_reason(changes, reason):
    package = make(Changed(changes), 0).package

    assert (package.rows, package.files) == ([], {})
    assert reason in package.failed["changed"]


def test_a_mission_is_run_once_and_its_building_kept_once():
    package = make(Mission(), 7).package

    assert [row["map_b_file_name"] for row in package.rows] == ["maps/000007_b.png", "maps/000008_b.png"]
    assert len({row["world"] for row in package.rows}) == 1
    assert len(package.files) == 2 * 2 + 2
    assert (package.discarded, package.failed) == (["they fell"], {})


def test_only_the_wanted_pairs_are_made():
    package = make(Rooms(seed=1, fails=True), 0, 1).package

    assert [row["pair_id"] for row in package.rows] == ["rooms-0001-same"]
    assert package.failed == {}
