import hashlib

import numpy as np
import pytest

from rectmerge.errors import SimulationError
from scenarios.dataset.contact_sheet import contact_sheet, paletted_png
from scenarios.execution.executors import completed, local_workers
from scenarios.suites.mission_source import MissionSource
from scenarios.suites.random_missions import random_sources
from sim.floorplans import FAMILIES
from tests.scenarios.known_answers import Source, pair


def test_the_same_seed_draws_the_same_missions_and_fewer_are_the_first_of_them():
    assert random_sources(4, seed=3) == random_sources(9, seed=3)[:4]
    assert random_sources(4, seed=3) != random_sources(4, seed=4)


def test_families_and_pose_sources_come_in_turn_and_the_rest_varies():
    sources = random_sources(40, poses=("truth", "slam"))

    assert [source.scenario.world.family for source in sources[:10]] == list(FAMILIES)
    assert [source.scenario.a.poses for source in sources[:3]] == ["truth", "slam", "truth"]
    assert len({source.source_id for source in sources}) == 40
    for read in (
        lambda scenario: scenario.mission.a.lidar,
        lambda scenario: scenario.mission.b.path,
        lambda scenario: scenario.noise,
        lambda scenario: bool(scenario.a.corruption),
    ):
        assert len({read(source.scenario) for source in sources}) > 1


class Shown(Source):
    """A mission whose pairs have what a caption tells."""

    def pairs(self):
        yield pair(info={"bent": False, "family": "office", "pose_source": "truth"})


class OutOfReach(Source):
    """A mission whose robots never share so much as is wanted."""

    def pairs(self):
        raise SimulationError("the finished maps share too little")
        yield


def test_a_contact_sheet_shows_its_pairs_in_rows_and_passes_over_missions_that_come_to_nothing(monkeypatch):
    sources = [OutOfReach(), *(Shown(source_id=f"m{number}") for number in range(3))]  # the first and third by turns
    monkeypatch.setattr("scenarios.dataset.contact_sheet.random_sources", lambda count, **asked: sources)
    monkeypatch.setattr("scenarios.dataset.contact_sheet.PERIOD", 2)

    sheet = contact_sheet(5)

    height, width, _ = sheet.shape
    assert 4 * 3 * 140 < width < 5 * 3 * 140
    assert 2 * 140 < height < 3 * 140
    assert (sheet.std(axis=2) > 20).any()  # overlays have colours
    assert paletted_png(np.zeros((8, 8, 3), np.uint8)).startswith(b"\x89PNG")


def digests(source: MissionSource) -> list[str]:
    """Checksums of the maps of a mission's pairs."""
    return [
        hashlib.sha256(grid.occupancy.tobytes()).hexdigest() for pair in source.pairs() for grid in (pair.a, pair.b)
    ]


@pytest.mark.sim
@pytest.mark.slow
def test_the_same_seed_gives_the_same_map_bytes_in_any_number_of_processes():
    sources = [source for k, source in enumerate(random_sources(8)) if k in (0, 5, 7)]
    with local_workers(2) as executor:
        apart = {source.source_id: future.result() for source, future in completed(executor, digests, sources)}

    assert apart == {source.source_id: digests(source) for source in sources}
