import numpy as np
import pytest

from rectmerge.analysis.overlap import measure_agreement
from rectmerge.fleet.complex_similarity import ComplexSimilarity
from rectmerge.fleet.map_sample import MapSample, digest, overlap
from rectmerge.grid import OccupancyGrid
from tests import drawing
from tests.rectmerge.fleet.fleets import fleet


@pytest.mark.parametrize("pair", [("home0", "home1"), ("home1", "home4"), ("home0", "home4")])
def test_the_sampled_overlap_is_the_measured_one(pair):
    made = fleet(1)
    a, b = (made.maps[name] for name in pair)
    truth = made.b_to_a(*pair)

    share, is_common = overlap(MapSample.from_grid(a), MapSample.from_grid(b), ComplexSimilarity.from_similarity(truth))

    assert share == pytest.approx(measure_agreement(a, b, truth).overlap, abs=0.06)
    assert is_common.dtype == np.bool_


def test_a_map_beside_another_overlaps_nothing():
    sample = MapSample.from_grid(drawing.building())

    assert overlap(sample, sample, ComplexSimilarity(1.0 + 0j, 500 + 0j))[0] == 0.0
    assert overlap(sample, sample, ComplexSimilarity())[0] == 1.0


def test_the_digest_tells_maps_apart_by_cells_resolution_and_origin():
    grid = drawing.building()
    others = (
        OccupancyGrid(grid.occupancy[:-1]),
        OccupancyGrid(grid.occupancy, 0.05),
        OccupancyGrid(grid.occupancy, None, (1.0, 0.0, 0.0)),
    )

    assert digest(grid) == digest(OccupancyGrid(grid.occupancy.copy()))
    assert len({digest(grid), *map(digest, others)}) == 4
