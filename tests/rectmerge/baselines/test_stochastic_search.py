import numpy as np
import pytest

from rectmerge._kernels.random_walk import dissimilarity
from rectmerge.aligning import align
from rectmerge.baselines.stochastic_search import StochasticSearch
from rectmerge.errors import InputError
from rectmerge.grid import OccupancyGrid
from tests import drawing
from tests.rectmerge.baselines import naive
from tests.rectmerge.baselines.scenes import TRUTH, corners_apart, long_halls, view


@pytest.mark.parametrize("scale", ["free", TRUTH.scale])
def test_a_rescaled_view_is_placed_within_a_cell(scale):
    alignment = align(drawing.building(), view(), method="stochastic-search", scale=scale)

    assert alignment, alignment.reason
    assert corners_apart(alignment.candidates[0].pixels, TRUTH) < 1


def test_a_scale_that_is_known_is_kept():
    alignment = align(drawing.building(), view(), method=StochasticSearch(walks=1), scale=0.8)

    assert alignment.candidates[0].pixels.scale == pytest.approx(0.8)


@pytest.mark.slow
def test_another_building_agrees_less_than_the_same():
    other, same = (
        align(drawing.building(), b, method="stochastic-search").candidates[0].evidence["score"]
        for b in (long_halls(), view())
    )

    assert other < 0.95 < same


def test_a_placement_with_too_little_in_common_does_not_count():
    alignment = align(drawing.building(), long_halls(), method=StochasticSearch(walks=1, steps=1, least_overlap=1.0))

    assert not alignment.candidates
    assert "100 % of the smaller map" in alignment.reason


def test_a_map_without_walls_is_named():
    alignment = align(drawing.building(), OccupancyGrid(np.zeros((30, 30), np.int8)), method="stochastic-search")

    assert alignment.verdict == "rejected"
    assert "map B" in alignment.reason


def test_dissimilarity_agrees_with_the_slow_way():
    rng = np.random.default_rng(4)
    for _ in range(20):
        cells = [tuple(rng.integers(0, 9, (3, 2)).astype(float) for _ in range(2)) for _ in range(2)]
        maps = [tuple(rng.integers(0, 4, shape).astype(np.float32) for _ in range(2)) for shape in ((8, 10), (9, 9))]
        at = rng.uniform((-3, -0.5, 0, 0), (3, 0.5, 9, 7))

        value = dissimilarity(at, *cells, *maps, (4.0, 3.5), 2.0)

        assert value == pytest.approx(naive.dissimilarity(at, cells, maps, (4.0, 3.5), 2.0))


@pytest.mark.parametrize(
    ("field", "value"), [("walks", 0), ("history", 1), ("worse_share", 1.5), ("lock_cells", -1.0), ("accept_at", 0.0)]
)
def test_a_parameter_that_cannot_be_is_refused(field, value):
    with pytest.raises(InputError, match=field):
        StochasticSearch(**{field: value})
