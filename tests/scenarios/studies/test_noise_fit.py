import numpy as np
import pytest

from rectmerge.grid import OccupancyGrid
from scenarios.corruption.map_noise import MapNoise
from scenarios.corruption.noise_levels import GOOD, POOR
from scenarios.studies.map_population import DescribedMap
from scenarios.studies.noise_fit import WORSE, aim_of, fit_levels, level_loss, rank_among, tail_loss
from tests.scenarios.corruption.small_map import small_map

NONE = MapNoise(**dict.fromkeys(MapNoise.__slots__, 0.0))


class DrawnMission:
    """Stands for a mission whose map is a room, drawn on by a noise."""

    def __init__(self, seed: int) -> None:
        self.seed = seed

    def described(self, noise: MapNoise) -> DescribedMap:
        of_map, of_cells = np.random.default_rng(self.seed).spawn(2)
        return DescribedMap.from_grid(noise.of_one_map(of_map).add(small_map(), of_cells), f"room {self.seed}")


MISSIONS = [DrawnMission(seed) for seed in range(6)]


def strengths(**given: float) -> MapNoise:
    return MapNoise(**{**{name: getattr(NONE, name) for name in MapNoise.__slots__}, **given})


def maps_of(noise: MapNoise, seeds=range(100, 120)) -> list[DescribedMap]:
    return [DrawnMission(seed).described(noise) for seed in seeds]


def test_ranks_count_ties_half():
    assert [rank_among(np.array([1.0, 2.0, 2.0, 3.0]), value) for value in (0.0, 2.0, 9.0)] == [0.0, 0.5, 1.0]


def test_every_descriptor_has_a_direction_and_every_level_its_band():
    described = DescribedMap.from_grid(small_map(), "room").descriptors
    assert set(described) <= set(WORSE)
    for name in WORSE:
        for level in (1, 2):
            least, aim, most = aim_of(name, level)
            assert 0.25 <= least < aim < most <= 0.75
    assert aim_of("specks", 1)[2] == aim_of("specks", 2)[0] == 0.5


def test_the_loss_is_least_where_the_real_maps_come_from():
    real = maps_of(strengths(specks=0.3, thick_walls=0.2, spread=0.5))
    losses = {
        specks: level_loss(real, [m.described(strengths(specks=specks, thick_walls=0.2)) for m in MISSIONS], 2)
        for specks in (0.02, 0.35, 4.0)
    }

    assert min(losses, key=losses.__getitem__) == 0.35


def test_the_tails_are_alike_where_the_spread_is():
    real = maps_of(strengths(specks=0.3, thick_walls=0.2, spread=1.0))
    losses = [tail_loss(real, maps_of(strengths(specks=0.3, thick_walls=0.2, spread=s), range(20))) for s in (0.0, 1.0)]

    assert losses[1] < losses[0]


def test_a_fit_finds_more_specks_where_the_real_maps_have_more(monkeypatch):
    monkeypatch.setattr("scenarios.studies.noise_fit.STEPS", (2.0,))
    monkeypatch.setattr("scenarios.studies.noise_fit.SPREADS", (0.0, 0.5))
    real = maps_of(strengths(specks=0.8, spread=0.3), range(100, 108))
    start = strengths(specks=0.1)
    steps: list[str] = []
    fitted = fit_levels(real, MISSIONS[:3], {1: start, 2: start}, on_step=steps.append)

    assert fitted[1].specks > 0.1
    assert any("specks" in step for step in steps)


def test_the_levels_grow_in_every_strength():
    grows = [getattr(POOR, name) >= getattr(GOOD, name) for name in MapNoise.__slots__]

    assert sum(grows) >= 8  # a fit may find less of one where another brings it about


def test_a_grid_is_described_with_its_group_and_area():
    described = DescribedMap.from_grid(OccupancyGrid(np.zeros((10, 20), np.int8)), "hall")

    assert (described.group, described.free_cells) == ("hall", 200)


def test_negative_strengths_are_refused():
    with pytest.raises(ValueError, match="specks must be >= 0, got -1"):
        strengths(specks=-1.0)
