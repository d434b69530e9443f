import dataclasses

import numpy as np
import pytest

from scenarios.corruption.noise_levels import POOR, add_noise
from scenarios.studies.map_population import DescribedMap
from scenarios.studies.map_realism import MapRealism, mixed, page, percentiles_text, sheet
from scenarios.studies.real_or_simulated import halves_auc, matched, tell_apart
from tests.scenarios.corruption.small_map import small_map

pytest.importorskip("sklearn")


def population(level, seeds, sort) -> list[DescribedMap]:
    grids = [add_noise(small_map(), level, np.random.default_rng(seed)) for seed in seeds]
    return [DescribedMap.from_grid(grid, f"{sort} {k % 8}") for k, grid in enumerate(grids)]


@pytest.fixture(scope="module")
def populations():
    return {
        "real": population(2, range(24), "place"),
        "alike": population(2, range(100, 124), "family"),
        "even": population("cells-1", range(100, 124), "family"),
    }


@pytest.fixture(autouse=True)
def few_trees(monkeypatch):
    monkeypatch.setattr("scenarios.studies.real_or_simulated.TREES", 40)


def test_maps_of_one_noise_cannot_be_told_apart_and_those_of_another_can(populations):
    alike, even = (tell_apart(populations["real"], populations[name]) for name in ("alike", "even"))

    assert alike.auc < 0.75
    assert even.auc > 0.95
    assert (even.maps, len(even.simulated), even.realness.shape) == (24, 24, (24,))
    assert sum(even.importances.values()) == pytest.approx(1.0)
    assert halves_auc(populations["real"], splits=2) < 0.8


def test_the_same_seed_tells_alike(populations):
    first, again = (tell_apart(populations["real"], populations["alike"]) for _ in range(2))

    assert first.auc == again.auc
    assert np.array_equal(first.realness, again.realness)


def test_maps_are_matched_by_free_area_or_left_out():
    def areas(*free_cells):
        return [DescribedMap("room", cells, {}, small_map()) for cells in free_cells]

    assert matched(areas(1000, 100, 5000), areas(120, 900, 100_000)) == [(0, 1), (1, 0)]
    assert matched(areas(100), areas(10, 1000)) == []


def test_the_page_says_what_reaches_its_bar(populations):
    simulated = {1: populations["real"], 2: populations["real"], "cells-1": populations["even"]}
    real = populations["real"]
    found = MapRealism(
        real, simulated, tell_apart(real, populations["alike"]), tell_apart(real, populations["even"]), halves=0.5
    )
    text = page(found, {"commit": "abc", "processor": "a processor"})

    table = {line.split("|")[1].strip(): line for line in text.splitlines() if line.startswith("| ")}
    assert "at 50 %" in table["specks"]  # both levels lie where the maps lie that they were made of
    assert "**off**" not in table["specks"]
    assert "| one half of the real places against the other | 0.50 |" in text
    assert "commit abc" in text
    assert sheet(found.mixture).ndim == 3


def test_the_mixture_takes_each_mission_once(populations):
    simulated = {1: populations["alike"][:4], 2: populations["real"][:4], "cells-1": []}

    assert mixed(simulated) == [simulated[1][0], simulated[2][1], simulated[1][2], simulated[2][3]]


def test_percentiles_are_told_to_three_digits():
    assert percentiles_text(np.array([0.12345, 0.12345]), (10, 90)) == "0.123 / 0.123"


def test_strengths_of_a_map_lie_within_two_deviations():
    one = [dataclasses.asdict(POOR.of_one_map(np.random.default_rng(k)))["specks"] for k in range(50)]

    assert POOR.specks * np.exp(-2 * POOR.spread) <= min(one) < POOR.specks < max(one)
    assert max(one) <= POOR.specks * np.exp(2 * POOR.spread) * (1 + 1e-9)
