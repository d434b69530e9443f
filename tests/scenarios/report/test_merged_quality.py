import numpy as np
import pytest

from rectmerge.grid import OccupancyGrid
from rectmerge.similarity import Similarity
from scenarios.report.merged_quality import MergedQuality, MergeScene, as_cells
from tests import drawing
from tests.rectmerge.elastic.bent_maps import bent_view, large_building, random_displacement

PLAN = drawing.building()
SCENE = MergeScene(PLAN, PLAN, OccupancyGrid(PLAN.occupancy, 0.05), Similarity(), Similarity())


def test_maps_that_are_the_building_are_perfect():
    assert SCENE.quality(Similarity()) == MergedQuality(1.0, 1.0, 0.0, 1.0, 1.0)


def test_a_map_laid_aside_is_worse_in_everything():
    aside = SCENE.quality(Similarity(tx=6.0))

    assert aside.occupied_f1 < 0.9
    assert aside.free_iou < 0.95
    assert 0.01 < aside.wall_distance_m < 0.3
    assert aside.omega < 0.95
    assert aside.overlap < 0.95


def test_a_bent_map_is_nearer_to_the_building_once_it_is_unbent():
    a, pixels = large_building(), Similarity(0.8, 0.3, 60.0, -40.0)
    truth = random_displacement(1, a.shape, spacing=200, size=14)
    b = bent_view(a, pixels, truth, (560, 720))
    cells = np.argwhere(b.free)[::197, ::-1].astype(float)
    fit = Similarity.fit(cells, truth.apply(pixels.apply(cells)))
    scene = MergeScene(a, b, OccupancyGrid(a.occupancy, 0.05), Similarity(), fit)

    before, after = scene.quality(fit), scene.unbent_quality(fit)

    assert after.occupied_f1 > before.occupied_f1 + 0.05
    assert after.wall_distance_m < 0.7 * before.wall_distance_m


def test_walls_that_no_map_shows_count_as_missed():
    half = OccupancyGrid(PLAN.occupancy[:, :80])

    quality = MergeScene(half, half, SCENE.world, Similarity(), Similarity()).quality(Similarity())

    assert quality.omega == 1.0
    assert quality.occupied_f1 == pytest.approx(2 * 0.5 / 1.5, abs=0.1)
    assert quality.free_iou == pytest.approx(0.5, abs=0.1)


def test_a_line_tells_how_many_maps_it_is_of_and_their_means():
    assert as_cells({"some": [MergedQuality(1.0, 0.8, 0.0, 1.0, 0.5), MergedQuality(0.5, 0.6, 0.1, 1.0, 0.5)]}) == [
        ("some", ["2", "0.750", "0.700", "0.050", "1.000", "0.500"])
    ]
