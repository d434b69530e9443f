from dataclasses import replace

import numpy as np
import pytest

from rectmerge.similarity import Similarity
from scenarios.dataset.generate import generate
from scenarios.dataset.reader import open_dataset
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
    page = (tmp_path / "live.md").read_text()
    assert "Pairs of one place: 1 of 1 were merged rightly, 0 of them" in page


def test_a_placement_beside_the_truth_counts_as_wrong(dataset, monkeypatch):
    (source,) = open_dataset(dataset)
    whole = live.play

    def shifted(*args, **words):
        for step in whole(*args, **words):
            moved = {robot: Similarity(tx=3.0) @ place for robot, place in step.published.placements.items()}
            yield replace(step, published=replace(step.published, placements=moved))

    monkeypatch.setattr(live, "play", shifted)
    mission = live.replay_mission(source)

    assert mission.wrong > 0
    assert mission.merged_s is None


def test_overlap_is_that_of_the_maps_at_the_time(dataset):
    (source,) = open_dataset(dataset)
    (pair,) = source.pairs()

    assert live.replay_mission(source).final_overlap == pytest.approx(pair.overlap, abs=0.02)
    assert np.isfinite(pair.overlap)


def test_a_pair_without_a_bag_grows_from_a_place_outwards(tmp_path):
    generate(load_suite("smoke"), tmp_path / "set", pairs=1)
    (source,) = open_dataset(tmp_path / "set")
    mission = live.replay_mission(source)

    assert mission.wrong == 0
    assert mission.duration_s == pytest.approx(live.PERIOD_S * (live.VERSIONS - 1), abs=1)
    assert 0 < mission.merged_s <= mission.duration_s


def test_whatever_is_published_of_two_places_is_wrong(dataset, tmp_path, monkeypatch):
    (source,) = open_dataset(dataset)
    (pair,) = source.pairs()
    unrelated = replace(pair, related=False, pixels=None, control_points=None, residual_px=None, overlap=None)
    monkeypatch.setattr(type(source), "pairs", lambda self: iter([unrelated]))
    live.write_live(dataset, tmp_path / "live.md")

    assert live.replay_mission(source).wrong > 0
    assert "Pairs of two places: 1 of 1 were published." in (tmp_path / "live.md").read_text()
