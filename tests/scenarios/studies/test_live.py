from dataclasses import replace

import numpy as np
import pytest

from rectmerge.errors import InputError
from rectmerge.similarity import Similarity
from scenarios.dataset.generate import generate
from scenarios.studies import live
from scenarios.suites.suite import load_suite

pytestmark = [pytest.mark.sim, pytest.mark.slow]


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    folder = tmp_path_factory.mktemp("live") / "smoke"
    generate(load_suite("smoke"), folder, pairs=1, form="mcap")
    return folder


def test_a_mission_is_merged_rightly_before_it_ends(dataset, tmp_path):
    done = []
    live.write_live(dataset, tmp_path / "live.md", on_done=done.append)
    (mission,) = done

    assert mission.wrong == 0
    assert 0 < mission.merged_s < mission.duration_s
    assert 0 < mission.overlap <= 1
    assert "1 of 1 missions were merged rightly; 0 published" in (tmp_path / "live.md").read_text()


def test_a_placement_beside_the_truth_counts_as_wrong(dataset, monkeypatch):
    (source,) = live.bag_sources(dataset)
    whole = live.replay

    def shifted(*args, **words):
        for step in whole(*args, **words):
            moved = {robot: Similarity(tx=3.0) @ place for robot, place in step.published.placements.items()}
            yield replace(step, published=replace(step.published, placements=moved))

    monkeypatch.setattr(live, "replay", shifted)
    mission = live.replay_mission(source)

    assert mission.wrong > 0
    assert mission.merged_s is None


def test_overlap_is_that_of_the_maps_at_the_time(dataset):
    (source,) = live.bag_sources(dataset)
    (pair,) = source.pairs()

    assert live.replay_mission(source).final_overlap == pytest.approx(pair.overlap, abs=0.02)
    assert np.isfinite(pair.overlap)


def test_a_data_set_without_bags_is_refused_with_the_remedy(tmp_path):
    generate(load_suite("smoke"), tmp_path / "set", pairs=1)

    with pytest.raises(InputError, match="no pair has a bag; make the data set with rectbench generate --format mcap"):
        live.bag_sources(tmp_path / "set")
