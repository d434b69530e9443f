"""Robots that explore one office, whose maps are put to the merger as they grow."""

import pytest

from rectmerge.live.merger import LiveMerger
from rectmerge.live.params import LiveParams
from tests.ros.fleet import VERSIONS, explore, misplaced_cells


@pytest.mark.slow  # five robots drive, and their maps are merged six times
@pytest.mark.sim
def test_five_robots_become_one_map_and_none_is_ever_misplaced():
    fleet, placed = explore(5), []
    merger = LiveMerger(reference="robot1", params=LiveParams(accepts=1))
    for version in range(VERSIONS):
        for explorer in fleet:
            merger.update(explorer.name, explorer.maps[version])
        placements = merger.step().placements
        for explorer in fleet[1:]:
            if explorer.name in placements:
                placement, grid = placements[explorer.name], explorer.maps[version]
                assert misplaced_cells(placement, fleet[0], explorer, grid) < 2.0
        placed.append(len(placements))

    assert placed[0] == 0  # nothing is sure yet
    assert placed[-1] == 4
