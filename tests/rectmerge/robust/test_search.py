import math

import numpy as np
import pytest

from rectmerge.overlap import measure_agreement
from rectmerge.robust.cells import MapCells
from rectmerge.robust.features import dominant_angles, extract_features, rectangles_in_frame
from rectmerge.robust.refinement import to_pixels
from rectmerge.robust.search import KEPT, SAME_FIT_CELLS, Ranking, Search, free_overlap, sampled_overlaps
from rectmerge.similarity import Similarity
from tests import naive
from tests.rectmerge.robust import plans
from tests.rectmerge.robust.plans import as_similarity


def searched(a, b, *, bounds=(0.3, 3.0), seed=0):
    """Search with the default numbers; return the search, its ranking, and both maps' features."""
    one, two = (extract_features(MapCells.of(view.grid.occupancy)) for view in (a, b))
    assert one is not None
    assert two is not None
    rng = np.random.default_rng(seed)
    search = Search(
        a=one,
        b=two,
        walls_a=rng.permutation(one.walls),
        walls_b=rng.permutation(two.walls),
        scale_bounds=bounds,
        screened=1000,
        refined=120,
    )
    frames = [[rectangles_in_frame(each, angle, most=200) for angle, _ in dominant_angles(each)] for each in (one, two)]
    return search, search.run(*frames)


def pair(noise=0, cut=1.0, seed=0):
    rooms = plans.office(seed)
    a = plans.see(rooms, degrees=33, window=(-8, -8, 300 * cut + 8, 236), noise=noise, seed=1)
    b = plans.see(rooms, degrees=190, scale=0.8, window=(300 * (1 - cut), -8, 316, 236), noise=noise, seed=2)
    return a, b


def test_the_truth_comes_first_and_the_rest_is_ranked_and_distinct():
    a, b = pair(noise=1, cut=0.7)

    search, ranking = searched(a, b)

    best = as_similarity(to_pixels(ranking.placements[0], search.a, search.b))
    assert plans.is_right(best, a, b)
    assert 1 < len(ranking.placements) <= KEPT
    assert (np.diff(ranking.likelihoods) <= 0).all()
    places = [naive.move(placement, search.b.landmarks) for placement in ranking.placements]
    apart = [np.abs(p - q).max() for i, p in enumerate(places) for q in places[:i]]
    assert min(apart) >= SAME_FIT_CELLS


def test_evidence_for_the_truth_is_good_and_for_the_next_is_not():
    a, b = pair(noise=1)
    search, ranking = searched(a, b)

    first, second = search.evidence(ranking, 0), search.evidence(ranking, 1)

    assert first.rival < 0.6
    assert second.rival > 1
    assert first.missing < 0.05
    assert first.likelihood > second.likelihood
    assert first.overlap > 0.95
    assert first.support > second.support


def test_a_near_double_of_the_best_is_no_rival():
    a, b = pair()
    search, ranking = searched(a, b)
    best = ranking.placements[0]
    doubles = Ranking(np.array([best, best + np.array([0, 0, 2.0, 0])]), np.array([100.0, 99.0]))

    assert search.evidence(doubles).rival == 0.0


@pytest.mark.parametrize("quarter", [1, 2, 3])
def test_a_quarter_turn_about_the_middle_is_a_rival(quarter):
    a, b = pair()
    search, ranking = searched(a, b)
    middle = search.b.walls.mean(axis=0)
    turned = as_similarity(ranking.placements[0]) @ about(middle, quarter * math.pi / 2)
    (p, _, tx), (q, _, ty) = turned.matrix
    both = Ranking(np.array([ranking.placements[0], [p, q, tx, ty]]), np.array([100.0, 99.0]))

    assert search.evidence(both).rival == pytest.approx(0.99)


def about(point, angle):
    turn = Similarity(1.0, angle)
    tx, ty = point - turn.apply(point)
    return Similarity(1.0, angle, float(tx), float(ty))


def test_no_scale_within_bounds_no_ranking():
    a, b = pair()

    _, ranking = searched(a, b, bounds=(30.0, 31.0))

    assert len(ranking.placements) == len(ranking.likelihoods) == 0


def test_the_overlap_of_the_working_grids_is_that_of_the_maps():
    a, b = pair(cut=0.7)
    search, ranking = searched(a, b)

    overlap, iou = free_overlap(ranking.placements[0], search.a, search.b)
    wanted = measure_agreement(a.grid, b.grid, plans.truth(a, b))

    assert (overlap, iou) == pytest.approx((wanted.overlap, wanted.iou), abs=0.03)


def test_sampled_overlaps_are_nearly_those_of_all_cells():
    a, b = pair(noise=1, cut=0.7)
    search, ranking = searched(a, b)

    found = sampled_overlaps(ranking.placements, search.a, search.b)

    wanted = [free_overlap(placement, search.a, search.b)[0] for placement in ranking.placements]
    np.testing.assert_allclose(found, wanted, atol=0.03)
